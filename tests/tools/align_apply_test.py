#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""G-code follows an aligned board: `align apply` and `filter` put every place where `run --align` drills,
and write nothing where the alignment does not hold.

    align_apply_test.py PANELCAL
"""
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from aligned_panel import PADS, PTH, Panel, machine_text, prepare
from demo_job import drilled, run

GCODE_SETTINGS = """[gcode]
safe_z_mm = 5
approach_z_mm = 1
change_z_mm = 30
drill_z_mm = -1.8
rout_z_mm = -2
infeed_mm_s = 20
speed_rpm = 30000
"""
ALIGNED = ("-m", "machine.toml", "--align", "board.align.json")
# Digits of G-code, mm, beside those of JSON Lines.
DIGITS_MM = 1.1e-5
TILT = (0.05, 0.0004, -0.0003)  # of the board: at (0, 0), along x, along y


def drill_program():
    """In the style of FlatCAM."""
    holes = "".join(f"G00 X{x:.4f} Y{y:.4f}\nG01 Z-1.7000\nG01 Z0\nG00 Z2.0000\n" for x, y in PTH)
    return f"(drilling)\nG21\nG90\nG94\n\nG01 F300.00\nG00 Z15.0000\nM03 S10000\nG00 Z2.0000\n{holes}M05\nM2\n"


def prepare_board(panelcal, folder, seed):
    panel = Panel(seed)
    prepare(folder, panel)
    (folder / "machine.toml").write_text(machine_text(panel) + GCODE_SETTINGS)
    run(panelcal, "align", ";".join(f"{x},{y}" for x, y in PADS), "-m", "machine.toml", "--machine-driver",
        "sim", "-o", "board.align.json", cwd=folder)
    return panel


def places(text):
    """X and Y of all lines that have both."""
    found = re.findall(r"^[^(]*?X(-?[\d.]+) Y(-?[\d.]+)", text, re.MULTILINE)
    return [(float(x), float(y)) for x, y in found]


def same(found, expected, tolerance):
    assert len(found) == len(expected) > 0, (len(found), len(expected))
    for one, other in zip(found, expected):
        assert math.dist(one, other) <= tolerance, (one, other)


def filtered(panelcal, folder, *arguments, expect=0, **environment):
    result = subprocess.run([panelcal, "filter", *arguments], cwd=folder, capture_output=True, text=True,
                            env={**os.environ, **environment})
    assert result.returncode == expect, result
    return result


def gcode_is_drilled_where_a_drill_file_is(panelcal, folder):
    panel = prepare_board(panelcal, folder, 0)
    (folder / "drill.ngc").write_text(drill_program())
    said = run(panelcal, "align", "apply", "drill.ngc", *ALIGNED, "-o", "moved.ngc", cwd=folder).stderr
    assert f"moved {len(PTH)} of " in said and "largest predicted sigma" in said, said
    text = (folder / "moved.ngc").read_text()
    assert text.startswith("(moved by panelcal: made by: panelcal "), text
    found = places(text)
    run(panelcal, "run", "pth.drl", *ALIGNED, "-o", "pth.jsonl", cwd=folder)
    same(found, [hole["actual"] for hole in drilled(folder / "pth.jsonl")], DIGITS_MM)
    same(found, [panel.actual(place) for place in PTH], 5e-3)
    # Everything else stays.
    bare = re.sub(r"^\(moved by .*\n", "", text, flags=re.MULTILINE)
    assert re.sub(r" X\S+ Y\S+", "", bare) == re.sub(r" X\S+ Y\S+", "", drill_program()), bare
    # The same by the filter, and of the drill file.
    by_filter = filtered(panelcal, folder, *ALIGNED, "drill.ngc", AXIS_PROGRESS_BAR="1")
    same(places(by_filter.stdout), found, 0)
    assert re.search(r"^FILTER_PROGRESS=0\n(.*\n)*FILTER_PROGRESS=100\n", by_filter.stderr, re.MULTILINE), by_filter
    of_drill = filtered(panelcal, folder, *ALIGNED, "pth.drl")
    assert "FILTER_PROGRESS" not in of_drill.stderr, of_drill.stderr
    holes = dict.fromkeys(places(of_drill.stdout))
    same(sorted(holes), sorted(tuple(hole["actual"]) for hole in drilled(folder / "pth.jsonl")), 1e-4)


def arcs_and_heights_follow_too(panelcal, folder):
    panel = prepare_board(panelcal, folder, 1)
    (folder / "probes.txt").write_text("".join(
        f"{x} {y} {TILT[0] + TILT[1] * x + TILT[2] * y} 0 0 0 0 0 0\n"
        for x in range(-5, 96, 10) for y in range(-5, 76, 10)))
    run(panelcal, "surface", "fit", "probes.txt", "-o", "map.json", cwd=folder)
    (folder / "outline.ngc").write_text(
        "G21 G90 G94 G17 G91.1\nG0 Z2\nG0 X10 Y30\nG1 Z-0.1 F100\nG2 X20 Y40 I10 F200\nG1 X60\nG0 Z2\nM2\n")
    run(panelcal, "align", "apply", "outline.ngc", *ALIGNED, "--surface", "map.json", "-o", "moved.ngc",
        cwd=folder)
    text = (folder / "moved.ngc").read_text()
    assert re.search(r"^G2 F200 X", text, re.MULTILINE), text
    x, y, z = map(float, re.findall(r"X(\S+) Y(\S+) Z(\S+)", text)[-1])
    assert math.dist((x, y), panel.actual((60, 40))) < 5e-3, (x, y)
    assert abs(z + 0.1 - TILT[0] - TILT[1] * x - TILT[2] * y) < 2e-3, z
    # A refusal names the line of the program, not of what was made of it.
    (folder / "beyond.ngc").write_text("o1 sub\nX20\nX10\no1 endsub\nG21 G90 G94\nG0 Z2\nG0 X10 Y30\nG1 Z-0.1 F9\n"
                                       "o1 call\nG1 X400\nG0 Z2\nM2\n")
    beyond = run(panelcal, "align", "apply", "beyond.ngc", *ALIGNED, "--surface", "map.json", "-o", "no.ngc",
                 cwd=folder, expect=2).stderr
    assert "beyond.ngc:10:1: error[" in beyond, beyond


def nothing_is_written_where_the_alignment_does_not_hold(panelcal, folder):
    prepare_board(panelcal, folder, 2)
    (folder / "drill.ngc").write_text(drill_program())

    def refused(words, expect, *arguments, aligned=ALIGNED):
        result = run(panelcal, "align", "apply", *arguments, *aligned, "-o", "no.ngc", cwd=folder, expect=expect)
        assert words in result.stderr, result.stderr
        assert not (folder / "no.ngc").exists()

    refused("at most 0.01 um", 1, "drill.ngc", "--max-sigma-um", "0.01")
    (folder / "far.ngc").write_text("G21 G90 G94\nG0 X120 Y-80\nG1 X150 Y-60 F9\nM2\n")
    refused("(120.000, -80.000) to (150.000, -60.000)", 2, "far.ngc")
    # From the board's middle, and the pads from its corner: 35 by 25 mm are half of them.
    (folder / "middle.ngc").write_text("G21 G90 G94\nG0 X-32 Y-20\nG1 X35 Y20 F9\nM2\n")
    refused("(-32.000, -20.000) to (35.000, 20.000)", 2, "middle.ngc")
    (folder / "variable.ngc").write_text("G21 G90 G94\nG0 X20 Y20\nG1 X#1 F9\nM2\n")
    refused("variable.ngc:3:4: error[not-supported]", 2, "variable.ngc")
    run(panelcal, "align", "apply", "drill.ngc", *ALIGNED, "-o", "moved.ngc", cwd=folder)
    refused("moved before", 2, "moved.ngc")
    (folder / "other.toml").write_text((folder / "machine.toml").read_text() + "# changed\n")
    other = ("-m", "other.toml", "--align", "board.align.json")
    refused("another machine file", 2, "drill.ngc", aligned=other)
    for program, expect, words in (("drill.ngc", 1, "at most 0.01 um"), ("pth.drl", 2, "[tolerance] in machine.toml")):
        result = filtered(panelcal, folder, *ALIGNED, program, "--max-sigma-um", "0.01", expect=expect)
        assert not result.stdout and words in result.stderr, result
    missing = ("-m", "machine.toml", "--align", "none.align.json")
    path = folder / "board.align.json"
    document = json.loads(path.read_text())
    document["time"] = "2020-01-01T00:00:00Z"
    (folder / "old.align.json").write_text(json.dumps(document))
    old = ("-m", "machine.toml", "--align", "old.align.json")
    refused("limit 4 hours", 1, "drill.ngc", aligned=old)
    for aligned in (other, missing, old):
        for program in ("drill.ngc", "pth.drl"):
            result = filtered(panelcal, folder, *aligned, program, expect=1)
            assert not result.stdout and "error[" in result.stderr, result


def main(panelcal):
    for test in (gcode_is_drilled_where_a_drill_file_is, arcs_and_heights_follow_too,
                 nothing_is_written_where_the_alignment_does_not_hold):
        with tempfile.TemporaryDirectory() as folder:
            test(panelcal, Path(folder))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
