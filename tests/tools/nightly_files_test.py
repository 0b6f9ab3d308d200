#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What nights leave in their folder: reports that are not lost, and calibrations that come back.

    nightly_files_test.py PANELCAL REPOSITORY
"""
import fcntl
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PANELCAL = str(Path(sys.argv[1]).resolve())
FIXTURES = Path(sys.argv[2]).resolve() / "tests" / "golden" / "fixtures"


def night(clock, code, *words):
    done = subprocess.run([PANELCAL, "nightly", "-m", "machine.toml", "--clock", clock, *words],
                          capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (clock, done.returncode, done.stdout, done.stderr)
    return done


def reports():
    return sorted(path.name for path in Path("reports").glob("*.html"))


def record(name):
    return json.loads(Path("reports", name + ".json").read_text())


def main():
    # A machine that runs already: a run that did nothing leaves no page.
    with open("drill1.ledger.lock", "w", encoding="utf-8") as lock:
        fcntl.lockf(lock, fcntl.LOCK_EX)
        assert "ledger-busy" in night("2026-11-20T23:00:00Z", 3).stderr
        assert not Path("reports").exists()

    night("2026-11-20T23:00:00Z", 0)
    assert reports() == ["2026-11-20.html"]
    page = Path("reports/2026-11-20.html").read_bytes()
    assert record("2026-11-20")["steps"][0]["holes"]

    # A run with nothing to do does not take the place of the one that measured.
    night("2026-11-20T23:30:00Z", 0)
    assert reports() == ["2026-11-20-2.html", "2026-11-20.html"]
    assert Path("reports/2026-11-20.html").read_bytes() == page

    # A clock far ahead leaves nothing that would hold the nights after it.
    assert "ledger-entry-invalid" in night("2126-11-20T23:00:00Z", 2).stderr

    # A damaged calibration is written again, and the night goes on.
    good = Path("spindle.cal.json").read_text()
    Path("spindle.cal.json").write_text(good[:20])
    night("2026-11-21T23:00:00Z", 0)
    assert any("written again" in note for note in record("2026-11-21")["notes"])
    assert json.loads(Path("spindle.cal.json").read_text())["offsets"]

    # One that a person has made is neither lost nor drilled with unseen.
    mine = json.loads(Path("spindle.cal.json").read_text())
    mine["date"] = "2026-11-22T09:00:00Z"
    mine["offsets"][0]["offset_mm"][0] += 0.02
    for one in mine["offsets"]:
        if "date" in one:
            one["date"] = mine["date"]
    Path("spindle.cal.json").write_text(json.dumps(mine))
    by_hand = Path("spindle.cal.json").read_text()
    assert "is not in the ledger" in night("2026-11-22T23:00:00Z", 1).stdout
    assert Path("spindle.cal.json").read_text() == by_hand
    assert record("2026-11-22")["may_drill"] is False
    Path("spindle.cal.json").unlink()
    night("2026-11-23T03:00:00Z", 0)
    assert record("2026-11-22")["may_drill"] is True

    # A problem that panelcal cannot mend is said where people look in the morning; a dry run leaves no traces.
    Path("camera.cal.json").write_text("{")
    night("2026-11-23T23:00:00Z", 2, "--dry-run")
    assert "2026-11-23.html" not in reports()
    night("2026-11-23T23:00:00Z", 2)
    assert record("2026-11-23")["may_drill"] is False
    assert "do not drill" in record("2026-11-23")["verdict"]

    night("2026-11-24T23:00:00Z", 2, "--temperature", "nan")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in ("night/machine.toml", "camera-320-px/camera.cal.json"):
            shutil.copy(FIXTURES / name, ".")
        main()
