# SPDX-License-Identifier: Apache-2.0
"""Random G-code programs of what `panelcal surface apply` understands.

Every block that moves has an N word, so that what is made of it can be found again.
"""

import math
from dataclasses import dataclass, field

from canonical import INCH_MM

LONGEST = 252  # line that LinuxCNC reads
PECKS = ("G73", "G83")
CYCLES = ("G81", "G82", "G85", "G86", "G89", *PECKS)
# Modal words that a program may leave unstated, as `surface apply` then takes them.
MODES = {"plane": "G17", "distance": "G90", "arcs": "G91.1", "feed": "G94", "retract": "G98"}


@dataclass
class Program:
    text: str
    unit: str  # for --unit; empty: the program states it
    safe: float  # for --safe-mm; None: the lowest travel
    cycles: dict = field(default_factory=dict)  # N word: the cycle's code


class Writer:
    """Writes one program, and keeps the state that a control has then; lengths in mm."""

    def __init__(self, random, area, board):
        """In    area: least and greatest X and Y; board: what every travel is above."""
        self.random = random
        self.x_range, self.y_range = area
        self.board = board
        self.travel = round(board + random.uniform(0.2, 3), 2)
        self.safe = random.choice((None, round(random.uniform(board + 0.02, self.travel), 3)))
        self.unit = random.choice((1, 1, 1, INCH_MM))
        self.is_incremental = self.has_absolute_arcs = self.returns_to_r = False
        self.motion = None
        self.at = [0.0, 0.0, 0.0]
        self.number = 0
        self.lines = []
        self.cycles = {}

    def chance(self, probability):
        return self.random.random() < probability

    # --- words -----------------------------------------------------------------------------------

    def word(self, letter, value):
        """The word of a length, and the length that it has."""
        text = f"{value / self.unit:.{5 if self.unit > 1 else self.random.choice((2, 3, 4))}f}"
        return letter + text, float(text) * self.unit

    def axes(self, target):
        """Words that lead to a target, which may be absent for axes that stay; moves there."""
        words = []
        for axis, (letter, value) in enumerate(zip("XYZ", target)):
            if value is None:
                continue
            start = self.at[axis] if self.is_incremental else 0
            text, length = self.word(letter, value - start)
            words.append(text)
            self.at[axis] = start + length
        return words

    def block(self, *words, comment=True):
        """A line with a number; gives the number."""
        self.number += 1
        line = self.random.choice((" ", " ", "")).join([f"N{self.number}", *filter(None, words)])
        if comment and self.chance(0.05):
            line += f" ({'c' * self.random.randint(0, LONGEST - 3 - len(line))})"
        self.lines.append(line)
        return self.number

    def motion_word(self, code):
        """A code may be left out where it is in force."""
        if code == self.motion and self.chance(0.5):
            return ""
        self.motion = code
        return code

    def feed(self):
        return f"F{self.random.randint(2, 40) * (1 if self.unit > 1 else 20)}"

    def perhaps_feed(self):
        return self.feed() if self.chance(0.1) else ""

    # --- places ----------------------------------------------------------------------------------

    def place(self):
        return self.random.uniform(*self.x_range), self.random.uniform(*self.y_range)

    def height(self):
        """Into the board, just above it, about the safe height, or in the clear."""
        about = self.safe or self.travel
        return self.random.choice((self.random.uniform(-1.5, -0.02),
                                   self.random.uniform(-0.3, about),
                                   self.random.uniform(about - 0.1, about + 0.1),
                                   self.travel, self.travel,
                                   self.travel + self.random.uniform(0, 3)))

    # --- moves -----------------------------------------------------------------------------------

    def line(self):
        code = self.random.choice(("G0", "G1", "G1"))
        x, y = self.place()
        target = [x if self.chance(0.8) else None, y if self.chance(0.8) else None,
                  self.height() if self.chance(0.5) else None]
        if not any(value is not None for value in target):
            return
        self.block(self.motion_word(code), *self.axes(target), self.perhaps_feed())

    def arc(self):
        """An arc or a helix about a centre beside the tool, by centre or radius; or a circle."""
        x, y, z = self.at
        radius = self.random.uniform(0.5, 25)
        angle = self.random.uniform(-math.pi, math.pi)
        center = [x + radius * math.cos(angle), y + radius * math.sin(angle)]
        if not all(low < value - radius and value + radius < high
                   for value, (low, high) in zip(center, (self.x_range, self.y_range))):
            return
        rise = [self.height() if self.chance(0.4) else None]
        code = self.random.choice(("G2", "G3"))
        if self.chance(0.2):
            self.block(self.motion_word(code), *self.axes([None, None, *rise]),
                       *self.center(center, (x, y)), self.perhaps_feed())
            return
        sweep = self.random.uniform(0.2, 6 if self.chance(0.6) else 1)
        turned = angle + math.pi + (sweep if code == "G3" else -sweep)
        end = [center[0] + radius * math.cos(turned), center[1] + radius * math.sin(turned)]
        words = self.axes([*end, *rise])
        if sweep < 5.5 and self.chance(0.4):
            # About half a circle the end may be rounded to where R does not reach.
            if abs(sweep - math.pi) < 0.6:
                radius += 0.02
            words.append(self.word("R", radius if sweep < math.pi else -radius)[0])
        else:
            words += self.center(center, (x, y))
        self.block(self.motion_word(code), *words, self.perhaps_feed())

    def center(self, center, begin):
        if not self.has_absolute_arcs:
            center = [value - start for value, start in zip(center, begin)]
        return [f"{letter}{value / self.unit:.6f}" for letter, value in zip("IJ", center)]

    # --- cycles ----------------------------------------------------------------------------------

    def series(self):
        """Holes by drilling cycles, which begin in the clear or just below it."""
        if self.is_incremental:
            self.is_incremental = False
            self.block("G90")
        floor = self.safe or self.board + 0.01
        starts_low = self.chance(0.15)
        start = floor - self.random.uniform(0.005, 0.1) if starts_low else self.travel
        self.block(self.motion_word("G0"), *self.axes([None, None, start]))
        began = self.at[2]
        for i_hole in range(self.random.randint(1, 5)):
            code = self.random.choice(CYCLES)
            words = []
            if i_hole == 0 or code != self.motion and self.chance(0.4):
                mode = self.random.choice(("G98", "G99", ""))
                self.returns_to_r = mode == "G99" or self.returns_to_r and not mode
                # Between holes the tool travels in the clear.
                is_high = starts_low or self.returns_to_r or self.chance(0.2)
                retract = (floor + self.random.uniform(0.005, 1) if is_high
                           else self.random.uniform(0.05, floor))
                self.motion = code
                words += [code, mode, *self.depth(code, retract)]
            elif self.chance(0.2):
                words += self.depth(self.motion, self.retract)
            x, y = self.place()
            chosen = self.random.choice(((x, y), (x, None), (None, y))) if i_hole else (x, y)
            if self.chance(0.1):
                words.append("L1")
            number = self.block(*words, *self.axes([*chosen, None]), self.perhaps_feed())
            self.cycles[number] = self.motion
            self.at[2] = self.retract if self.returns_to_r else max(self.retract, began)
        if self.chance(0.5):
            self.block("G80")
            self.motion = None
        if self.chance(0.5):
            self.block(self.motion_word("G0"), *self.axes([None, None, self.travel]))

    def depth(self, code, retract):
        """Z, R and what else the cycle wants; no last peck is so short that rounding adds it."""
        r_word, retract = self.word("R", retract)
        self.retract = retract
        peck = self.random.uniform(0.3, 0.9)
        n_pecks = math.floor((retract + 0.5) / peck) + 1
        bottom = retract - (n_pecks + self.random.uniform(-0.7, -0.3)) * peck
        words = [self.word("Z", bottom)[0], r_word]
        if code in PECKS:
            words.append(f"Q{peck / self.unit:.5f}")
        if code in ("G82", "G86", "G89"):
            words.append("P0.1")
        return words

    # --- the rest --------------------------------------------------------------------------------

    def modes(self):
        """Switches of unit, distance and arcs, alone in a block or beside a move."""
        words = []
        if self.chance(0.3):
            self.unit = INCH_MM if self.unit == 1 else 1
            words += ["G20" if self.unit > 1 else "G21", self.feed()]
        if self.chance(0.5):
            self.is_incremental = not self.is_incremental
            words.append("G91" if self.is_incremental else "G90")
        if self.chance(0.3):
            self.has_absolute_arcs = not self.has_absolute_arcs
            words.append("G90.1" if self.has_absolute_arcs else "G91.1")
        if self.chance(0.5):
            x, y = self.place()
            self.motion = "G1"
            words += ["G1", *self.axes([x, y, None])]
        if words:
            self.block(*words)

    def other(self):
        what = self.random.choice(("G4 P0.1", "M8", "(a remark)", "", "tool"))
        if what != "tool":
            self.lines.append(what)
        elif not self.is_incremental:
            self.block(f"T{self.random.randint(1, 9)} M6")
            self.block("G0", *self.axes([None, None, self.travel]))
            self.block("G0", *self.axes([*self.place(), None]))
            self.block("M3 S9000")
            self.motion = "G0"

    def start(self):
        """Some of the modal words; then up, and to a place. Gives the unit if it is not stated."""
        modes = [word for word in MODES.values() if self.chance(0.5)]
        unit = "G20" if self.unit > 1 else "G21"
        states_unit = self.chance(0.7)
        modes += [unit] if states_unit else []
        self.random.shuffle(modes)
        if modes:
            self.block(*modes, "G54" if self.chance(0.3) else "", comment=False)
        self.block(self.feed(), "M3 S9000")
        self.block("G0", *self.axes([None, None, self.travel]))
        self.block("G0", *self.axes([*self.place(), None]))
        self.motion = "G0"
        return "" if states_unit else "inch" if self.unit > 1 else "mm"

    def program(self, n_steps):
        unit = self.start()
        steps = ([self.line] * 8 + [self.arc] * 8 + [self.series] * 2 + [self.modes] * 2 +
                 [self.other])
        for _ in range(n_steps):
            self.random.choice(steps)()
        self.block("G0", *self.axes([None, None, self.travel]))
        self.lines.append("M2")
        if self.chance(0.2):
            self.lines = ["%", *self.lines, "%"]
        return Program("\n".join(self.lines) + "\n", unit, self.safe, self.cycles)


def random_program(random, area, board, n_steps=30):
    return Writer(random, area, board).program(n_steps)
