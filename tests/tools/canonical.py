# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC's canonical commands: what its interpreter makes of a G-code program."""

import math
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

INCH_MM = 25.4
# rs274 prints four decimals, in the program's unit.
PRINTED = 1e-4
COMMAND = re.compile(r"^\s*\d+ N(\S+)\s+(\w+)\((.*)\)$")


class Refused(Exception):
    """The interpreter does not execute the program."""


def interpret(program):
    """The canonical commands of a program file, one a line; fails on what rs274 refuses."""
    tools = Path(program).with_name("tool.tbl")
    tools.write_text("".join(f"T{number} P{number}\n" for number in range(1, 10)))
    done = subprocess.run(["rs274", "-t", tools, "-g", program], capture_output=True, text=True)
    if done.returncode != 0:
        raise Refused(done.stdout[-500:] + done.stderr)
    return done.stdout


@dataclass(frozen=True)
class Move:
    """A straight move, an arc or a helix; mm, and mm/min."""

    block: int  # N word of its line, or of the last line that has one
    is_rapid: bool
    begin: tuple
    end: tuple
    feed: float
    printed: float  # the coarser step of the printed begin and end, mm
    center: tuple = None  # of an arc
    is_clockwise: bool = False

    @property
    def sweep(self):
        """Counter-clockwise positive; an arc that ends where it begins is a full circle."""
        if math.dist(self.begin[:2], self.end[:2]) < 2 * self.printed:
            return -2 * math.pi if self.is_clockwise else 2 * math.pi
        turn = self.angle(self.end) - self.angle(self.begin)
        return turn % (2 * math.pi) - (2 * math.pi if self.is_clockwise else 0)

    def angle(self, place):
        return math.atan2(place[1] - self.center[1], place[0] - self.center[0])

    @property
    def radii(self):
        """At the begin and at the end, which differ by the digits of the program."""
        return tuple(math.dist(place[:2], self.center) for place in (self.begin, self.end))

    @property
    def length(self):
        """In X and Y."""
        if self.center:
            return abs(self.sweep) * sum(self.radii) / 2
        return math.dist(self.begin[:2], self.end[:2])

    @property
    def slope(self):
        return abs(self.end[2] - self.begin[2]) / self.length

    def at(self, part):
        """The place at a part of its length, 0 to 1."""
        z = self.begin[2] + part * (self.end[2] - self.begin[2])
        if not self.center:
            return tuple(a + part * (b - a) for a, b in zip(self.begin[:2], self.end[:2])) + (z,)
        angle = self.angle(self.begin) + part * self.sweep
        radius = self.radii[0] + part * (self.radii[1] - self.radii[0])
        return (self.center[0] + radius * math.cos(angle),
                self.center[1] + radius * math.sin(angle), z)

    def part_near(self, place, guess):
        """The part at which the move is nearest to a place; `guess` says which turn of an arc."""
        if self.center:
            part = (self.angle(place) - self.angle(self.begin)) / self.sweep
            turn = 2 * math.pi / abs(self.sweep)
            part += turn * round((guess - part) / turn)
        else:
            part = sum((p - a) * (b - a) for p, a, b in zip(place, self.begin[:2], self.end[:2]))
            part /= self.length**2
        return min(1, max(0, part))


def shifted(place, by):
    return tuple(a + b for a, b in zip(place, by))


def moves(commands):
    """The moves among canonical commands, in order, in the coordinates of G54 to G59."""
    found, unit, feed, block = [], 1, 0, 0
    at, last_unit = (0.0, 0.0, 0.0), 1
    zero = (0.0, 0.0, 0.0)  # of G92 and G52; what is printed counts from there
    for line in commands.splitlines():
        match = COMMAND.match(line)
        if not match:
            continue
        number, name, text = match.groups()
        block = block if number.startswith(".") else int(number)
        if name == "USE_LENGTH_UNITS":
            unit = INCH_MM if "INCHES" in text else 1
        elif name == "SET_FEED_RATE":
            feed = float(text) * unit
        elif name == "SET_G92_OFFSET":
            zero = tuple(float(number) * unit for number in text.split(",")[:3])
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "ARC_FEED"):
            numbers = [float(number) for number in text.split(",")]
            lengths = [number * unit for number in numbers]
            is_arc = name == "ARC_FEED"
            end = shifted((*lengths[:2], lengths[5 if is_arc else 2]), zero)
            arc = ({"center": shifted(lengths[2:4], zero), "is_clockwise": numbers[4] < 0}
                   if is_arc else {})
            found.append(Move(block, name == "STRAIGHT_TRAVERSE", at, end, feed,
                              PRINTED * max(unit, last_unit), **arc))
            at, last_unit = end, unit
    return found
