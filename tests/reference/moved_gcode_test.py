#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""G-code that was moved in X and Y, against LinuxCNC's interpreter: programs before and after it.

    moved_gcode_test.py MOVED_GCODE [--programs 300] [--seed 1]

Both programs go through rs274. This file applies the fit to what the program before does, and holds
that against what the program after does, block by block:

- Every end is where the fit carries it, within 1 um; on the way the tool is within 1 um of the image
  of the program's line or arc where that stays one, else within the tolerance of 2 um.
- The tool goes that way once, from its begin to its end.
- Heights, feeds, and which moves are rapid, are the program's.

Programs are those of gcode/, written in the styles of pcb2gcode, FlatCAM and others, and random ones
with lines, arcs, helices, cycles, steps, G92, G52, subprograms and variables. Fits are offsets,
rotations, stretches, shears and mirrors, and for the random programs also bends.
"""
import argparse
import itertools
import math
import random
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))
from canonical import INCH_MM, PRINTED, Refused, interpret, moves  # noqa: E402
from random_gcode import Program, Writer  # noqa: E402

ENDS_MM = 1e-3
START = "N999 G53 G0 X-777 Y-555\n"  # where the tool stands before a program
TOLERANCE_MM = 2e-3  # of arcs and bent lines
SAMPLE_MM = 0.5
MODES = "G17 G90 G91.1 G94 G98"
AREA = ((-20, 100), (-30, 80))


class Difference(Exception):
    """The moved program does not do what it should."""


def require(condition, *what):
    if not condition:
        raise Difference(" ".join(map(str, what)))


@dataclass(frozen=True)
class Fit:
    """A bend of y by x^2, and an affine map."""

    a: float
    b: float
    c: float
    d: float
    x: float
    y: float
    bend: float = 0

    def __call__(self, place):
        x, y = place[0], place[1] + self.bend * place[0]**2
        return self.a * x + self.b * y + self.x, self.c * x + self.d * y + self.y

    def inverse(self, place):
        x, y = place[0] - self.x, place[1] - self.y
        determinant = self.a * self.d - self.b * self.c
        x, y = (self.d * x - self.b * y) / determinant, (self.a * y - self.c * x) / determinant
        return x, y - self.bend * x**2

    def keeps_circles(self):
        return self.bend == 0 and math.isclose(self.a, self.d) and math.isclose(self.b, -self.c)

    def words(self):
        return [repr(number) for number in (self.a, self.b, self.c, self.d, self.x, self.y, self.bend)]


def random_fit(draw, may_bend):
    angle = draw.choice((draw.uniform(-0.02, 0.02), draw.uniform(-math.pi, math.pi)))
    scale_x = scale_y = 1 + draw.uniform(-1e-3, 1e-3)
    shear = 0
    if draw.random() < 0.6:
        scale_y = 1 + draw.choice((1e-4, 1e-3, 2e-2)) * draw.uniform(-1, 1)
        shear = draw.choice((0, draw.uniform(-1e-3, 1e-3)))
    if draw.random() < 0.15:
        scale_x = -scale_x
    c, s = math.cos(angle), math.sin(angle)
    bend = draw.uniform(-1e-5, 1e-5) if may_bend and draw.random() < 0.25 else 0
    return Fit(c * scale_x, c * shear * scale_x - s * scale_y, s * scale_x,
               s * shear * scale_x + c * scale_y, draw.uniform(-50, 50), draw.uniform(-50, 50), bend)


# --- comparison -----------------------------------------------------------------------------------


def by_block(program, folder, name):
    """(N word, its moves), in order; a block that is executed again stands there again."""
    path = folder / name
    path.write_text(program)
    try:
        found = moves(interpret(path))
    except Refused as refused:
        raise Difference(f"rs274: {refused}") from None
    return [(block, list(group)) for block, group in itertools.groupby(found, lambda m: m.block)]


def check_end(fit, before, after):
    slack = before.printed + after.printed
    if before.length <= before.printed and not before.center:
        # Up or down, where the move before has led; before the first one that place has no image.
        require(after.length <= 2 * after.printed, "it moves aside", before, after)
        require(abs(before.end[2] - after.end[2]) <= slack, "height", before, after)
        return
    away = math.dist(fit(before.end), after.end[:2])
    require(away <= ENDS_MM + slack, f"end {1e3 * away:.2f} um off:", before, after)
    require(abs(before.end[2] - after.end[2]) <= slack, "height", before, after)


def check_way(fit, before, pieces):
    """Along the pieces: near to the way of the move before, onwards, at its heights."""
    stays = len(pieces) == 1 and not fit.bend and (not before.center or fit.keeps_circles())
    slack = (3 if before.center else 1.5) * before.printed + PRINTED
    # An arc whose two radii differ is stated no better than by half of the difference.
    if before.center:
        slack += abs(before.radii[1] - before.radii[0]) / 2
    limit = (ENDS_MM if stays else TOLERANCE_MM) + slack
    total = sum(piece.length for piece in pieces)
    last_part, done = 0, 0
    for piece in pieces:
        n = max(4, math.ceil(piece.length / SAMPLE_MM))
        for i in range(n + 1):
            place = piece.at(i / n)
            guess = (done + piece.length * i / n) / total
            part = before.part_near(fit.inverse(place), guess)
            was = before.at(part)
            away = math.dist(fit(was), place[:2])
            require(away <= limit, f"{1e3 * away:.2f} um off at {part:.4f} of", before, piece)
            onwards = part - last_part + 2 * limit / before.length
            require(onwards >= 0, f"back from {last_part} to {part} of", before, pieces)
            # In a cut move heights follow the share of a piece, which an uneven map stretches.
            slope = abs(before.end[2] - before.begin[2])
            require(abs(place[2] - was[2]) <= slack + 0.05 * slope * (not stays) + 2e-3 * slope, "height",
                    was, place)
            last_part = max(last_part, part)
        done += piece.length
    require(last_part >= 1 - 2 * limit / before.length, "an end missing", before, pieces)


def compare_block(fit, before, after):
    """Gives the number of pieces."""
    if len(before) > 1:  # a cycle, or a way to it
        require(len(before) == len(after), "moves of a cycle", before, after)
        for was, now in zip(before, after):
            compare_block(fit, [was], [now])
        return len(after)
    (move,) = before
    for piece in after:
        require(piece.is_rapid == move.is_rapid, "kinds", move, piece)
        require(piece.is_rapid or abs(piece.feed - move.feed) <= 1e-3 * move.feed, "feed", move, piece)
    if move.is_rapid:
        require(len(after) == 1, "pieces of a rapid move", after)
    elif move.length > 4 * (ENDS_MM + move.printed):
        check_way(fit, move, after)
    check_end(fit, move, after[-1])
    return len(after)


def compare(fit, before, after):
    require([n for n, _ in before] == [n for n, _ in after], "other blocks move")
    n_pieces = 0
    for (number, was), (_, now) in zip(before[1:], after[1:]):  # behind START
        try:
            n_pieces += compare_block(fit, was, now)
        except Difference as difference:
            raise Difference(f"N{number}: {difference}") from None
    return n_pieces


def numbered(text):
    """Blocks without an N word get one."""
    n = itertools.count(1001)
    return re.sub(r"^(?=[GXYZFMS])", lambda _: f"N{next(n)} ", text, flags=re.MULTILINE)


def moved(program, fit, text, unit, folder):
    path = folder / "program.ngc"
    path.write_text(text)
    done = subprocess.run([program, path, *fit.words(), *([unit] if unit else [])],
                          capture_output=True, text=True)
    require(done.returncode == 0, "refused:", done.stderr)
    return done.stdout


def end(text):
    """LinuxCNC wants an end."""
    return text if re.search(r"M0?2\b|M30|^%", text, re.MULTILINE) else text + "M2\n"


def under(modes, text):
    """A program behind START and a line of modal words; % stays first."""
    begin = START + modes + "\n"
    return text.replace("%\n", "%\n" + begin, 1) if text.startswith("%") else begin + text


def check(program, fit, text, unit, folder):
    text = end(numbered(text))
    out = moved(program, fit, text, unit, folder)
    is_inch = unit == "inch" or (not unit and re.search("G20|G21", text)[0] == "G20")
    usual = MODES + (" G20" if is_inch else " G21")
    opposite = "G18 G91 G90.1 G93 G99" + (" G21" if is_inch else " G20")
    before = by_block(under(usual, text), folder, "before.ngc")
    after = by_block(under(opposite, out), folder, "after.ngc")
    return compare(fit, before, after), before, out


# --- random programs ------------------------------------------------------------------------------


class MovedWriter(Writer):
    """Adds what `surface apply` refuses."""

    def __init__(self, draw):
        super().__init__(draw, AREA, 0.1)
        self.zero = [0.0, 0.0]
        self.subprograms = []

    def place(self):
        return tuple(value - zero for value, zero in zip(super().place(), self.zero))

    def shift(self):
        """G92 sets where the tool stands, G52 where the zero is."""
        if self.unit != 1:
            return
        code = self.random.choice(("G92", "G52", "G92.1"))
        axes = self.random.choice(([0], [1], [0, 1])) if code != "G92.1" else []
        words = [code]
        if code == "G92.1":
            for axis in (0, 1):
                self.at[axis], self.zero[axis] = self.at[axis] + self.zero[axis], 0.0
        for axis in axes:
            value = round(self.random.uniform(-15, 15), 3)
            words.append(f"{'XY'[axis]}{value}")
            work = self.at[axis] + self.zero[axis]
            self.zero[axis] = value if code == "G52" else work - value
            self.at[axis] = work - self.zero[axis]
        self.block(*words, comment=False)
        # Away from the place where arcs would be drawn beyond the area.
        self.block("G90 G0", *self.moved_to())

    def moved_to(self):
        self.is_incremental = False
        self.motion = "G0"
        return self.axes([*self.place(), None])

    def subprogram(self):
        """Steps there and back, called once or again and again."""
        name = len(self.subprograms) + 1
        self.number += 4
        x, y = (round(self.random.uniform(1, 9), 2) for _ in range(2))
        n = self.number
        self.subprograms.append(f"o{name} sub\nN{n - 3} G91 G21 G1 X{x} F200\nN{n - 2} Y{y}\n"
                                f"N{n - 1} G2 X{-x} Y{-y} I{-x / 2:.4f} J{-y / 2:.4f}\nN{n} G90\n"
                                f"o{name} endsub")
        if self.has_absolute_arcs:
            self.block("G91.1", comment=False)
            self.has_absolute_arcs = False
        n_times = self.random.randint(1, 3)
        self.lines += ([f"o{name} call"] if n_times == 1 else
                       [f"o{50 + name} repeat [{n_times}]", f"o{name} call", f"o{50 + name} endrepeat"])
        self.is_incremental, self.unit, self.motion = False, 1, "G2"
        self.block("G0", *self.moved_to())

    def holes_in_steps(self):
        self.block("G90 G0", *self.axes_in_g90([None, None, self.travel]))
        code = self.random.choice(("G81", "G82", "G85"))
        r, z = round(self.random.uniform(-1.5, -0.1), 2), round(self.random.uniform(-2, -0.2), 2)
        self.block("G91", self.random.choice(("G98", "G99")), code, f"X{self.step(0)} Y{self.step(1)}",
                   f"Z{z / self.unit:.4f} R{r / self.unit:.4f}", "P0.1" if code == "G82" else "", self.feed())
        for _ in range(self.random.randint(0, 3)):
            axis = self.random.randint(0, 1)
            self.block(f"{'XY'[axis]}{self.step(axis)}")
        self.block("G80 G90")
        self.motion, self.is_incremental = None, False
        self.block("G0", *self.axes_in_g90([None, None, self.travel]))
        self.motion = "G0"

    def step(self, axis):
        text = f"{self.random.uniform(-5, 5) / self.unit:.4f}"
        self.at[axis] += float(text) * self.unit
        return text

    def axes_in_g90(self, target):
        self.is_incremental = False
        return self.axes(target)

    def variables(self):
        name = self.random.choice(("#31", "#<feed rate>"))
        self.lines.append(f"{name} = {self.random.randint(20, 400)}")
        x, y = self.place()
        self.motion = "G1"
        self.block("G1", *self.axes([x, y, None]), f"F[{name}*2]")

    def machine_move(self):
        self.lines += ["G90", "G53 G0 Z0"]
        self.is_incremental = False
        self.block("G90 G0", *self.axes([None, None, self.travel]))
        self.motion = "G0"

    def program(self, n_steps):
        unit = self.start()
        steps = ([self.line] * 8 + [self.arc] * 10 + [self.series] * 2 + [self.modes] * 2 +
                 [self.other, self.shift, self.subprogram, self.holes_in_steps, self.variables,
                  self.machine_move])
        for _ in range(n_steps):
            self.random.choice(steps)()
        self.lines.append("M2")
        return Program("\n".join([*self.subprograms, *self.lines]) + "\n", unit, None)


# --- tests ----------------------------------------------------------------------------------------


def check_styles(program, draw, folder):
    """Gives the number of programs that moved."""
    files = sorted((Path(__file__).parent / "gcode").glob("*.ngc"))
    assert len(files) >= 5, files
    for file in files:
        fits = [Fit(1, 0, 0, 1, 0, 0), *(random_fit(draw, False) for _ in range(7))]
        for fit in fits:
            try:
                n_pieces, before, _ = check(program, fit, file.read_text(), None, folder)
            except Difference as difference:
                raise Difference(f"{file.name} under {fit}: {difference}") from None
            assert n_pieces >= sum(len(group) for _, group in before[1:]) > 5, file
    return len(files)


def check_that_faults_are_found(program, folder):
    """A fit that is 3 um off somewhere, and a changed number, must show."""
    text = (Path(__file__).parent / "gcode" / "outline_arcs.ngc").read_text()
    fit = Fit(0.9998, -0.02, 0.02, 0.9998, 12, -7)
    _, before, out = check(program, fit, text, None, folder)

    def finds(what, other_fit, other_text):
        try:
            compare(other_fit, before, by_block(under("", other_text), folder, "after.ngc"))
        except Difference:
            return
        raise SystemExit(f"not found: {what}")

    compare(fit, before, by_block(under("", out), folder, "after.ngc"))
    finds("an offset of 3 um", Fit(0.9998, -0.02, 0.02, 0.9998, 12.003, -7), out)
    finds("a rotation of 30 urad", Fit(0.9998, -0.02003, 0.02003, 0.9998, 12, -7), out)
    finds("a stretch of 30 ppm", Fit(0.99983, -0.02, 0.02, 0.9998, 12, -7), out)
    for old, new in (("G2 ", "G3 "), ("Z-0.8", "Z-0.9"), ("F300", "F299"), ("G0 Z5.", "G1 Z5.")):
        assert old in out, (old, out)
        finds(f"{new} for {old}", fit, out.replace(old, new, 1))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--programs", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if shutil.which("rs274") is None:
        print("rs274 is not installed (Debian: linuxcnc-uspace)")
        return 77
    draw = random.Random(options.seed)
    n_pieces, n_moves, text = 0, 0, ""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        check_that_faults_are_found(options.program, folder)
        n_styles = check_styles(options.program, draw, folder)
        for i in range(options.programs):
            fit = random_fit(draw, True)
            random_program = MovedWriter(draw).program(30)
            text = random_program.text
            try:
                n, before, _ = check(options.program, fit, text, random_program.unit, folder)
            except Difference as difference:
                print(f"program {i} of seed {options.seed} under {fit}:\n{text}\n{difference}")
                return 1
            n_pieces += n
            n_moves += sum(len(group) for _, group in before)
    print(f"{n_styles} styles; {options.programs} random programs, {n_moves} moves, {n_pieces} after")
    assert n_moves > 20 * options.programs
    return 0


if __name__ == "__main__":
    sys.exit(main())
