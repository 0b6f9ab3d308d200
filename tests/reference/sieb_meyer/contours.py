# SPDX-License-Identifier: Apache-2.0
"""D: the corner between two moves, replaced by an arc that touches both. manual: "D: Round Edge"."""

import dataclasses
import math

from .reader import Refusal


def round_corners(operations):
    """Operations without `round_mm`: the moves at a rounded corner are shortened, an arc joins them."""
    result = []
    for index, operation in enumerate(operations):
        if result and result[-1].round_mm:
            before = result.pop()
            follows = operation.kind in ("line", "arc") and operation.start == before.end
            if not follows or (before.kind == "arc" and operation.kind == "arc"):
                raise Refusal(before.line, "D needs a move behind it, one of both straight")
            first, corner, operation = round_corner(before, operation)
            result += [first, corner]
        result.append(operation)
    if result and result[-1].round_mm:
        raise Refusal(result[-1].line, "D needs a move behind it")
    return result


def round_corner(a, b):
    """Shortened a, the arc, shortened b. The center is r beside both moves, on the same side."""
    r = a.round_mm
    found = []
    for side in (1, -1):  # 1: center to the left of the direction of movement
        for center in crossings(offset(a, side * r), offset(b, side * r)):
            p, q = foot(a, center), foot(b, center)
            if inside(a, p) and inside(b, q):
                found.append((math.dist(p, a.end) + math.dist(q, a.end), side, center, p, q))
    if not found:
        raise Refusal(a.line, "no arc with this D touches both moves")
    _, side, center, p, q = min(found)
    first = dataclasses.replace(a, end=p, round_mm=None)
    corner = dataclasses.replace(first, kind="arc", start=p, end=q, center=center, clockwise=side < 0)
    return first, corner, dataclasses.replace(b, start=q)


def offset(move, distance):
    """The curve at this distance to the left: ("line", point, direction) or ("circle", center, radius)."""
    if move.kind == "line":
        length = math.dist(move.start, move.end)
        u = ((move.end[0] - move.start[0]) / length, (move.end[1] - move.start[1]) / length)
        return ("line", (move.start[0] - u[1] * distance, move.start[1] + u[0] * distance), u)
    radius = math.dist(move.start, move.center)
    return ("circle", move.center, radius + distance if move.clockwise else radius - distance)


def crossings(one, two):
    if one[0] == "circle":
        one, two = two, one
    _, p, u = one
    if two[0] == "line":
        _, q, v = two
        cross = u[0] * v[1] - u[1] * v[0]
        if abs(cross) < 1e-12:
            return []
        t = ((q[0] - p[0]) * v[1] - (q[1] - p[1]) * v[0]) / cross
        return [(p[0] + t * u[0], p[1] + t * u[1])]
    _, center, radius = two
    along = (center[0] - p[0]) * u[0] + (center[1] - p[1]) * u[1]
    nearest = (p[0] + along * u[0], p[1] + along * u[1])
    square = radius * radius - math.dist(center, nearest) ** 2
    if radius < 0 or square < 0:
        return []
    half = math.sqrt(square)
    return [(nearest[0] + t * u[0], nearest[1] + t * u[1]) for t in (-half, half)]


def foot(move, p):
    """The point of the whole line or circle nearest to p."""
    if move.kind == "line":
        _, start, u = offset(move, 0)
        along = (p[0] - start[0]) * u[0] + (p[1] - start[1]) * u[1]
        return (start[0] + along * u[0], start[1] + along * u[1])
    radius = math.dist(move.start, move.center)
    reach = math.dist(p, move.center)
    if reach == 0:
        return (math.inf, math.inf)
    return tuple(c + (x - c) * radius / reach for c, x in zip(move.center, p))


def inside(move, p):
    """Whether a point of the line or circle lies between the ends of the move."""
    if move.kind == "line":
        length = math.dist(move.start, move.end)
        return math.dist(move.start, p) < length and math.dist(move.end, p) < length
    return sweep(move.center, move.start, p, move.clockwise) < sweep(move.center, move.start, move.end, move.clockwise)


def sweep(center, start, end, clockwise):
    """Angle from start to end in the direction of the arc, above 0, at most 2 pi."""
    a = math.atan2(start[1] - center[1], start[0] - center[0])
    b = math.atan2(end[1] - center[1], end[0] - center[0])
    angle = (a - b if clockwise else b - a) % (2 * math.pi)
    return angle if angle > 0 else 2 * math.pi
