#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`history diff --program` predicts the run with another camera calibration.

    history_job_test.py PANELCAL REPOSITORY
"""
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PANELCAL = str(Path(sys.argv[1]).resolve())
ROOT = Path(sys.argv[2]).resolve()
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tests" / "golden"))
import golden_ledger  # noqa: E402

# Targets' centres move by less than this when the lens is another one, since they are fitted in
# undistorted millimetres.
REFIT_MM = 5e-6


def panelcal(*words):
    done = subprocess.run([PANELCAL, *words], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, (words, done.returncode, done.stderr)
    return done.stdout


def drilled(machine, save=None):
    panelcal("run", "demo/panel.exc", "-m", machine, "--images", "demo/images", "-o", "out.jsonl",
             *(["--save-measurements", save] if save else []))
    operations = [json.loads(line) for line in Path("out.jsonl").read_text().splitlines()]
    return [operation["actual"] for operation in operations if operation["op"] == "drill"]


def main():
    shutil.copytree(ROOT / "datasets" / "demo", "demo")
    machine = Path("demo/machine.toml").read_text()
    # With the other camera targets of a job that was measured with this one do not agree.
    Path("demo/machine.toml").write_text(
        machine.replace("[gates]", "[gates]\nfalse_alarm = \"off\"\n#", 1))
    before = Path("demo/camera.cal.json").read_text()
    after = json.loads(before)
    after["parameters"]["scale_mm_per_px"] *= 1.01
    after["parameters"]["rotation_rad"] += 0.01
    after["parameters"]["axis_px"][0] += 0.3
    after = json.dumps(after)
    entries = []
    for result in (before, after):
        entry, _ = golden_ledger.offset(0, 0, "2026-11-20T02:00:00Z", subject="camera")
        entry.update(machine="demo driller", kind="camera", parameters=[], covariance=None,
                     replaces=len(entries) or None)
        entries.append((entry, result))
    golden_ledger.make("drill.ledger", entries).close()

    holes = drilled("demo/machine.toml", "measured.jsonl")
    said = json.loads(panelcal("history", "diff", "1", "2", "-l", "drill.ledger", "--json", "-",
                               "--program", "demo/panel.exc", "-m", "demo/machine.toml",
                               "--measurements", "measured.jsonl", "--report", "shift.html"))
    said = said["difference"]["job"]
    Path("demo/camera.cal.json").write_text(after)
    shifts = [math.dist(a, b) for a, b in zip(holes, drilled("demo/machine.toml"), strict=True)]
    rms = math.sqrt(sum(s * s for s in shifts) / len(shifts))
    print(f"{len(shifts)} holes, largest shift {max(shifts) * 1e3:.3f} um, "
          f"predicted {said['max_mm'] * 1e3:.3f} um; rms {rms * 1e3:.3f} and "
          f"{said['rms_mm'] * 1e3:.3f} um")
    assert said["holes"] == len(shifts) == 990
    assert max(shifts) > 0.002, "a change that is too small to be seen proves nothing"
    assert abs(max(shifts) - said["max_mm"]) < REFIT_MM
    assert abs(rms - said["rms_mm"]) < REFIT_MM
    assert said["worst"]["shift_mm"] in [one["shift_mm"] for one in said["sample"]] or len(said["sample"]) < len(shifts)
    assert '"facts":"history"' in Path("shift.html").read_text()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main()
