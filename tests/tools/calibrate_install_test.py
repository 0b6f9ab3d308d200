#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Installs calibrations of a simulated camera and of a table, and looks at what the ledger has then.

    calibrate_install_test.py PANELCAL REPOSITORY
"""
import json
import os
import random
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
MACHINE = """[machine]
name = "drill 1"
[ledger]
file = "drill1.ledger"
[vision]
search_radius_mm = 0.4
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.3
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[uncertainty]
stage_repeatability_um = 1
[sim]
seed = 5
background = 0.3
target_level = 0.8
noise = 2
[sim.coupon]
stage_repeatability_um = 1
[sim.camera]
scale_mm_per_px = 0.01
rotation_rad = 0.01
k1_per_px2 = 4e-8
"""
SHAKY = MACHINE.replace("[sim.coupon]\nstage_repeatability_um = 1",
                        "[sim.coupon]\nstage_repeatability_um = 8")
PLATE = "[plate]\ncolumns = 9\nrows = 9\npitch_mm = 30\ncertified = true\n"
# The true camera's; the calibration that the machine begins with has another.
ROTATION_RAD = 0.01


def calibrate(what, *words, code=0):
    done = subprocess.run([PANELCAL, "calibrate", what, "-m", "machine.toml", "--clock",
                           "2026-11-20T02:00:00Z", *words],
                          capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
    assert done.returncode == code, (what, words, done.returncode, done.stdout, done.stderr)
    return done.stdout


def facts(what, *words, code=0):
    return checked(json.loads(calibrate(what, *words, "--json", "-", code=code)), ROOT)


def entries():
    database = sqlite3.connect("file:drill1.ledger?mode=ro", uri=True)
    rows = database.execute("SELECT content, result FROM ledger_entry ORDER BY id").fetchall()
    database.close()
    return [(json.loads(content), result if isinstance(result, str) else result.decode())
            for content, result in rows]


def cameras():
    mark = ("--machine-driver", "sim", "--at", "300,100", "--install", "--by", "Ann")
    before = Path("camera.cal.json").read_text()

    # A stage that comes back within 8 um, not 1: refused, recorded, not installed.
    Path("machine.toml").write_text(SHAKY)
    answer = facts("camera", *mark, code=1)
    assert "the limit is 5 um" in answer["objection"] and answer["ledger_entry"] == 1, answer
    assert answer["verdict"] == "refused", answer["verdict"]
    (entry, _), = entries()
    assert entry["verdict"] == "refused" and entry["reason"] == answer["objection"]
    assert Path("camera.cal.json").read_text() == before

    Path("machine.toml").write_text(MACHINE)
    answer = facts("camera", *mark, "--reason", "new lens")
    assert answer["verdict"] == "installed" and answer["ledger_entry"] == 2, answer
    assert answer["objection"] == "" and len(answer["camera"]["residuals"]) == 25, answer
    entry, result = entries()[1]
    assert entry["verdict"] == "installed" and entry["reason"] == "new lens"
    assert entry["subject"] == "camera" and entry["asked_by"] == "Ann"
    assert [one["name"] for one in entry["inputs"]] == ["machine.toml"]
    assert Path("camera.cal.json").read_text() == result
    found = json.loads(result)
    sigma_rad = found["covariance"][1][1] ** 0.5
    assert 0 < sigma_rad < 1e-3, sigma_rad
    assert abs(found["parameters"]["rotation_rad"] - ROTATION_RAD) < 5 * sigma_rad, found

    # Without --install a refused one is not written, and a forced one is.
    source = mark[:4]
    Path("machine.toml").write_text(SHAKY)
    calibrate("camera", *source, "-o", "shaky.cal.json", code=1)
    assert not Path("shaky.cal.json").exists()
    forced = facts("camera", *source, "-o", "shaky.cal.json", "--force")
    assert forced["verdict"] == "written" and "the limit is 5 um" in forced["objection"], forced
    assert Path("shaky.cal.json").exists() and len(entries()) == 2
    Path("machine.toml").write_text(MACHINE)


def looks(noise_mm):
    """A table of 100 ppm in x, seen by whatever vision system."""
    draw = random.Random(7)
    lines = []
    for row in range(9):
        for column in range(9):
            x_mm, y_mm = 100 + 30 * column, 100 + 30 * row
            seen = [-1e-4 * (x_mm - 220) + draw.gauss(0, noise_mm), draw.gauss(0, noise_mm)]
            lines.append({"pose": 0, "axis": [x_mm, y_mm], "dot": [column, row], "seen": seen,
                          "cov": [1e-6, 0, 1e-6]})
    return lines


def write_looks(lines):
    Path("looks.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))


def tables():
    Path("plate.toml").write_text(PLATE + "[[pose]]\norigin_mm = [100, 100]\n")
    n_before = len(entries())
    source = ("--plate", "plate.toml", "--measurements", "looks.jsonl", "--install")

    write_looks(looks(0.05))
    answer = facts("table", *source, "-o", "table.cal.json", code=1)
    assert "the limit is" in answer["objection"], answer
    assert entries()[-1][0]["verdict"] == "refused" and not Path("table.cal.json").exists()

    # One dot that dirt covers in part: left out, and the rest is as good as it was.
    lines = looks(0.001)
    lines[40]["seen"][0] += 0.2
    write_looks(lines)
    text = calibrate("table", *source, "-o", "table.cal.json", "--report", "table.html")
    assert "without dot 40 from" in text and "does not apply this map" in text, text
    assert len(entries()) == n_before + 2
    entry, result = entries()[-1]
    assert entry["verdict"] == "installed" and entry["subject"] == "table"
    assert [one["name"] for one in entry["inputs"]] == ["machine.toml", "looks.jsonl", "plate.toml"]
    assert Path("table.cal.json").read_text() == result
    assert "into the ledger alone" not in text, text
    text = calibrate("table", *source)
    assert "into the ledger alone: no file is named for it (-o)" in text, text
    scale_x = json.loads(result)["geometry"]["scale_x"]
    # 1 um in each of 81 looks over 240 mm leaves 1.6 ppm of a scale.
    assert abs(scale_x - 1e-4) < 8e-6, scale_x
    check_map(checked(in_page("table.html"), ROOT)["table"])


def check_map(part):
    """Of the true table: 100 ppm in x, nothing in y; where it lies is convention."""
    assert len(part["residuals"]) == 80 and len(part["left_out"]) == 1, part
    shown = part["map"]
    assert shown["columns"] * shown["rows"] == len(shown["error_um"]) == len(shown["covariance_um2"])
    width_mm = shown["step_mm"][0] * (shown["columns"] - 1)
    assert abs(width_mm - 240) < 1e-9, width_mm
    for row in range(shown["rows"]):
        first, last = (shown["error_um"][row * shown["columns"] + i] for i in (0, shown["columns"] - 1))
        # Ten sigmas of a corner, as the map itself states them.
        sigma_um = shown["covariance_um2"][0][0] ** 0.5
        assert abs(last[0] - first[0] - 0.1 * width_mm) < 10 * sigma_um < 10, (row, first, last, sigma_um)
        assert abs(last[1] - first[1]) < 10 * sigma_um, (row, first, last)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        shutil.copy(FIXTURES / "camera-200-px" / "camera.cal.json", "camera.cal.json")
        Path("machine.toml").write_text(MACHINE)
        cameras()
        tables()
