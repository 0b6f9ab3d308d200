# SPDX-License-Identifier: Apache-2.0
"""What a program asks for: operations, the state of depth that each is executed under, and placements."""

import dataclasses
from typing import Optional

Point = tuple[float, float]


@dataclasses.dataclass(frozen=True)
class Depth:
    """How deep a stroke goes, in the words of chapter 11. None is "the operator's value".

    reference   "table" (G82: depth_mm is Z, above Z0), "board" (G83: depth_mm is K, below the board's
                surface), "surface" (G71: depth_mm is K below the reference surface, negative: the web
                that stays above it)
    memory      number of the place in the surface memory that the L command fetched; only for "surface"
    lower_mm    Z, the lower limit of the movement, above Z0; never for "table", whose depth is Z itself
    upper_mm    H, the traveling plane: upper limit of the movement, above Z0
    """

    reference: str
    depth_mm: Optional[float]
    lower_mm: Optional[float]
    upper_mm: Optional[float]
    memory: Optional[int] = None


@dataclasses.dataclass(frozen=True)
class Operation:
    """One operation of the machine; lengths in mm, in the program's frame after all placements.

    kind  hole           at
          nibble_circle  center, radius
          nibble_slot    start, end
          text           at, direction (unit vector in which the text runs), string
          plunge         at: the tool goes down to rout
          line           start, end
          arc            start, end, center, clockwise
          circle         center, radius, clockwise, inside (G45, G46: a hole; else a disk), plunge if known
          rectangle      center, size, clockwise, plunge if known
          retract        at: the tool goes up, the contour ends
          measure        at: a camera measurement, "G32", "G33" or "G36" in string
          probe          at: a measurement of the surface, "G73", "G78" or "G79" in string
    pattern  ("V1", line, number of holes) for the holes of a row whose order the manual leaves open
    """

    kind: str
    line: int
    tool: Optional[int]
    depth: Optional[Depth] = None
    at: Optional[Point] = None
    start: Optional[Point] = None
    end: Optional[Point] = None
    center: Optional[Point] = None
    plunge: Optional[Point] = None
    radius: Optional[float] = None
    size: Optional[Point] = None
    direction: Optional[Point] = None
    clockwise: Optional[bool] = None
    inside: Optional[bool] = None
    compensation: Optional[str] = None  # "left", "right" of the direction of movement
    feed_m_min: Optional[float] = None
    round_mm: Optional[float] = None  # D: radius that rounds the corner at the end of this move
    ramp_from: Optional[Depth] = None  # G6: depth at the start of the move
    clear_area: bool = False  # G43
    cycle: Optional[tuple] = None  # ("peck", ((letter, value), ...)) or ("pulse", ...)
    string: Optional[str] = None
    pattern: Optional[tuple] = None


@dataclasses.dataclass(frozen=True)
class Placement:
    """p -> offset + matrix p: one copy of a program section."""

    a: int
    b: int
    c: int
    d: int
    offset: Point

    def point(self, p):
        return (self.offset[0] + self.a * p[0] + self.b * p[1], self.offset[1] + self.c * p[0] + self.d * p[1])

    def apply(self, operation):
        """The operation, executed in this copy. A mirror reverses arcs and the side of compensation."""
        changes = {}
        for name in ("at", "start", "end", "center", "plunge"):
            if getattr(operation, name) is not None:
                changes[name] = self.point(getattr(operation, name))
        if operation.direction is not None:
            x, y = operation.direction
            changes["direction"] = (self.a * x + self.b * y, self.c * x + self.d * y)
        if operation.size is not None and self.a == 0:
            changes["size"] = (operation.size[1], operation.size[0])
        if self.a * self.d - self.b * self.c < 0:
            if operation.clockwise is not None:
                changes["clockwise"] = not operation.clockwise
            if operation.compensation is not None:
                changes["compensation"] = {"left": "right", "right": "left"}[operation.compensation]
        return dataclasses.replace(operation, **changes)

    @property
    def is_translation(self):
        return (self.a, self.b, self.c, self.d) == (1, 0, 0, 1)


# Offset commands on one line -> rows of the matrix. manual: "M50" .. "M90", "Calculating offset
# coordinates": the formulas solved for the executed position, and checked against each example.
MATRICES = {
    frozenset({50}): (1, 0, 0, 1),
    frozenset({60}): (0, -1, 1, 0),
    frozenset({70}): (-1, 0, 0, 1),
    frozenset({80}): (1, 0, 0, -1),
    frozenset({90}): (-1, 0, 0, -1),
    frozenset({60, 70}): (0, 1, 1, 0),
    frozenset({60, 80}): (0, -1, -1, 0),
    frozenset({60, 90}): (0, 1, -1, 0),
}
