#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Calibrates focus and lamp of a simulated machine with --install, looks at what the ledger has then,
and that a machine that another run holds does not move.

    calibrate_place_test.py PANELCAL REPOSITORY
"""
import fcntl
import json
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
from facts import checked  # noqa: E402
MACHINE = """[machine]
name = "drill 1"
LEDGER
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.3
[camera]
calibration = "camera.cal.json"
focus_range_mm = [-1, 1]
CAMERA
[spindle]
camera_offset_mm = [45.0, -3.0]
[sim]
seed = 5
noise = 2
background = 0.3
target_level = 0.8
lamp = 50
focus_z_mm = FOCUS
focus_depth_mm = 0.2
"""
LEDGER = '[ledger]\nfile = "drill1.ledger"'
NIGHTLY = """[nightly]
machine_driver = "sim"
calibrate = ["focus"]
mark_mm = [300, 100]
temperature_file = "celsius.txt"
"""
MARK = ("--machine-driver", "sim", "--at", "300,100", "--clock", "2026-11-20T02:00:00Z")
# What six digits of a height leave.
SAME_MM = 1e-5


def write_machine(focus_mm=0.137, camera="", ledger=LEDGER, more=""):
    Path("machine.toml").write_text(MACHINE.replace("FOCUS", str(focus_mm)).replace(
        "CAMERA", camera).replace("LEDGER", ledger) + more)


def panelcal(*words, code=0):
    done = subprocess.run([PANELCAL, *words], capture_output=True, text=True, timeout=60,
                          stdin=subprocess.DEVNULL)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done.stderr if code > 1 else done.stdout


def calibrate(what, *words, code=0):
    return panelcal("calibrate", what, "-m", "machine.toml", *MARK, *words, code=code)


def facts(what, *words, code=0):
    """The document, and the part of its kind."""
    document = checked(json.loads(calibrate(what, "--json", "-", *words, code=code)), ROOT)
    return document, document[what]


def history(*words, code=0):
    return panelcal("history", *words, "-l", "drill1.ledger", code=code)


def entries():
    database = sqlite3.connect("file:drill1.ledger?mode=ro", uri=True)
    rows = database.execute("SELECT content, result FROM ledger_entry ORDER BY id").fetchall()
    database.close()
    return [(json.loads(content), result if isinstance(result, str) else result.decode())
            for content, result in rows]


def in_force():
    listed = json.loads(history("list", "--json", "-"))["entries"]
    return sorted((one["kind"], one["id"]) for one in listed if one["in_force"])


def focus():
    write_machine()
    install = ("--install", "--by", "Ann", "--reason", "new lens")
    document, answer = facts("focus", *install)
    assert abs(answer["z_mm"] - 0.137) < 5 * answer["sigma_mm"] < 0.1, answer
    assert document["verdict"] == "installed" and document["ledger_entry"] == 1, document
    assert document["parameters"] == [{"name": "height", "value": answer["z_mm"], "unit": "mm"}], document
    assert "says no focus_mm" in answer["stated_otherwise"], answer
    (entry, result), = entries()
    assert entry["kind"] == "focus" and entry["subject"] == "camera", entry
    assert entry["verdict"] == "installed" and entry["reason"] == "new lens"
    assert entry["asked_by"] == "Ann" and entry["time"] == "2026-11-20T02:00:00Z"
    assert [one["name"] for one in entry["inputs"]] == ["machine.toml", "camera.cal.json"]
    parameter, = entry["parameters"]
    assert (parameter["name"], parameter["unit"]) == ("height", "mm"), parameter
    assert abs(parameter["value"] - answer["z_mm"]) < SAME_MM
    assert abs(entry["covariance"][0][0] ** 0.5 - answer["sigma_mm"]) < SAME_MM
    assert json.loads(result)["curve"] == answer["curve"]

    # As a person does after the hint. Measured again without --install, nothing is recorded or said.
    text = calibrate("focus", *install)
    hint = text.split("the line for machine.toml: [camera] ")[1].splitlines()[0]
    assert hint.startswith("focus_mm = 0.1"), hint
    write_machine(camera=hint)
    assert "ledger" not in calibrate("focus") and len(entries()) == 2

    # The camera was mounted anew: the next one says so, with the temperature as nights have it.
    Path("celsius.txt").write_text("21.5\n")
    write_machine(focus_mm=0.6, camera=hint, more=NIGHTLY)
    text = calibrate("focus", *install)
    assert "entry 3" in text and "write [camera] focus_mm = 0.6" in text, text
    assert entries()[2][0]["temperature_degC"] == 21.5 and in_force() == [("focus", 3)]
    # A later run says it again, without --install.
    assert "write [camera] focus_mm = 0.6" in calibrate("focus")

    # No peak: recorded as refused, and nothing of what is in force changes.
    document, answer = facts("focus", "--range", "-1,-0.5", *install, code=1)
    assert not answer["found"] and document["ledger_entry"] == 4, document
    assert document["verdict"] == "refused" and document["objection"] == answer["reason"], document
    assert entries()[3][0]["verdict"] == "refused" and in_force() == [("focus", 3)]


def asked_of_history():
    key = ("--machine", "drill 1", "--kind", "focus", "--subject", "camera")
    assert "height" in history("show", "3") and "curve" in history("show", "3", "--result")
    assert "height" in history("diff", "2", "3")
    assert "height of focus camera" in history("plot", *key, "--parameter", "height")
    history("rollback", *key, "--reason", "the old mount is back")
    assert in_force() == [("focus", 2)]
    # What the first hint said holds again.
    write_machine(focus_mm=0.137, camera="focus_mm = 0.137")
    assert "machine.toml" not in calibrate("focus")
    history("verify")


def light():
    n_before = len(entries())
    write_machine(camera="lamp = 20")
    _, answer = facts("light", "--install", "--by", "Ann")
    # The disc clips at 50 / 0.8 = 62.5.
    assert answer["level"] == 60 and "write [camera] lamp = 60" in answer["stated_otherwise"], answer
    entry, _ = entries()[-1]
    assert entry["kind"] == "light" and len(entries()) == n_before + 1
    assert entry["parameters"][0]["value"] == 60
    assert abs(entry["covariance"][0][0] - 100 / 12) < 1e-6
    assert "light  camera" in history("list", "--kind", "light")
    write_machine(camera="lamp = 60")
    assert "stated_otherwise" not in facts("light")[1]


def held_by_another():
    """Before anything moves, with --install or without."""
    n_before = len(entries())
    with open("drill1.ledger.lock", "r+", encoding="utf-8") as lock:
        fcntl.lockf(lock, fcntl.LOCK_EX)
        for what in ("focus", "light", "settle"):
            for words in ((), ("--install",)):
                said = calibrate(what, *words, code=3)
                assert "ledger-busy" in said and "drill1.ledger.lock" in said, said
    assert len(entries()) == n_before
    calibrate("focus")
    # The virtual machine stands still at once, as far as its looks can tell; with the lock free.
    _, settle = facts("settle", "--limit-um", "5", "--install")
    assert settle["wait_s"] == 0 and 0 < settle["sigma_s"] < 0.01, settle
    assert len(entries()) == n_before + 1


def without_ledger():
    write_machine(ledger="")
    for what in ("focus", "light", "settle"):
        assert "[config-value]" in calibrate(what, "--install", code=2)
    calibrate("focus")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        shutil.copy(FIXTURES / "camera-200-px" / "camera.cal.json", "camera.cal.json")
        focus()
        asked_of_history()
        light()
        held_by_another()
        without_ledger()
