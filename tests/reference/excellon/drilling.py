# SPDX-License-Identifier: Apache-2.0
"""Holes, repeats, canned drilling cycles, text. Sections "Canned Cycle Commands" to "Canned Text Offset"."""
from fractions import Fraction
import re

from .model import Refused
from .words import MM_PER_INCH, integer, split_words

MAX_PROTRUSION_MM = Fraction(5, 10000) * MM_PER_INCH  # G84 and G85: 0.0005 inch
DEFAULT_DRILL_MM = Fraction(1, 8) * MM_PER_INCH  # G84 with a tool of no size
DIP_PITCH_MM = Fraction(1, 10) * MM_PER_INCH
DIP_ROW_MM = Fraction(3, 10) * MM_PER_INCH
L_PACK_MM = Fraction(4, 10) * MM_PER_INCH
TEXT_PITCH_MM = Fraction(417, 10000) * MM_PER_INCH  # no diameter: letters of 0.25 inch, 4 by 7 holes
TEXT_CHARACTERS = re.compile(r'[A-Z0-9+/*,-]+')


def dip_holes(first, second, pitch, row, line):
    """All holes of a dual in line package between two opposite corners, in no particular order.

    The rows lie along the axis across which the corners are nearer to the row distance: the sample
    program's `G82X.1Y.4` between corners 1.3 by 0.3 has 28 holes.
    """
    span = (second[0] - first[0], second[1] - first[1])
    if pitch <= 0 or row <= 0 or 0 in span:
        raise Refused(line, 'a package without two rows')
    if abs(span[0]) == abs(span[1]):
        raise Refused(line, 'a square package')
    across_x, across_y = abs(abs(span[0]) - row), abs(abs(span[1]) - row)
    if across_x == across_y:
        raise Refused(line, 'a package whose rows may lie along either axis')
    along = 0 if across_y < across_x else 1
    steps = abs(span[along]) / pitch
    if steps.denominator != 1:
        raise Refused(line, 'a row that is no whole number of pitches')
    holes = []
    for i in range(int(steps) + 1):
        moved = first[along] + span[along] * i / int(steps)
        for across in (first[1 - along], second[1 - along]):
            holes.append((moved, across) if along == 0 else (across, moved))
    return tuple(holes)


def l_pack_holes(first, second, line):
    """Eight holes on a circle whose diameter joins two opposite holes of the package."""
    dx, dy = second[0] - first[0], second[1] - first[1]
    if (dx and dy) or abs(dx + dy) != L_PACK_MM:
        raise Refused(line, 'opposite holes that are not 0.4 inch apart on a centreline')
    cx, cy = (first[0] + second[0]) / 2, (first[1] + second[1]) / 2
    r = L_PACK_MM / 2
    d = r * Fraction(0.5 ** 0.5)
    offsets = ((r, 0), (d, d), (0, r), (-d, d), (-r, 0), (-d, -d), (0, -r), (d, -d))
    return tuple((cx + x, cy + y) for x, y in offsets)


def ring_holes_needed(hole_mm, drill_mm):
    """The smallest number of holes of a G84 ring whose protrusions are below 0.0005 inch."""
    import math
    ring, r = float(hole_mm - drill_mm) / 2, float(drill_mm) / 2
    for n in range(3, 1000000):
        half = math.pi / n
        inside = r * r - (ring * math.sin(half)) ** 2
        if inside > 0 and ring + r - ring * math.cos(half) - math.sqrt(inside) < float(MAX_PROTRUSION_MM):
            return n
    raise ValueError('no number of holes is enough')


def slot_pitch_limit_mm(drill_mm):
    """The distance of neighbouring holes of a G85 slot at which protrusions reach 0.0005 inch."""
    r, h = float(drill_mm) / 2, float(MAX_PROTRUSION_MM)
    return 2 * (2 * r * h - h * h) ** 0.5


class Drilling:
    """The part of the interpreter that drills; state is made by Interpreter."""

    def hole(self, words, line):
        self.move(words, line)
        self.emit('hole', (self.point(line),), line)
        self.last_hole = True

    def repeat_hole(self, words, line):
        """R#X#Y#: more holes at a spacing, from the hole before."""
        if self.routing or not self.last_hole:
            raise Refused(line, 'R without a hole before it')
        count = integer(words[0][1], line, 'R', 4)
        dx, dy = self.spacing(words[1:], line)
        if not count:
            raise Refused(line, 'R0')
        for _ in range(count):
            self.position = [self.position[0] + dx, self.position[1] + dy]
            self.emit('hole', (self.point(line),), line)

    def spacing(self, words, line):
        """X#Y# of R, P and M02: at least one axis, always a distance."""
        axes = self.axes(words, 'XY', line)
        if not axes:
            raise Refused(line, 'no spacing')
        return (self.format.length_mm(axes.get('X', ''), line), self.format.length_mm(axes.get('Y', ''), line))

    def canned(self, words, at, line):
        """X#Y#G84X#, X#Y#G85X#Y#, X#Y#G87X#Y#Z#U#: one block."""
        code = words[at][1]
        if self.plunged:
            raise Refused(line, f'G{code} in the rout position')
        self.move(words[:at], line)
        if code == '84':
            self.circle(words[at + 1:], line)
        elif code == '85':
            self.slot(words[at + 1:], line)
        elif code == '87':
            self.step_slot(words[at + 1:], line)
        else:
            raise Refused(line, f'G{code} after coordinates')

    def circle(self, words, line):
        axes = self.axes(words, 'X', line)
        hole = self.format.length_mm(axes.get('X', ''), line)
        drill = self.current_tool(line).diameter_mm or DEFAULT_DRILL_MM
        if hole < 2 * drill:
            raise Refused(line, 'G84 below twice the tool diameter')
        self.stored('ring', (self.point(line),), line, ring_radius_mm=(hole - drill) / 2, hole_diameter_mm=hole)

    def slot(self, words, line):
        if not self.current_tool(line).diameter_mm:
            raise Refused(line, 'G85 with a tool of no size')
        start = self.point(line)
        self.move(words, line)
        self.stored('slot', (start, self.point(line)), line)

    def package(self, code, words, line):
        """G81, G82, G83: the code and two blocks with corners."""
        if self.plunged:
            raise Refused(line, f'G{code} in the rout position')
        axes = self.axes(words, 'XY' if code == '82' else '', line)
        if axes and set(axes) != {'X', 'Y'}:
            raise Refused(line, 'G82 with one of its two spacings')
        corners = []
        for _ in range(2):
            line, text = self.cursor.next_block(line)
            self.move(split_words(text, line), line)
            corners.append(self.point(line))
        if code == '83':
            holes = l_pack_holes(*corners, line)
        else:
            pitch, row = DIP_PITCH_MM, DIP_ROW_MM
            if axes:
                pitch, row = (self.format.length_mm(axes[axis], line) for axis in 'XY')
            holes = dip_holes(*corners, pitch, row, line)
        self.stored('holes', holes, line, code=f'G{code}')

    def stored(self, kind, points, line, **values):
        """Emits a stored pattern, which P may repeat. It ends the rout mode ("Drilling and Routing Commands")."""
        self.drill_mode()

        def again(dx, dy, at):
            self.emit(kind, tuple((x + dx, y + dy) for x, y in points), at, **values)

        again(0, 0, line)
        self.pattern, self.pattern_offset = again, (Fraction(0), Fraction(0))

    def repeat_pattern(self, words, line):
        """P#X#Y#: the stored pattern again, each start at the spacing from the one before."""
        count = integer(words[0][1], line, 'P', 3)
        spacing = self.spacing(words[1:], line)
        if self.pattern is None or not count:
            raise Refused(line, 'P without a stored pattern directly before it')
        again, (x, y) = self.pattern, self.pattern_offset
        for _ in range(count):
            x, y = x + spacing[0], y + spacing[1]
            again(x, y, line)
        self.forget_position()
        self.pattern, self.pattern_offset = again, (x, y)

    def text(self, code, text):
        """M97,text and M98,text with the block of their start. The manual has no letter shapes: none are drawn."""
        line, block = self.cursor.next_block(self.cursor.line())
        if self.routing or not TEXT_CHARACTERS.fullmatch(text):
            raise Refused(line, f'text "{text}"')
        self.move(split_words(block, line), line)
        x, y = self.point(line)
        start = (x + self.text_offset[0], y + self.text_offset[1])
        diameter = self.current_tool(line).diameter_mm
        pitch = diameter * Fraction(6, 5) if diameter else TEXT_PITCH_MM
        steps = ((pitch, Fraction(0)), (Fraction(0), pitch))
        if code == '98':
            steps = (steps[1], (-pitch, Fraction(0)))
        # OPID is a keyboard command: without it an asterisk closes up.
        drawn = text.replace(',', ' ').replace('*', '')
        self.emit('text', (start, *steps), line, text=drawn)

    def text_offset_command(self, options, line):
        """CAN_TEXT_OFF,#,#"""
        if len(options) > 2:
            raise Refused(line, 'CAN_TEXT_OFF with more than two numbers')
        for axis, option in enumerate(options):
            self.text_offset[axis] = self.format.length_mm(option, line)
