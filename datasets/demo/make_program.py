# SPDX-License-Identifier: Apache-2.0
"""Makes the demo's part program: one real board, stepped and repeated to a panel of 2 x 3.

    python3 make_program.py --export BOARD.kicad_pcb    KiCad board -> board.drl (needs pcbnew 6)
    python3 make_program.py                             board.drl -> panel.exc (needs nothing)
    python3 make_program.py --check                     fails if panel.exc is out of date

Lengths are whole micrometres in this file, and millimetres with three decimals in the files it
writes. Two frames: "board", zero at the lower left corner of the board outline, and "panel", zero
(work zero of the program) at the panel's lower left corner; x right, y up in both. The result
depends on the input alone: no clock, no random numbers, and holes are ordered by whole numbers.
"""

import argparse
import math
import os
import re
import sys
import tempfile
from decimal import Decimal
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
BOARD_DRL = FOLDER / "board.drl"
PANEL_EXC = FOLDER / "panel.exc"

MM = 1000  # micrometres
PANEL = (230 * MM, 275 * MM)
FIRST_BOARD = (12 * MM, 12 * MM)  # lower left corner of the first board, in the panel frame
COLUMNS, ROWS = 2, 3
GAP = 5 * MM  # between board outlines
MIN_MARGIN = 10 * MM  # from the outermost board outlines to the panel's edge
PANEL_FIDUCIAL_INSET = 6 * MM  # from the panel's edges
BOARD_FIDUCIAL_INSET = 3 * MM  # from the board's edges
PANEL_FIDUCIAL_DIAMETER = 2 * MM  # vision tool 1
BOARD_FIDUCIAL_DIAMETER = 1 * MM  # vision tool 2
MIN_CLEARANCE = 3 * MM  # rim to rim, a fiducial to any hole and to any other fiducial

SURFACE_SPEED = 150  # m/min at the drill's rim, for glass epoxy
SPINDLE_KRPM = (14, 80)  # range of the manual's section "Spindle RPM", 1000/min
INFEED_MM_S = (4, 212)  # range of the manual's section "Z-Axis Infeed", mm/s


# ---------------------------------------------------------------- KiCad board -> board.drl


def export_drill_file(board_file):
    """Returns the text of board.drl: holes plated or not in one file, metric, decimal points."""
    import pcbnew  # only here: making the program works without KiCad

    board = pcbnew.LoadBoard(str(board_file))
    edges = [d for d in board.GetDrawings() if d.GetLayer() == pcbnew.Edge_Cuts]
    ends = [p for edge in edges for p in (edge.GetStart(), edge.GetEnd())]
    left, right = min(p.x for p in ends), max(p.x for p in ends)
    top, bottom = min(p.y for p in ends), max(p.y for p in ends)  # KiCad's y points down

    with tempfile.TemporaryDirectory() as folder:
        writer = pcbnew.EXCELLON_WRITER(board)
        writer.SetOptions(False, False, pcbnew.wxPoint(left, bottom), True)  # True: merge PTH, NPTH
        writer.SetFormat(True, pcbnew.GENDRILL_WRITER_BASE.DECIMAL_FORMAT)
        writer.CreateDrillandMapFilesSet(folder, True, False)
        (drill_file,) = Path(folder).glob("*.drl")
        lines = drill_file.read_text(encoding="ascii").splitlines()

    # The dates go, so that the same board always gives the same file.
    lines = [re.sub(r" date .*", "", line) for line in lines if "TF.CreationDate" not in line]
    nm_per_um = 1000
    size = ((right - left) // nm_per_um, (bottom - top) // nm_per_um)
    lines[1:1] = [
        f"; Drill data of the KiCad demo board {Path(board_file).name}, adapted: see ORIGIN.md",
        "; SPDX-License-Identifier: CC-BY-SA-4.0",
        "; Zero is the lower left corner of the board outline, x right, y up.",
        f"; BOARD_SIZE={mm(size[0])}x{mm(size[1])}",
    ]
    return "\n".join(lines) + "\n"


# ---------------------------------------------------------------- board.drl -> tools and holes


def read_drill_file(text):
    """Returns (board size, {tool: diameter}, {tool: [hole, ...]}) of a file made by --export."""
    size, diameters, holes, tool = None, {}, {}, None
    for number, line in enumerate(text.splitlines(), start=1):
        if match := re.fullmatch(r"; BOARD_SIZE=([\d.]+)x([\d.]+)", line):
            size = (um(match[1]), um(match[2]))
        elif match := re.fullmatch(r"T(\d+)C([\d.]+)", line):
            diameters[int(match[1])] = um(match[2])
            holes[int(match[1])] = []
        elif match := re.fullmatch(r"T(\d+)", line):
            tool = int(match[1])
        elif match := re.fullmatch(r"X(-?[\d.]+)Y(-?[\d.]+)", line):
            holes[tool].append((um(match[1]), um(match[2])))
        elif not re.fullmatch(r";.*|M48|FMAT,2|METRIC|%|G90|G05|M30", line):
            sys.exit(f"{BOARD_DRL.name}:{number}: '{line}': expected hits only, no slots or routs")
    if size is None:
        sys.exit(f"{BOARD_DRL.name}: the comment BOARD_SIZE is missing: make it with --export")
    return size, diameters, holes


# ---------------------------------------------------------------- geometry of the panel


def pitch(size):
    return (size[0] + GAP, size[1] + GAP)


def panel_fiducials():
    """Lower left, lower right, upper left, in the panel frame: three corners tell how it lies."""
    near, right, top = PANEL_FIDUCIAL_INSET, PANEL[0], PANEL[1]
    return [(near, near), (right - near, near), (near, top - near)]


def board_fiducials(size):
    """Lower left, lower right, upper right, in the board frame."""
    near = BOARD_FIDUCIAL_INSET
    return [(near, near), (size[0] - near, near), (size[0] - near, size[1] - near)]


def check_layout(size, diameters, holes):
    """Ends the program if anything would overlap or stand too near to a fiducial."""
    for axis, count in ((0, COLUMNS), (1, ROWS)):
        used = FIRST_BOARD[axis] + (count - 1) * pitch(size)[axis] + size[axis]
        if min(FIRST_BOARD[axis], PANEL[axis] - used) < MIN_MARGIN:
            sys.exit(f"the boards leave less than {mm(MIN_MARGIN)} mm of margin")

    corners = [
        (FIRST_BOARD[0] + i * pitch(size)[0], FIRST_BOARD[1] + j * pitch(size)[1])
        for j in range(ROWS)
        for i in range(COLUMNS)
    ]
    fiducials = [(at, PANEL_FIDUCIAL_DIAMETER) for at in panel_fiducials()]
    drilled = []
    for corner in corners:
        fiducials += [(plus(corner, at), BOARD_FIDUCIAL_DIAMETER) for at in board_fiducials(size)]
        drilled += [(plus(corner, at), diameters[tool]) for tool in holes for at in holes[tool]]
    for i, (at, diameter) in enumerate(fiducials):
        for other, other_diameter in fiducials[:i] + drilled:
            if math.dist(at, other) - (diameter + other_diameter) / 2 < MIN_CLEARANCE:
                sys.exit(f"fiducial {xy(at)} is too near to {xy(other)}")


# ---------------------------------------------------------------- order of drilling


def short_path(holes):
    """Orders holes for little travel: from the lower left to the nearest, then 2-opt and or-opt."""
    rest = sorted(holes)
    path = [min(rest, key=lambda hole: (distance((0, 0), hole), hole))]
    rest.remove(path[0])
    while rest:
        path.append(min(rest, key=lambda hole: (distance(path[-1], hole), hole)))
        rest.remove(path[-1])
    while (better := improved(path)) is not None:
        path = better
    return path


def improved(path):
    """Returns a shorter path with the same first hole, or None if no single change helps."""
    n = len(path)
    at = path + [None]  # after the last hole there is no way to save
    for i in range(1, n):
        for j in range(i + 1, n + 1):
            first, last = at[i], at[j - 1]
            before = distance(at[i - 1], first) + distance(last, at[j])
            if distance(at[i - 1], last) + distance(first, at[j]) < before:
                return path[:i] + path[i:j][::-1] + path[j:]
            if j - i > 3:
                continue
            saved = before - distance(at[i - 1], at[j])
            others = path[:i] + path[j:]
            for k, (a, b) in enumerate(zip(others, others[1:] + [None]), start=1):
                for piece in (path[i:j], path[i:j][::-1]):
                    if distance(a, piece[0]) + distance(piece[-1], b) - distance(a, b) < saved:
                        return others[:k] + piece + others[k:]
    return None


# ---------------------------------------------------------------- the part program


def program(size, diameters, holes):
    """Returns the text of panel.exc."""
    lines = header(size, diameters, holes)
    lines += ["M47,PANELCAL DEMO", "G05", "G90", "G34,1"]
    lines += ["G36" + xy(at) for at in panel_fiducials()]
    lines += ["G34,2", "M50,1", "M25"]
    lines += ["G46" + xy(plus(FIRST_BOARD, at)) for at in board_fiducials(size)]
    lines += step_and_repeat(size)
    for tool in sorted(holes):
        path = [plus(FIRST_BOARD, hole) for hole in short_path(holes[tool])]
        lines += [f"T{tool}", "M51,1", "M25", "M52,3"] + hole_blocks(path) + step_and_repeat(size)
    lines.append("M30")
    return "\n".join(lines) + "\n"


def header(size, diameters, holes):
    copies = COLUMNS * ROWS
    hits = " ".join(f"T{tool} {len(holes[tool]) * copies}" for tool in sorted(holes))
    lines = [
        "M48",
        f"; panelcal demo: {COLUMNS} x {ROWS} boards of {mm(size[0])} x {mm(size[1])} mm",
        "; made by make_program.py from board.drl: see ORIGIN.md",
        "; SPDX-License-Identifier: CC-BY-SA-4.0",
        f"; work zero: lower left corner of the panel, {mm(PANEL[0])} x {mm(PANEL[1])} mm",
        f"; vision tool 1: panel fiducials, disc {mm(PANEL_FIDUCIAL_DIAMETER)} mm",
        f"; vision tool 2: board fiducials, disc {mm(BOARD_FIDUCIAL_DIAMETER)} mm",
        f"; hits: {hits}",
        "METRIC,TZ",
        "FMAT,2",
        "VER,1",
    ]
    for tool in sorted(holes):
        diameter_mm = diameters[tool] / MM
        speed_krpm = clamped(round(SURFACE_SPEED / (math.pi * diameter_mm)), SPINDLE_KRPM)
        chip_load_mm = 0.025 + 0.04 * diameter_mm  # per turn
        infeed_mm_s = clamped(round(chip_load_mm * speed_krpm * 1000 / 60), INFEED_MM_S)
        # F is read with leading zeros kept: F060 is 60 mm/s, F6 would be 600.
        lines.append(f"T{tool}C{mm(diameters[tool])}F{infeed_mm_s:03}S{speed_krpm}")
    return lines + ["%"]


def step_and_repeat(size):
    """The first level makes a row of the pattern's columns, the second repeats that row upwards."""
    step_x, step_y = pitch(size)
    return [
        "M01",
        f"R{COLUMNS - 1}M02X{mm(step_x)}",
        "M01",
        f"R{ROWS - 1}M02Y{mm(step_y)}",
        "M02",
        "M08",
    ]


def hole_blocks(path):
    """Writes holes in order: an unchanged axis is left out, three or more in a run become R#."""
    blocks, at, i = [], None, 0
    while i < len(path):
        step, n = run_ahead(path, i) if at is not None else (None, 0)
        if n >= 2:
            blocks.append(f"R{n}{xy(step, leave_out=(0, 0))}")
            i += n
        else:
            blocks.append(xy(path[i], leave_out=at))
            i += 1
        at = path[i - 1]
    return blocks


def run_ahead(path, i):
    """Returns the step from hole i - 1 to hole i, and how many times the path takes it in a row."""
    step = minus(path[i], path[i - 1])
    n = 1
    while i + n < len(path) and minus(path[i + n], path[i + n - 1]) == step:
        n += 1
    return step, n


# ---------------------------------------------------------------- small helpers


def um(text):
    """Reads millimetres as whole micrometres."""
    return int(Decimal(text) * MM)


def mm(value):
    """Writes micrometres as millimetres with three decimals."""
    return f"{Decimal(value) / MM:.3f}"


def xy(at, leave_out=None):
    """Writes a coordinate without the axes that equal leave_out's."""
    words = [
        letter + mm(at[axis])
        for axis, letter in enumerate("XY")
        if leave_out is None or at[axis] != leave_out[axis]
    ]
    return "".join(words)


def plus(a, b):
    return (a[0] + b[0], a[1] + b[1])


def minus(a, b):
    return (a[0] - b[0], a[1] - b[1])


def distance(a, b):
    """Distance in nanometres, rounded down: whole numbers compare alike on every machine."""
    if b is None:
        return 0
    return math.isqrt(((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) * 10**6)


def clamped(value, limits):
    return max(limits[0], min(limits[1], value))


def write(file, text):
    """Writes a file whole or not at all."""
    part = file.with_suffix(file.suffix + ".part")
    part.write_text(text, encoding="ascii", newline="\n")
    os.replace(part, file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--export", metavar="BOARD.kicad_pcb", help="make board.drl first")
    parser.add_argument("--check", action="store_true", help="write nothing, compare")
    options = parser.parse_args()

    if options.export:
        write(BOARD_DRL, export_drill_file(options.export))
    size, diameters, holes = read_drill_file(BOARD_DRL.read_text(encoding="ascii"))
    check_layout(size, diameters, holes)
    text = program(size, diameters, holes)
    if not options.check:
        write(PANEL_EXC, text)
    elif text != PANEL_EXC.read_text(encoding="ascii"):
        sys.exit(f"{PANEL_EXC.name} is out of date: run {Path(__file__).name}")


if __name__ == "__main__":
    main()
