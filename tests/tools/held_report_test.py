#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `run` makes of [tolerance]: a held job's facts have the budget that its message points at, and the
place that a warning names can be asked for.

    held_report_test.py PANELCAL
"""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

# sigma of the hole is 1 um: P(|e| > r) = exp(-r^2 / 2), above hold_probability at 2 um, a warning at 4 um.
MACHINE = ("[machine]\nname = \"small\"\n[gates]\noffset_mm = 1.5\n[tolerance]\nposition_um = {}\n"
           "[uncertainty]\nstage_repeatability_um = 0\ntable_residual_um = 0\ndrill_wander_um = 0\n")
MEASUREMENT = ('{"seq":0,"line":7,"command":"G35","tool":1,"nominal":[0,0],"expected":[0,0],"path":[],'
               '"measured":[0.25,-0.5],"cov":[1e-06,0,1e-06],"status":"found"}\n')
PROGRAM = "M48\nMETRIC,LZ\nT1C1.0F100\n%\nG34,1\nT1\nG35X0.0Y0.0\n"


def run(panelcal, folder, *arguments):
    return subprocess.run([panelcal, "run", "program.exc", "-m", "machine.toml", "--measurements",
                           "measurements.jsonl", *arguments], cwd=folder, capture_output=True,
                          text=True, timeout=60)


def prepare(folder, position_um, body):
    (folder / "machine.toml").write_text(MACHINE.format(position_um))
    (folder / "measurements.jsonl").write_text(MEASUREMENT)
    (folder / "program.exc").write_text(PROGRAM + body + "M30\n")


def held_job_has_its_budget(panelcal, folder):
    prepare(folder, 2, "X10.0Y20.0\n")
    done = run(panelcal, folder, "-o", "out.jsonl", "--report", "held.html", "--json", "held.json", "--clock",
               "2026-11-21T13:45:00")
    assert done.returncode == 1, done.stderr
    assert not (folder / "out.jsonl").exists()
    assert (folder / "held.html").exists()
    facts = json.loads((folder / "held.json").read_text())
    assert facts["verdict"]["word"] == "hold", facts["verdict"]
    assert {"key": "date", "value": "2026-11-21T13:45:00"} in facts["provenance"]
    budget = facts["budget"]
    assert budget["is_likeliest_to_break"] and f"{budget['risk']:.2g}" == "0.14", budget
    assert (budget["line"], budget["tool"], budget["nominal_mm"]) == (8, 1, [10, 20]), budget
    detector = budget["terms"][0]
    assert detector["source"] == "detector", budget
    assert [round(v, 9) for v in detector["covariance_um2"]] == [1, 0, 1], detector


def place_of_a_pattern_can_be_asked_for(panelcal, folder):
    (folder / "PINS").write_text("X0.0Y0.0\nX2.0\n")
    prepare(folder, 4, "M99,PINS\nX10.0Y20.0\n")
    done = run(panelcal, folder, "-o", "out.jsonl", "--json", "-")
    assert done.returncode == 0, done.stderr
    verdict = json.loads(done.stdout)["verdict"]
    assert verdict["word"] == "warned", verdict
    hint = re.search(r"run --explain (\w+) \(.*the worst is line (\S+):(\d+), risk", verdict["next"])
    assert hint, verdict
    number, file, line = hint.groups()
    assert number.isdigit(), number
    explained = run(panelcal, folder, "--explain", number).stdout
    assert f"drill {number}: {file}:{line}: X" in explained, explained


def main():
    panelcal = str(Path(sys.argv[1]).resolve())
    for check in (held_job_has_its_budget, place_of_a_pattern_can_be_asked_for):
        with tempfile.TemporaryDirectory() as folder:
            check(panelcal, Path(folder))


if __name__ == "__main__":
    main()
