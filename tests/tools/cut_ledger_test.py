#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A night and a calibration by hand are held before anything moves while calibrations and reports note entries that the ledger lacks.

    cut_ledger_test.py PANELCAL REPOSITORY
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import real_files

PANELCAL = str(Path(sys.argv[1]).resolve())
LEDGER, COUPON, SPINDLE = (Path(name) for name in ("drill1.ledger", "coupon.json", "spindle.cal.json"))


def panelcal(*words, code=0):
    done = subprocess.run([PANELCAL, *words], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done


def night(day, *words, code=0):
    return panelcal("nightly", "-m", "machine.toml", "--clock", f"2026-11-{day}T02:00:00Z", *words,
                    code=code)


def check(code):
    return panelcal("check", "-m", "machine.toml", "--clock", "2026-11-24T02:00:00", code=code)


def rows_used():
    return json.loads(COUPON.read_text())["rows_used"] if COUPON.exists() else None


def state():
    """The ledger's entries, and the bytes of the others."""
    entries = panelcal("history", "export", "-l", str(LEDGER)).stdout if LEDGER.exists() else ""
    return [entries, *(file.read_bytes() if file.exists() else b"" for file in (COUPON, SPINDLE))]


def calibrate(code, *words):
    return panelcal("calibrate", "spindle-camera", "-m", "machine.toml", "--machine-driver", "sim",
                    "--clock", "2026-11-24T02:00:00Z", *words, code=code)


def job(code):
    """A job that calibrates the spindle itself (G39)."""
    Path("job.exc").write_text("M48\nMETRIC,TZ\nT1C0.8F100\n%\nG34,2\nG39\nG35X10.0Y10.0\nT1\n"
                               "X20.0Y20.0\nM30\n")
    return panelcal("run", "job.exc", "-m", "machine.toml", "--machine-driver", "sim",
                    "-o", "job.jsonl", code=code)


def is_held(remedy="the newest copy of the ledger"):
    """A night, a dry run, a calibration by hand and a check of machine.toml find it; nothing is
    drilled or recorded."""
    before = state()
    for done in (night(24, code=3), night(24, "--dry-run", code=3), check(3), calibrate(3),
                 calibrate(3, "--install"), job(3)):
        assert "error[ledger-cut-off]" in done.stderr, done
        assert remedy in done.stderr, done
    page = json.loads(max(Path("reports").glob("2026-11-23*.json"),
                          key=lambda path: path.stat().st_mtime_ns).read_text())
    assert page["may_drill"] is False and "notes entry" in page["verdict"], page
    assert state() == before


def put_back(folder):
    """The state of an earlier time, whole: what was not there then goes."""
    for file in (LEDGER, COUPON, SPINDLE, Path("reports")):
        if file.is_dir():
            shutil.rmtree(file)
        else:
            file.unlink(missing_ok=True)
    shutil.copytree(folder, ".", dirs_exist_ok=True)


def keep(folder):
    Path(folder).mkdir()
    for file in (LEDGER, COUPON, SPINDLE):
        shutil.copy2(file, folder)
    shutil.copytree("reports", Path(folder, "reports"))


def main():
    shutil.copy(Path(sys.argv[2]) / "tests/golden/fixtures/camera-320-px/camera.cal.json", ".")
    Path("temperature.txt").write_text("21.5\n")
    shutil.copy(Path(sys.argv[2]) / "datasets/demo/images/0000.png", "template.png")
    text = real_files.MACHINE.replace("[nightly]\n", '[nightly]\nreports = "reports"\n')
    text = text.replace("rows = 300", "rows = 150")
    Path("machine.toml").write_text(text)
    night(21)
    keep("old")
    night(22)
    night(23)
    keep("new")
    assert rows_used() == 9
    check(0)

    # One backup put back: ledger, coupon's state and calibration agree, the reports do not.
    for name in ("drill1.ledger", "coupon.json", "spindle.cal.json"):
        shutil.copy(Path("old", name), name)
    is_held()
    # The calibration of today notes it without any report.
    put_back("new")
    shutil.rmtree("reports")
    for name in ("drill1.ledger", "coupon.json"):
        shutil.copy(Path("old", name), name)
    is_held()
    assert "move it away" not in night(24, code=3).stderr
    # All of it away but what notes it.
    put_back("new")
    for file in (LEDGER, COUPON):
        file.unlink()
    is_held()
    assert not LEDGER.exists(), "a ledger is begun although another one is looked for"
    # The remedy: the newest copy is whole, and the held nights have left nothing that it lacks.
    shutil.copy(Path("new", "drill1.ledger"), LEDGER)
    check(0)
    night(24)
    assert rows_used() == 12  # of the ledger, whose count the coupon's file has lost
    calibrate(0)
    assert rows_used() == 15
    job(0)
    assert rows_used() == 18

    # The other way out: a new coupon and a new ledger, beside nothing that notes the old one.
    put_back("new")
    LEDGER.unlink()
    is_held(remedy="write its name into [coupon] name")
    Path("machine.toml").write_text(text.replace('name = "A"', 'name = "B"'))
    shutil.move("reports", "reports of before")
    assert "notes entry" in check(3).stderr
    spindle = json.loads(SPINDLE.read_text())
    del spindle["ledger"]
    SPINDLE.write_text(json.dumps(spindle))
    check(0)
    night(24)
    assert json.loads(COUPON.read_text())["coupon"] == "B" and rows_used() == 3
    Path("machine.toml").write_text(text)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        main()
