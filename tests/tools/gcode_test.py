#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""G-code of `panelcal run`: LinuxCNC's interpreter goes where JSON Lines say, and `surface apply` reads it.
The other flavours lead to the same places, in words that their controls know.

    gcode_test.py PANELCAL ROOT

With GRBL's firmware as a program (PANELCAL_GRBL: the folder of grbl_sim) every line is shown to it as well.
"""
import json
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

import canonical
from demo_job import run

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "machine/devices/controls/grbl"))
import firmware  # noqa: E402

SAFE, APPROACH, DRILL, ROUT = 5.0, 1.0, -1.8, -2.0
GCODE = f"""
[gcode]
safe_z_mm = {SAFE}
approach_z_mm = {APPROACH}
change_z_mm = 30
drill_z_mm = {DRILL}
rout_z_mm = {ROUT}
peck_mm = 0.7
infeed_mm_s = 20
rapid_mm_s = 50
speed_rpm = 30000
"""
# rs274 prints a ten-thousandth of a millimetre.
TOLERANCE = 1e-4
TILT = (0.05, 0.0004, -0.0003)  # of the board: at (0, 0), along x, along y

ROUTS = """M48
METRIC,LZ
T1C1.0F020S30
T2C2.0
%
M47,ROUT (A)
T1
G00X10.0Y10.0
M15
G01X20.0
G03X25.0Y15.0A5.0
G02X30.0Y20.0A5.0
G02X30.0Y12.0A4.0
M17
X45.0Y10.0G87X55.0Y10.0Z-0.7U1.0
G05
T2
M62
X10.0Y50.0
M63
X10.0Y60.0G85X14.0Y60.0
M06
X20.0Y50.0
M30
"""
CANONICAL = re.compile(r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|ARC_FEED)\(([^)]*)\)")


def interpret(program):
    """LinuxCNC's moves: (kind, numbers)."""
    return [(kind, [float(number) for number in numbers.split(",")])
            for kind, numbers in CANONICAL.findall(canonical.interpret(program))]


# Words of GRBL 1.1, "Supported G-codes", and of Marlin's "G-code index", that a program of ours may have.
KNOWN = {"grbl": {"G0", "G1", "G2", "G3", "G4", "G17", "G21", "G40", "G54", "G61", "G80", "G90", "G91.1", "G94", "M0", "M2", "M3",
                  "M5", *"XYZIJFPS"},
         "marlin": {"G0", "G1", "G2", "G3", "G4", "G21", "G90", "M0", "M1", "M3", "M5", *"XYZIJFS"}}
WORD = re.compile(r"([A-Z])(-?[0-9.]+)")
LONGEST = {"grbl": 79, "marlin": 95}


def check_line(line, flavour):
    """The words of a line, each of which its control knows."""
    assert len(line) <= LONGEST[flavour], line
    if flavour == "grbl":
        assert not set("!?~") & set(line), line
        line = re.sub(r"\([^()]*\)|;.*", "", line)
    else:
        line = "" if line.startswith("M117 ") else line.partition(";")[0]
    words = WORD.findall(line)
    assert "".join(letter + number for letter, number in words) == line.replace(" ", ""), line
    commands = [letter + number for letter, number in words if letter in "GM"]
    assert all(command in KNOWN[flavour] for command in commands), line
    assert all(letter in KNOWN[flavour] for letter, _ in words if letter not in "GM"), line
    if flavour == "marlin" and words:
        assert len(commands) == 1 and words[0][0] in "GM", line
    return commands, {letter: float(number) for letter, number in words if letter not in "GM"}


def walk(program, flavour):
    """Moves as interpret() gives them, by a reader of our own: absolute, relative centres, no cycles."""
    moves, at, feed, kind = [], [None, None, None], None, None
    for line in program.read_text().splitlines():
        commands, values = check_line(line, flavour)
        kind = next((one for one in commands if one in ("G0", "G1", "G2", "G3")), kind)
        if not set(values) & set("XYZF"):
            continue
        feed = values.get("F", feed)
        to = [values.get(letter, old) for letter, old in zip("XYZ", at)]
        if not set(values) & set("XYZ"):
            continue
        assert feed or kind == "G0", line
        if kind in ("G2", "G3"):
            # GRBL and Marlin refuse, or go elsewhere, where both radii differ.
            radii = [((x - at[0] - values["I"]) ** 2 + (y - at[1] - values["J"]) ** 2) ** 0.5 for x, y in (at[:2], to[:2])]
            assert abs(radii[0] - radii[1]) < 1e-4 and at[:2] != to[:2], line
            moves.append(("ARC_FEED", [to[0], to[1], at[0] + values["I"], at[1] + values["J"], -1 if kind == "G2" else 1, to[2]]))
        elif None not in to:
            moves.append(("STRAIGHT_TRAVERSE" if kind == "G0" else "STRAIGHT_FEED", to))
        at = to
    return moves


def show_to_firmware(program, folder):
    """GRBL 1.1h in its check mode takes every line."""
    programs = os.environ.get("PANELCAL_GRBL")
    if not programs:
        return
    control = firmware.Firmware("grbl", programs, folder)
    try:
        control.ask("$C")
        for line in program.read_text().splitlines():
            if line not in ("M0", "M2"):  # check mode does not wait, and M2 leaves it
                answer = control.ask(line)
                assert "ok" in answer and "error" not in answer, (line, answer)
    finally:
        control.close()


def flavours(panelcal, folder, arguments, expected):
    """GRBL's and Marlin's programs lead to the same places as LinuxCNC's."""
    for flavour in ("grbl", "marlin"):
        program = folder / f"{flavour}.ngc"
        run(panelcal, "run", *arguments, "-o", program, "--flavour", flavour)
        compare(cuts(walk(program, flavour)), expected, TOLERANCE)
        if flavour == "grbl":
            compare(cuts(interpret(program)), expected, TOLERANCE)
            show_to_firmware(program, folder)


def cuts(moves):
    """Holes and plunges, lines and arcs, with their ends; nothing moves sideways rapidly below SAFE."""
    found = []
    at, is_up = None, True
    for kind, n in moves:
        to = n[:3] if kind != "ARC_FEED" else [n[0], n[1], n[5]]
        moves_sideways = at is None or at[:2] != to[:2]
        if kind == "STRAIGHT_TRAVERSE":
            assert not moves_sideways or min(to[2], (at or to)[2]) >= SAFE, (at, to)
            is_up = is_up or to[2] >= SAFE
        elif kind == "ARC_FEED":
            # Behind end and centre: how often, counterclockwise if positive.
            found.append(("cw" if n[4] < 0 else "ccw", (*to, n[2], n[3])))
        elif moves_sideways:
            found.append(("line", tuple(to)))
        elif is_up or found[-1][0] != "down":
            found.append(("down", tuple(to)))
        else:  # a further peck
            found[-1] = ("down", tuple(to))
        is_up = is_up and kind == "STRAIGHT_TRAVERSE"
        at = to
    return found


def wanted(lines):
    """The same of operations, whose depths only [gcode] says."""
    found = []
    at = z = None
    for op in map(json.loads, lines):
        if op["op"] in ("drill", "position", "rout"):
            at = op["actual"]
        if op["op"] == "drill":
            found.append(("down", (*at, DRILL)))
        elif op["op"] == "plunge":
            z = ROUT + op.get("depth_offset", 0)
            found.append(("down", (*at, z)))
        elif op["op"] == "rout":
            center = op.get("center", [])
            found.append((op["kind"], (*at, z, *center)))
    return found


def compare(found, expected, tolerance):
    assert len(found) == len(expected), (len(found), len(expected))
    for one, other in zip(found, expected):
        assert one[0] == other[0], (one, other)
        for a, b in zip(one[1], other[1], strict=True):
            assert abs(a - b) <= tolerance, (one, other)


def job(panelcal, folder, arguments):
    """Runs a job to both formats; gives the G-code's path and the operations."""
    ops, program = folder / "job.jsonl", folder / "job.ngc"
    run(panelcal, "run", *arguments, "--slots", "expand", "-o", ops)
    run(panelcal, "run", *arguments, "-o", program)
    return program, ops.read_text().splitlines()


def height(x, y):
    return TILT[0] + TILT[1] * x + TILT[2] * y


def levelled(panelcal, folder, program, expected):
    """Behind `surface apply` every cut is deeper by the board's height."""
    probes = folder / "probes.txt"
    probes.write_text("".join(f"{x} {y} {height(x, y)} 0 0 0 0 0 0\n"
                              for x in range(0, 241, 40) for y in range(0, 281, 40)))
    board, out = folder / "map.json", folder / "levelled.ngc"
    run(panelcal, "surface", "fit", probes, "-o", board)
    run(panelcal, "surface", "apply", board, program, "-o", out)
    found = [cut for cut in cuts(interpret(out)) if cut[0] == "down"]
    holes = [("down", (x, y, z + height(x, y))) for kind, (x, y, z, *_) in expected
             if kind == "down"]
    # The map is a fit of noiseless probes; the rest is its lattice.
    compare(found, holes, 2e-3)


def main(panelcal, root):
    if shutil.which("rs274") is None:
        print("rs274 is not installed (Debian: linuxcnc-uspace)")
        return 77
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        machine = folder / "small.toml"
        machine.write_text("[machine]\nname = \"small\"\n" + GCODE)
        routs = folder / "routs.exc"
        routs.write_text(ROUTS)
        program, ops = job(panelcal, folder, [routs, "-m", machine])
        expected = wanted(ops)
        kinds = [kind for kind, _ in expected]
        assert {"down", "line", "cw", "ccw"} <= set(kinds), kinds
        compare(cuts(interpret(program)), expected, TOLERANCE)
        levelled(panelcal, folder, program, expected)
        flavours(panelcal, folder, [routs, "-m", machine], expected)

        demo = Path(root) / "datasets/demo"
        shutil.copy(demo / "camera.cal.json", folder)
        machine.write_text((demo / "machine.toml").read_text() + GCODE)
        program, ops = job(panelcal, folder,
                           [demo / "panel.exc", "-m", machine, "--images", demo / "images"])
        expected = wanted(ops)
        assert len(expected) == 990
        compare(cuts(interpret(program)), expected, TOLERANCE)
        levelled(panelcal, folder, program, expected)
        flavours(panelcal, folder, [demo / "panel.exc", "-m", machine, "--images", demo / "images"], expected)
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
