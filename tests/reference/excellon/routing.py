# SPDX-License-Identifier: Apache-2.0
"""Rout mode: moves, arcs, plunges, routed circles and step slots. Section "Routing Commands"."""
from fractions import Fraction
import math

from .model import Refused
from .setup import fraction_sqrt
from .words import MM_PER_INCH

# A centre offset and its end point are rounded to the coordinate grid: one 10 um step of the coarsest format each.
MAX_CENTRE_MISFIT_MM = Fraction(2, 100)
DEFAULT_TABLE_FEED_MM_S = 100 * MM_PER_INCH / 60
CIRCLE_CLEARANCE_MM = Fraction(1, 100) * MM_PER_INCH


def arc_centre(start, end, radius, clockwise, line):
    """Centre of the arc of at most 180 degrees with the given radius."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    chord2 = dx * dx + dy * dy
    height2 = radius * radius - chord2 / 4
    if radius <= 0 or not chord2 or height2 < 0:
        raise Refused(line, 'a radius that does not fit the coordinates')
    factor = fraction_sqrt(height2 / chord2) * (-1 if clockwise else 1)
    return ((start[0] + end[0]) / 2 - dy * factor, (start[1] + end[1]) / 2 + dx * factor)


def check_centre(start, end, centre, clockwise, line):
    """Refuses a centre that the end does not fit, and an arc of more than 180 degrees."""
    a = (start[0] - centre[0], start[1] - centre[1])
    b = (end[0] - centre[0], end[1] - centre[1])
    if abs(math.hypot(*map(float, a)) - math.hypot(*map(float, b))) > MAX_CENTRE_MISFIT_MM:
        raise Refused(line, 'a centre offset that does not fit the coordinates')
    turn = (a[0] * b[1] - a[1] * b[0]) * (-1 if clockwise else 1)
    if start == end or turn < 0:
        raise Refused(line, 'an arc of more than 180 degrees')


class Routing:
    """The part of the interpreter that routs; state is made by Interpreter."""

    def rout_block(self, code, words, line):
        """G00, G01, G02, G03 with their words, or a block of words under the mode in force (code None)."""
        if code == '00' and self.plunged:
            raise Refused(line, 'G00 in the rout position')
        if code == '00':
            self.routing, self.side = True, None
            self.start_pattern_break()
        if not self.routing:
            raise Refused(line, 'a rout move without G00')
        if code is not None:
            self.interpolation = code
        axes = self.axes(words, 'XYAIJF', line)
        if 'F' in axes:
            self.state_table_feed(axes.pop('F'), line)
        self.arc_words(axes, line)
        if not axes:
            return
        if self.interpolation is None or (self.interpolation == '00' and self.plunged):
            raise Refused(line, 'a move whose mode is not stated')
        start = self.point(line) if self.interpolation != '00' else None
        self.move(list(axes.items()), line)
        if self.interpolation == '00':
            self.emit('position', (self.point(line),), line)
            return
        if not self.plunged:
            raise Refused(line, 'a rout move before M14 or M15')
        self.cut(start, self.point(line), line)

    def arc_words(self, axes, line):
        """A, or I and J: in force until the next ones."""
        if 'A' in axes:
            if 'I' in axes or 'J' in axes:
                raise Refused(line, 'A together with I and J')
            self.arc = ('A', self.format.length_mm(axes.pop('A'), line))
        elif 'I' in axes or 'J' in axes:
            offset = [self.format.length_mm(axes.pop(letter, ''), line) for letter in 'IJ']
            self.arc = ('IJ', tuple(offset))

    def state_table_feed(self, text, line):
        self.table_feed_mm_s, self.feed_unclear = self.feed_mm_s(text, line), False

    def cut(self, start, end, line):
        if self.feed_unclear:
            raise Refused(line, 'a feed that the pattern states only behind its use')
        if self.interpolation == '01':
            self.emit('line', (start, end), line, compensation=self.compensation(), feed_mm_s=self.table_feed_mm_s)
            return
        clockwise = self.interpolation == '02'
        if self.arc is None:
            raise Refused(line, 'an arc without A or I and J')
        kind, value = self.arc
        if kind == 'A':
            centre = arc_centre(start, end, value, clockwise, line)
        else:
            # "Arc Center Offset": I and J are measured from the centre to the start.
            centre = (start[0] - value[0], start[1] - value[1])
            check_centre(start, end, centre, clockwise, line)
        self.emit('arc', (start, end, centre), line, clockwise=clockwise, compensation=self.compensation(),
                  feed_mm_s=self.table_feed_mm_s)

    def compensation(self):
        """(side, diameter in mm) of the compensation in force, or None."""
        return (self.side, self.compensation_mm[self.tool_index]) if self.side else None

    def plunge(self, code, line):
        if not self.routing or self.plunged:
            raise Refused(line, f'M{code} outside the rout mode or in the rout position')
        self.plunged = True
        self.emit('plunge', (self.point(line),), line, contoured=code == '14')

    def retract(self, code, line):
        if not self.plunged:
            raise Refused(line, f'M{code} without M14 or M15')
        self.plunged = False
        self.emit('retract', (self.point(line),), line)

    def compensate(self, code, line):
        if self.plunged:
            raise Refused(line, f'G{code} in the rout position')
        if code != '40':
            self.compensation_of(self.tool_index, line)
        self.side = {'40': None, '41': 'left', '42': 'right'}[code]

    def routed_circle(self, code, words, line):
        """G32X#Y#A#, G33X#Y#A#: inside circle, always compensated."""
        if self.plunged:
            raise Refused(line, f'G{code} in the rout position')
        axes = self.axes(words, 'XYA', line)
        self.arc_words(axes, line)
        self.move(list(axes.items()), line)
        if self.arc is None or self.arc[0] != 'A':
            raise Refused(line, f'G{code} without a radius')
        half = self.compensation_of(self.tool_index_of(line), line) / 2
        if self.arc[1] < half + CIRCLE_CLEARANCE_MM:
            raise Refused(line, f'G{code} with a radius below half the compensation plus 0.01 inch')
        self.routing, self.interpolation, self.side = True, None, None
        self.emit('routed-circle', (self.point(line),), line, path_radius_mm=self.arc[1] - half, clockwise=code == '32')
        self.forget_position()

    def step_slot(self, words, line):
        """X#Y#G87X#Y#Z-#U#: passes from U above the final depth, each Z deeper, the last one at it."""
        axes = self.axes(words, 'XYZU', line)
        if 'Z' not in axes or 'U' not in axes:
            raise Refused(line, 'G87 without Z and U')
        step = self.format.length_mm(axes.pop('Z'), line)
        above = self.format.length_mm(axes.pop('U'), line)
        if step >= 0 or above < 0:
            raise Refused(line, 'G87 with a depth increment that is not negative')
        start = self.point(line)
        self.move(list(axes.items()), line)
        count = 1 + math.ceil(above / -step)
        passes = tuple(max(Fraction(0), above + step * i) for i in range(count))
        self.routing, self.interpolation, self.side = True, None, None
        self.emit('step-slot', (start, self.point(line)), line, passes=passes, increment_mm=step)
        self.forget_position()
