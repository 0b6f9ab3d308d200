#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Installs calibrations of a simulated machine's spindles, and looks at what is in force then.

    calibrate_test.py PANELCAL REPOSITORY
"""
import json
import math
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path

PANELCAL = str(Path(sys.argv[1]).resolve())
ROOT = Path(sys.argv[2]).resolve()
FIXTURES = ROOT / "tests" / "golden" / "fixtures"
sys.path.insert(0, str(ROOT / "tests" / "support"))
from facts import checked, in_page  # noqa: E402
TRUTH_MM = (45.03, -2.98)
# What nine digits leave of 45 mm.
NANOMETRE_MM = 1e-6


def calibrate(*words, code=0):
    done = subprocess.run([PANELCAL, "calibrate", "spindle-camera", "-m", "machine.toml", *words],
                          capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
    assert done.returncode == code, (words, done.returncode, done.stderr)
    return done.stdout if code == 0 else done.stderr


def entries():
    database = sqlite3.connect("file:drill1.ledger?mode=ro", uri=True)
    rows = database.execute("SELECT content, result FROM ledger_entry ORDER BY id").fetchall()
    database.close()
    return [(json.loads(content), result if isinstance(result, str) else result.decode())
            for content, result in rows]


def calibrations():
    return [entry for entry in entries() if entry[0]["kind"] == "spindle-camera"]


def installed():
    return Path("spindle.cal.json").read_text()


def offsets():
    return {(one["spindle"], one["station"]): one for one in json.loads(installed())["offsets"]}


def sigmas_off(answer):
    """How far an answer is from the truth, in standard deviations of the two axes together."""
    (xx, _), (_, yy) = answer["covariance"]
    dx, dy = (answer["parameters"][i]["value"] - TRUTH_MM[i] for i in (0, 1))
    return math.sqrt(dx * dx / xx + dy * dy / yy)


def main():
    sim = ("--machine-driver", "sim")
    text = calibrate(*sim, "--json", "first.json", "--report", "first.html", "--install", "--reason",
                     "new spindle", "--by", "Ann", "--clock", "2026-11-20T02:00:00Z")
    assert "installed: ledger entry 2" in text, text
    first = checked(json.loads(Path("first.json").read_text()), ROOT)
    assert in_page("first.html") == first
    # 1 in 10000 of a chi-square of two degrees of freedom.
    assert sigmas_off(first) < 4.3, first
    assert first["verdict"] == "installed" and first["objection"] == "" and first["ledger_entry"] == 2
    part = first["spindle_camera"]
    assert part["first"] and part["row"] == 1 and len(part["residuals"]) == part["holes"] + part["left_out"]
    assert part["gates"] and all(gate["passed"] for gate in part["gates"]), part["gates"]
    (taken, state), (entry, result) = entries()
    # The rows first, as they are in the coupon's file.
    assert taken["kind"] == "coupon" and taken["subject"] == "A" and taken["asked_by"] == "Ann"
    assert taken["parameters"] == [{"name": "rows_used", "value": 3, "unit": "1"}], taken
    assert state == Path("coupon.json").read_text()
    assert entry["verdict"] == "installed" and entry["reason"] == "new spindle"
    assert entry["asked_by"] == "Ann" and entry["subject"] == "spindle 1 station 1"
    assert entry["time"] == "2026-11-20T02:00:00Z"
    assert [one["name"] for one in entry["parameters"]] == ["offset_x", "offset_y"]
    assert installed() == result

    # The next one begins with the first, on fresh rows.
    second = checked(json.loads(calibrate(*sim, "--json", "-", "--install", "--by", "Ann",
                                          "--clock", "2026-11-21T02:00:00Z")), ROOT)
    part = second["spindle_camera"]
    assert part["row"] == 4 and not part["first"] and second["ledger_entry"] == 4
    assert abs(part["before_mm"][0] - first["parameters"][0]["value"]) < NANOMETRE_MM
    assert part["shift_chance"] > 1e-4, part
    assert installed() == calibrations()[1][1]

    # A lost file comes back with the next installation; another spindle is added to it.
    Path("spindle.cal.json").unlink()
    text = Path("machine.toml").read_text()
    Path("machine.toml").write_text(text.replace('name = "A"', 'name = "B"'))
    calibrate(*sim, "--install", "--by", "Ann", "--spindle", "2", "--clock",
              "2026-11-22T02:00:00Z")
    both = offsets()
    assert sorted(both) == [(1, 1), (2, 1)]
    assert both[1, 1]["date"] == "2026-11-21T02:00:00Z"
    assert abs(both[1, 1]["offset_mm"][0] - second["parameters"][0]["value"]) < NANOMETRE_MM

    # Without --install nothing changes but the coupon.
    before, n_entries, n_all = installed(), len(calibrations()), len(entries())
    calibrate(*sim, "-o", "aside.cal.json", "--clock", "2026-11-23T02:00:00Z")
    assert installed() == before and len(calibrations()) == n_entries
    assert len(entries()) == n_all + 1
    assert json.loads(Path("aside.cal.json").read_text())["date"] == "2026-11-23T02:00:00Z"
    assert "1 run" not in calibrate(*sim, code=2)
    calibrate(*sim, "--install", "-o", "x.cal.json", code=2)
    calibrate(*sim, "--clock", "yesterday", code=2)

    # A ledger that is something else is found before a row is used up.
    Path("drill1.ledger").rename("old.ledger")
    Path("drill1.ledger").write_text("not a ledger\n" * 100)
    Path("machine.toml").write_text(text.replace('name = "A"', 'name = "C"'))
    state = Path("coupon.json").read_text()
    assert "ledger-foreign" in calibrate(*sim, "--install", code=2)
    assert Path("coupon.json").read_text() == state and installed() == before


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in ("spindle-camera/machine.toml", "camera-200-px/camera.cal.json"):
            shutil.copy(FIXTURES / name, ".")
        with open("machine.toml", "a", encoding="utf-8") as machine:
            machine.write('[ledger]\nfile = "drill1.ledger"\n')
        main()
