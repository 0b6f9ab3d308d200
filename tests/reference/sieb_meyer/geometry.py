# SPDX-License-Identifier: Apache-2.0
"""Rows of holes, centers of arcs and plunge points."""

import math

from .reader import Refusal

GRID_MM = 2.54  # manual: V1, "Standard grid = 2.54 mm (= 0.1 inch)"
# manual: I, "Calculate I and J on the basis of the coordinate values": the radii at the start and at
# the end of the manual's own example differ by 0.97 mm. An arc that misses by more is refused.
MAX_ARC_MISS_MM = 1.0


def steps(length, pitch, line):
    """Whole number of pitches nearest to a length; a tie of half a pitch is refused."""
    ratio = abs(length) / pitch
    if abs(ratio - math.floor(ratio) - 0.5) < 1e-9:
        raise Refusal(line, "the corner lies half a pitch between two points of the grid")
    n = round(ratio)
    if n < 1:
        raise Refusal(line, "the corner lies on the row of the first point")
    return n


def single_row(p1, p2, w, line):
    """V2. manual: "Distance = (P2 - P1) / (W - 1)"."""
    if w is None or w < 2:
        raise Refusal(line, "V2 needs W, the number of holes, two or more")
    return [(p1[0] + (p2[0] - p1[0]) * k / (w - 1), p1[1] + (p2[1] - p1[1]) * k / (w - 1)) for k in range(w)]


def dual_row(p1, p2, w, line):
    """V1. The rows run in x if the programmed diagonal falls (dx dy < 0), in y if it rises.

    manual: the position depends on the axis version and on the diagonal, not on the order of the
    points (Fig. 11); both examples, for axis version 1, fit this and the longer side alike.
    """
    d = (p2[0] - p1[0], p2[1] - p1[1])
    if d[0] == 0 or d[1] == 0:
        raise Refusal(line, "the points of V1 must be corners of a diagonal")
    along = 0 if d[0] * d[1] < 0 else 1
    across = 1 - along
    if w is None:
        pitch, n_along = GRID_MM, steps(d[along], GRID_MM, line)
    else:
        if w < 2:
            raise Refusal(line, "W must be two or more")
        n_along = w - 1
        pitch = abs(d[along]) / n_along
    width = steps(d[across], pitch, line) * pitch
    holes = []
    for row in (0, 1):
        for k in range(n_along + 1):
            p = [0.0, 0.0]
            p[along] = p1[along] + math.copysign(k * pitch, d[along])
            p[across] = p1[across] + math.copysign(row * width, d[across])
            holes.append(tuple(p))
    return holes


def quadruple_row(p1, p2, w, line):
    """V3: holes on the outline of a rectangle, the first point is a corner."""
    d = (p2[0] - p1[0], p2[1] - p1[1])
    if w is None:
        pitch = GRID_MM
        n = (steps(d[0], pitch, line), steps(d[1], pitch, line))
    else:
        # manual: V3, "Examples": W9 on a side of 10 x 40 is said to give a grid of 2.5, which no
        # direction does. Only the square is settled.
        if w < 2 or abs(abs(d[0]) - abs(d[1])) > 1e-9 or d[0] == 0:
            raise Refusal(line, "V3 with W is settled by the manual for squares only")
        pitch = abs(d[0]) / (w - 1)
        n = (w - 1, w - 1)
    cells = [(i, j) for i in range(n[0] + 1) for j in range(n[1] + 1) if i in (0, n[0]) or j in (0, n[1])]
    return [(p1[0] + math.copysign(i * pitch, d[0]), p1[1] + math.copysign(j * pitch, d[1])) for i, j in cells]


def circle_row(center, p, w, line):
    """V4: W holes at equal angles, one of them at p."""
    if w is None or w < 1:
        raise Refusal(line, "V4 needs W, the number of holes")
    x, y = p[0] - center[0], p[1] - center[1]
    if x == 0 and y == 0:
        raise Refusal(line, "the hole of V4 lies in the center")
    turns = [2 * math.pi * k / w for k in range(w)]
    return [(center[0] + x * math.cos(t) - y * math.sin(t), center[1] + x * math.sin(t) + y * math.cos(t)) for t in turns]


def center_from_radius(start, end, r, clockwise, line):
    """Center of an arc of up to 180 degrees (r > 0) or of more (r < 0). manual: G2, "Routing angle"."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    chord = math.hypot(dx, dy)
    if chord == 0 or r == 0:
        raise Refusal(line, "an arc needs two points and a radius")
    square = r * r - chord * chord / 4
    if square < -1e-9:
        raise Refusal(line, "the radius is shorter than half the chord")
    height = math.sqrt(max(0.0, square))
    if clockwise:
        height = -height
    if r < 0:
        height = -height
    # Positive height: to the left of the direction from start to end.
    return ((start[0] + end[0]) / 2 - dy / chord * height, (start[1] + end[1]) / 2 + dx / chord * height)


def center_from_components(start, end, i, j, line):
    """manual: I: "I = X start - X center". The radii of both ends must agree within the limit."""
    center = (start[0] - i, start[1] - j)
    radius = math.hypot(i, j)
    if radius == 0 or start == end:
        raise Refusal(line, "an arc needs two points and a radius")
    if abs(math.hypot(end[0] - center[0], end[1] - center[1]) - radius) > MAX_ARC_MISS_MM:
        raise Refusal(line, "the end lies beside the circle")
    return center


def center_in_quadrant(start, end, i, j, clockwise, line):
    """Format 1000: I and J have no sign; the arc stays in one quadrant. manual: I, "Note"."""
    found = []
    for center in {(start[0] - si * i, start[1] - sj * j) for si in (1, -1) for sj in (1, -1)}:
        a = (start[0] - center[0], start[1] - center[1])
        b = (end[0] - center[0], end[1] - center[1])
        if abs(math.hypot(*a) - math.hypot(*b)) > 0.02:
            continue
        in_quadrant = a[0] * b[0] > -1e-6 and a[1] * b[1] > -1e-6
        turn = a[0] * b[1] - a[1] * b[0]
        if in_quadrant and turn != 0 and (turn < 0) == clockwise:
            found.append(center)
    if len(found) != 1:
        raise Refusal(line, "I and J do not lead to one center within a quadrant")
    return found[0]


def plunge_point(code, center, r, size, diameter):
    """manual: G45 .. G50, "Calculate plunge point"."""
    x, y = center
    if code in (45, 46):
        reach = r / 2 - diameter / 4
        return (x + (0.707 if code == 45 else -0.707) * reach, y + 1.707 * reach)
    if code in (47, 48):
        return (x - (r + diameter / 2), y + (diameter / 2 if code == 47 else -diameter / 2))
    return (x, y + size[1] / 4 - diameter / 4)
