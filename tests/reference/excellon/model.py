# SPDX-License-Identifier: Apache-2.0
"""Operations, tools and placements of a part program.

Lengths are exact `Fraction` values in mm, in the programmed frame: coordinates relative to work zero.
"""
from dataclasses import dataclass, field, replace
from fractions import Fraction


class Refused(Exception):
    """A program that the manual does not explain: 1-based source line and reason."""

    def __init__(self, line, reason):
        super().__init__(f'line {line}: {reason}')
        self.line = line
        self.reason = reason


@dataclass
class Tool:
    """One row of the Tool Data Page; None where the program states nothing."""

    number: int
    diameter_mm: Fraction | None = None
    feed_mm_s: Fraction | None = None
    speed_rpm: Fraction | None = None
    retract_mm_s: Fraction | None = None
    max_hits: int | None = None
    depth_offset_mm: Fraction | None = None
    header_words: set = field(default_factory=set)  # letters that the header set: the body cannot change them


@dataclass(frozen=True)
class Placement:
    """Place of one copy of a pattern: mirrors first, then the swap of axes, then the offset.

    x' = xx * x + xy * y + dx,  y' = yx * x + yy * y + dy, all mm. The order of mirrors and swap, and the
    offset that the copy's own mirrors leave alone, follow from the sample program's nested L patterns.
    """

    xx: int = 1
    xy: int = 0
    yx: int = 0
    yy: int = 1
    dx: Fraction = Fraction(0)
    dy: Fraction = Fraction(0)

    @staticmethod
    def of(mirror_x, mirror_y, swap, dx, dy):
        """Placement of one M02 block: M80, M90, M70 and the accumulated offset."""
        sx = -1 if mirror_x else 1
        sy = -1 if mirror_y else 1
        if swap:
            return Placement(0, sy, sx, 0, dx, dy)
        return Placement(sx, 0, 0, sy, dx, dy)

    def apply(self, point):
        x, y = point if self.xx else (point[1], point[0])  # signs and a swap: no product of fractions
        x = x if self.xx + self.xy > 0 else -x
        y = y if self.yx + self.yy > 0 else -y
        return (x + self.dx, y + self.dy)

    def after(self, inner):
        """The placement that applies `inner` first and this one to its result."""
        dx, dy = self.apply((inner.dx, inner.dy))
        return Placement(self.xx * inner.xx + self.xy * inner.yx, self.xx * inner.xy + self.xy * inner.yy,
                         self.yx * inner.xx + self.yy * inner.yx, self.yx * inner.xy + self.yy * inner.yy, dx, dy)

    def reflects(self):
        """True if the copy is a mirror image: clockwise becomes counter-clockwise."""
        return self.xx * self.yy - self.xy * self.yx < 0


HERE = Placement()


@dataclass(frozen=True)
class Operation:
    """One thing that the machine does.

    kind           points                                      values
    hole           position                                    -
    position       end of a move with the tool up              -
    holes          all holes; the manual gives no order        code
    ring           centre                                      ring_radius_mm, hole_diameter_mm
    slot           start, end                                  -
    text           anchor, step along the line, step upwards   text
    plunge         position                                    contoured
    line           start, end                                  compensation (side, diameter), feed_mm_s
    arc            start, end, centre                          clockwise, compensation, feed_mm_s
    retract        position                                    -
    routed-circle  centre                                      path_radius_mm, clockwise
    step-slot      start, end                                  passes (offsets above the final depth, mm), increment_mm
    stop           place relative to absolute zero, or none    code
    dwell          -                                           increments: of 1 ms
    message        -                                           text

    Of a drilling command of several blocks `line` is the last one's; inside an M99 pattern it is that file's.
    `tool` is None, or a copy of the tool's data as they were in force. `path` has one index a level of
    step and repeat, the outermost first; None outside.
    """

    kind: str
    line: int
    tool: Tool | None
    points: tuple
    values: dict = field(default_factory=dict)
    zero_mm: tuple = (Fraction(0), Fraction(0))  # work zero relative to absolute zero, from G93
    file: str | None = None  # the M99 pattern
    path: tuple | None = None

    def placed(self, placement):
        """The same operation in a copy of its pattern."""
        if self.kind == 'stop' or placement is HERE:
            return self
        points = tuple(placement.apply(point) for point in self.points)
        values = dict(self.values)
        if self.kind == 'text':
            origin = (placement.dx, placement.dy)
            anchor, *steps = points
            points = (anchor, *((x - origin[0], y - origin[1]) for x, y in steps))
        if 'clockwise' in values and placement.reflects():
            values['clockwise'] = not values['clockwise']
        if values.get('compensation') and placement.reflects():
            side, diameter = values['compensation']
            values['compensation'] = ({'left': 'right', 'right': 'left'}[side], diameter)
        return replace(self, points=points, values=values)

    def as_json(self):
        """Plain values for `json.dumps`; lengths as decimal numbers in mm."""
        tool = self.tool and {'number': self.tool.number, 'diameter_mm': plain(self.tool.diameter_mm)}
        return {'kind': self.kind, 'line': self.line, 'file': self.file, 'path': plain(self.path), 'tool': tool,
                'points': plain(self.points), **{key: plain(value) for key, value in self.values.items()},
                'zero_mm': plain(self.zero_mm)}


def plain(value):
    if isinstance(value, Fraction):
        return float(value)
    if isinstance(value, (tuple, list)):
        return [plain(item) for item in value]
    return value
