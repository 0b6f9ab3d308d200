#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`panelcal surface apply` against LinuxCNC's interpreter: random programs before and after it.

    surface_apply_test.py PANELCAL [SEED [PROGRAMS]]

Both programs go through rs274, and their paths are compared all along:

- They go the same way in X and Y, with the same feeds.
- Below the safe height, z after - z before is the height of the board there; above it, 0.
- No rapid move is nearer to the board than in the program before, or than the safe height is.
- No line is longer than LinuxCNC reads.

The board's heights are formulas of this file. The program before runs under the modes that `surface
apply` takes where it states none; the program after under the opposite ones, which the control may
have kept from another program.
"""
import itertools
import json
import math
import random
import re
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from canonical import INCH_MM, PRINTED, Refused, interpret, moves
from demo_job import run
from random_gcode import LONGEST, MODES, PECKS, Program, random_program

AREA = ((0, 100), (0, 80))
INSIDE = ((2, 98), (2, 78))  # of it
PROBES = (21, 17)
SAMPLE_MM = 0.7
WAY_MM = 2e-3
# Over so much of an arc `surface apply` goes from the surface to the safe height or back.
CROSSING_MM = 0.01


class Difference(Exception):
    """The levelled program does not do what it should."""


def require(condition, *what):
    if not condition:
        raise Difference(" ".join(map(str, what)))


@dataclass
class Board:
    """A surface by formula, and the map that panelcal made of its probes."""

    height: callable
    path: Path
    highest: float
    error: float  # of the map's lattice

    def shifted(self, by):
        return Board(lambda x, y: self.height(x, y) + by, self.path, self.highest, self.error)


@dataclass
class Levelled:
    """A program before and after `surface apply`: the moves of every N word."""

    before: dict
    after: dict
    cycles: dict
    safe: float
    tolerance: float


# --- boards ---------------------------------------------------------------------------------------


def plane(random):
    a, b, c = random.uniform(-0.3, 0.3), random.uniform(-3e-3, 3e-3), random.uniform(-3e-3, 3e-3)
    return lambda x, y: a + b * x + c * y


def twist(random):
    flat, d = plane(random), random.choice((-1, 1)) * random.uniform(2e-5, 8e-5)
    return lambda x, y: flat(x, y) + d * (x - 50) * (y - 40)


def humps(random):
    """Between the probes of a smooth surface, bilinear."""
    (x0, x1), (y0, y1) = AREA
    n_x, n_y = PROBES
    bumps = [(random.uniform(-0.3, 0.3), random.uniform(x0, x1), random.uniform(y0, y1),
              random.uniform(15, 40)) for _ in range(4)]

    def smooth(i, j):
        x, y = x0 + (x1 - x0) * i / (n_x - 1), y0 + (y1 - y0) * j / (n_y - 1)
        return sum(high * math.exp(-((x - x_top)**2 + (y - y_top)**2) / (2 * width**2))
                   for high, x_top, y_top, width in bumps)

    heights = [[smooth(i, j) for i in range(n_x)] for j in range(n_y)]

    def height(x, y):
        u, v = (x - x0) / (x1 - x0) * (n_x - 1), (y - y0) / (y1 - y0) * (n_y - 1)
        i, j = min(int(u), n_x - 2), min(int(v), n_y - 2)
        u, v = u - i, v - j
        return ((1 - v) * ((1 - u) * heights[j][i] + u * heights[j][i + 1]) +
                v * ((1 - u) * heights[j + 1][i] + u * heights[j + 1][i + 1]))

    return height


def board(panelcal, random, kind, path):
    """The map of a formula's probes."""
    height = kind(random)
    (x0, x1), (y0, y1) = AREA
    n_x, n_y = PROBES
    places = [(x0 + (x1 - x0) * i / (n_x - 1), y0 + (y1 - y0) * j / (n_y - 1))
              for j in range(n_y) for i in range(n_x)]
    probes = path.with_suffix(".txt")
    probes.write_text("".join(f"{x:.6f} {y:.6f} {height(x, y):.9f} 0 0 0 0 0 0\n"
                              for x, y in places))
    model = "plane" if kind is plane else "bilinear"
    figures = json.loads(run(panelcal, "surface", "fit", probes, "--format", "linuxcnc", "--model",
                             model, "--sigma-um", "1", "-o", path, "--json", "-").stdout)["zones"][0]
    highest = max(height(x, y) for x, y in places) + 3 * figures["worst_sigma"]["sigma_um"] / 1e3
    return Board(height, path, highest, figures["lattice_error_um"] / 1e3)


# --- runs -----------------------------------------------------------------------------------------


def under(modes, text):
    """A program behind a line of modal words; % stays first."""
    return text.replace("%", "%\n" + modes, 1) if text.startswith("%") else modes + "\n" + text


def by_block(program, folder, name):
    """The moves that LinuxCNC makes, by N words."""
    path = folder / name
    path.write_text(program)
    try:
        found = moves(interpret(path))
    except Refused as refused:
        raise Difference(f"rs274: {refused}") from None
    return {block: list(group) for block, group in itertools.groupby(found, lambda m: m.block)}


def stated_unit(program):
    return program.unit or ("inch" if re.search("G20|G21", program.text)[0] == "G20" else "mm")


def levelled_text(panelcal, program, a_board, tolerance, folder):
    """Gives the program that `surface apply` writes, and its safe height."""
    source, out = folder / "before.ngc", folder / "after.ngc"
    source.write_text(program.text)
    options = ["--height-tolerance-um", f"{1e3 * tolerance:g}"]
    options += ["--safe-mm", program.safe] if program.safe else []
    options += ["--unit", program.unit] if program.unit else []
    figures = json.loads(run(panelcal, "surface", "apply", a_board.path, source, "-o", out,
                             "--json", "-", *options).stdout)
    require(figures["safe_height_mm"] == program.safe if program.safe
            else figures["safe_height_mm"] > a_board.highest - 1e-6, "safe height", figures)
    return out.read_text(), figures["safe_height_mm"]


def run_both(program, text, safe, tolerance, folder):
    for line in text.splitlines():
        require(len(line) <= LONGEST, len(line), "characters:", line)
    is_inch = stated_unit(program) == "inch"
    usual = " ".join([*MODES.values(), "G20" if is_inch else "G21"])
    opposite = f"G18 G91 G90.1 G93 G99 {'G21' if is_inch else 'G20'}"
    return Levelled(by_block(under(usual, program.text), folder, "usual.ngc"),
                    by_block(under(opposite, text), folder, "opposite.ngc"),
                    program.cycles, safe, tolerance)


# --- comparison -----------------------------------------------------------------------------------


def slack(move, a_board):
    """The digits of printed numbers, and the map's lattice."""
    slope = move.slope if move.length > WAY_MM else 0
    return a_board.error + move.printed * (1.5 + slope)


def between(*heights):
    return min(heights), max(heights)


def added(levelled, move, part, height_at):
    """Least and greatest height that may be added to a move at a part of it."""
    z = [place[2] for place in (move.begin, move.end)]
    height = height_at(*move.at(part)[:2])
    if min(z) >= levelled.safe + move.printed:
        return 0, 0
    if max(z) <= levelled.safe - move.printed:
        return height, height
    if abs(z[1] - z[0]) <= move.printed:
        return between(0, height)  # at the safe height itself, as far as is printed
    crossing = min(1, max(0, (levelled.safe - z[0]) / (z[1] - z[0])))
    beyond = (part - crossing if z[1] < z[0] else crossing - part) * move.length
    near = 2 * move.printed + move.printed / move.slope + (CROSSING_MM if move.center else 0)
    at_crossing = height_at(*move.at(crossing)[:2])
    if abs(beyond) <= near:
        return between(0, height, at_crossing)
    # Towards a higher board it may rise early; it never sinks before the safe height.
    return (height, height) if beyond > 0 else (0, max(0, at_crossing))


def check_rapid(levelled, a_board, before, after, slack_mm):
    """In     before, after: places at the same time"""
    if before[2] < 0:
        return  # in the board already, as the program has it
    clearance = min(before[2], levelled.safe - a_board.highest)
    found = after[2] - a_board.height(*after[:2])
    require(found >= clearance - slack_mm, f"rapid move {found:.4f} mm above the board at {after}, "
            f"which was {clearance:.4f}")


def check_way(levelled, a_board, before, pieces):
    """A line or an arc against what it has become."""
    slack_mm = slack(before, a_board)
    way_mm = WAY_MM + (1.5 * before.printed if before.printed > PRINTED else 0)
    total = sum(piece.length for piece in pieces)
    turns = 2 * math.pi if before.center else 0  # what is printed of a centre counts along the arc
    require(abs(total - before.length) <= way_mm + (turns + len(pieces)) * before.printed, "length",
            total, before)
    done = 0
    for piece in pieces:
        n = max(4, math.ceil(piece.length / SAMPLE_MM))
        for i in range(n + 1):
            place = piece.at(i / n)
            part = before.part_near(place, (done + piece.length * i / n) / total)
            was = before.at(part)
            require(math.dist(place[:2], was[:2]) <= way_mm, "place", place, was, before)
            low, high = added(levelled, before, part, a_board.height)
            tolerance = slack_mm + (levelled.tolerance if (low, high) != (0, 0) else 0)
            shift = place[2] - was[2]
            require(low - tolerance <= shift <= high + tolerance,
                    f"height {shift:.4f} added, not {low:.4f} to {high:.4f} mm, at {part:.4f} of "
                    f"{before}, safe height {levelled.safe}")
            if before.is_rapid:
                check_rapid(levelled, a_board, was, place, slack_mm + levelled.tolerance)
        done += piece.length
    require(math.dist(pieces[-1].end[:2], before.end[:2]) <= way_mm, "end", before, pieces[-1])


def check_vertical(levelled, a_board, before, after, highest=math.inf):
    """Up or down: the end is where it should be, within the digits; lifted no higher than given."""
    require(math.dist(before.end[:2], after.end[:2]) <= WAY_MM + before.printed, before, after)
    above = before.end[2] - levelled.safe
    height = min(a_board.height(*before.end[:2]), highest - before.end[2])
    low, high = (between(0, height) if abs(above) <= before.printed else
                 (0, 0) if above > 0 else (height, height))
    slack_mm = slack(before, a_board)
    require(low - slack_mm <= after.end[2] - before.end[2] <= high + slack_mm,
            f"height to add: {height:.4f}", before, after)
    if before.is_rapid:
        check_rapid(levelled, a_board, before.end, after.end, slack_mm)


def split(group):
    """The way to a hole, and the hole: from the first feed on."""
    n_way = next(i for i, move in enumerate(group) if not move.is_rapid)
    return group[:n_way], group[n_way:]


def check_hole(levelled, a_board, code, before, after):
    """A drilling cycle."""
    (way, before), (way_after, after) = split(before), split(after)
    # How high LinuxCNC moves on depends on R, the last one and G98: elsewhere where R is.
    for move in way_after:
        require(move.length == 0 or min(move.begin[2], move.end[2]) >= levelled.safe - move.printed,
                "way to a hole below the safe height", move)
    # R is never above where the tool travels.
    height, travel = a_board.height(*before[0].end[:2]), before[-1].end[2]
    check_vertical(levelled, a_board, way[-1], way_after[-1], travel)
    feeds = [[move.feed for move in some if not move.is_rapid] for some in (before, after)]
    require(between(*feeds[0]) == between(*feeds[1]), "feeds of a cycle", feeds)
    slack_mm = slack(before[0], a_board)
    is_lifted = abs(after[0].begin[2] - before[0].begin[2] - height) <= slack_mm
    if is_lifted or code not in PECKS:
        require(len(before) == len(after), "moves of a cycle", before, after)
        for was, now in zip(before, after):
            require(was.is_rapid == now.is_rapid, "kinds of a cycle's moves", was, now)
            check_vertical(levelled, a_board, was, now, travel)
        return
    # Pecks count from R: they have other depths, and there may be one more; but the same hole.
    bottom, reached = (min((move for move in some if not move.is_rapid), key=lambda m: m.end[2])
                       for some in (before, after))
    check_vertical(levelled, a_board, bottom, reached)
    check_vertical(levelled, a_board, before[-1], after[-1])
    deepest = levelled.safe
    for move in after:
        require(not move.is_rapid or move.end[2] >= deepest - move.printed, "rapid into the hole",
                move)
        deepest = min(deepest, move.end[2])


def begins_low(levelled, block):
    return levelled.before[block][0].begin[2] < levelled.safe - levelled.before[block][0].printed


def take_rises(levelled):
    """Before a series of cycles that begins below the safe height comes a block without a number,
    which leads straight to the safe height; takes them out."""
    for last, block in itertools.pairwise(levelled.before):
        if block not in levelled.cycles or not begins_low(levelled, block):
            continue
        rise = levelled.after[last].pop()
        require(rise.is_rapid and rise.length <= rise.printed and
                abs(rise.end[2] - levelled.safe) <= rise.printed, "rise to the safe height", rise)


def compare(levelled, a_board):
    """Gives the number of pieces that lines and arcs have become."""
    require(list(levelled.before) == list(levelled.after), "other blocks move")
    take_rises(levelled)
    n_pieces = 0
    for block, before in levelled.before.items():
        after = levelled.after[block]
        try:
            if block not in levelled.cycles:
                (move,) = before
                n_pieces += check_block(levelled, a_board, move, after)
            else:
                check_hole(levelled, a_board, levelled.cycles[block], before, after)
        except Difference as difference:
            raise Difference(f"N{block}: {difference}") from None
    return n_pieces


def check_block(levelled, a_board, before, after):
    """A line or an arc, as far as it moves."""
    for piece in after:
        require(piece.is_rapid == before.is_rapid, "kinds", before, piece)
        require(piece.is_rapid or abs(piece.feed / before.feed - 1) < 1e-3, "feed", before, piece)
    if before.length > WAY_MM:
        check_way(levelled, a_board, before, after)
    check_vertical(levelled, a_board, before, after[-1])
    return len(after)


# --- the test of the test -------------------------------------------------------------------------

UNSTATED = """N1 F300 M3 S9000
N2 G0 Z2
N3 G0 X10 Y10
N4 G81 X20 Y20 Z-1.6 R0.3
N5 X60
N6 G80
N7 G1 Z-0.1
N8 G2 X70 Y10 R10
N9 G1 X20 Y60
N10 G0 Z2
M2
"""


def check_that_faults_are_found(panelcal, folder):
    """A board 20 um off, and every word that is taken away, must show."""
    a_board = board(panelcal, random.Random(1), twist, folder / "map.json")
    program = Program(UNSTATED, "mm", None, {4: "G81", 5: "G81"})
    tolerance = 5e-3
    text, safe = levelled_text(panelcal, program, a_board, tolerance, folder)
    compare(run_both(program, text, safe, tolerance, folder), a_board)

    def finds(what, other_text, other_board):
        try:
            compare(run_both(program, other_text, safe, tolerance, folder), other_board)
        except Difference:
            return
        raise SystemExit(f"not found: {what}")

    for shift in (-20e-3, 20e-3):
        finds(f"a board shifted by {shift} mm", text, a_board.shifted(shift))
    for word in (*MODES.values(), "G21"):
        without = re.sub(rf"^(.*)\b{re.escape(word)}\b(?!\.)(.*not stated.*)$", r"\1\2", text,
                         flags=re.MULTILINE)
        assert without != text, (word, text)
        finds(f"{word} not written", without, a_board)


def main(panelcal, seed=1, n_programs=40):
    if shutil.which("rs274") is None:
        print("rs274 is not installed (Debian: linuxcnc-uspace)")
        return 77
    print(f"seed {seed}")
    draw = random.Random(seed)
    # As long as names of folders are.
    with tempfile.TemporaryDirectory(prefix="levelled" + "-program" * 15) as temporary:
        folder = Path(temporary)
        check_that_faults_are_found(panelcal, folder)
        n_pieces = 0
        for i in range(n_programs):
            if i % 5 == 0:
                kind = (plane, twist, humps)[i // 5 % 3]
                a_board = board(panelcal, draw, kind, folder / "map.json")
            program = random_program(draw, INSIDE, a_board.highest)
            tolerance = round(10**draw.uniform(-2.5, -1.5), 4)
            try:
                text, safe = levelled_text(panelcal, program, a_board, tolerance, folder)
                n_pieces += compare(run_both(program, text, safe, tolerance, folder), a_board)
            except (Difference, SystemExit) as failed:
                print(f"program {i} of seed {seed}, on {kind.__name__}:\n{program.text}\n{failed}")
                return 1
        print(f"{n_programs} programs, {n_pieces} pieces of lines and arcs")
        assert n_pieces > 20 * n_programs
    return 0


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], *map(int, sys.argv[2:])))
