# SPDX-License-Identifier: Apache-2.0
"""Outlines as signed distances (px, negative inside), and the area that they cover of a sample."""
import numpy as np

# Codes of AprilTag family 36h11, ids 0 to 9 (AprilTag 3 library, Olson et al.), and where bit
# 35 - i of a code lies: (x, y) in cells from the black frame's corner cell.
TAG36H11 = (
    0xd7e00984b, 0xdda664ca7, 0xdc4a1c821, 0xe17b470e9, 0xef91d01b1,
    0xf429cdd73, 0x05da29225, 0x1106cba43, 0x223bed79d, 0x21f51213c)
TAG_BITS = (
    (1, 1), (2, 1), (3, 1), (4, 1), (5, 1), (2, 2), (3, 2), (4, 2), (3, 3),
    (6, 1), (6, 2), (6, 3), (6, 4), (6, 5), (5, 2), (5, 3), (5, 4), (4, 3),
    (6, 6), (5, 6), (4, 6), (3, 6), (2, 6), (5, 5), (4, 5), (3, 5), (4, 4),
    (1, 6), (1, 5), (1, 4), (1, 3), (1, 2), (2, 5), (2, 4), (2, 3), (3, 4))


def coverage(distance, ramp_px):
    """Covered part of each sample, 0 to 1, of an outline at `distance`.

    Area of a square sample of side ramp_px cut by a straight edge, exact along x and y and within
    0.03 of a sample along diagonals; ramp_px = 1/4 px. A wider ramp stands for a soft edge.
    """
    return np.clip(np.float32(0.5) - distance * np.float32(1 / ramp_px), 0, 1)


def disc(u, v, radius):
    return np.sqrt(u * u + v * v) - np.float32(radius)


def box(u, v, half_u, half_v, corner=0.0):
    """Rectangle; distances are true inside and beside it, and about its corners if corner > 0."""
    a, b = np.abs(u) - np.float32(half_u - corner), np.abs(v) - np.float32(half_v - corner)
    if corner <= 0:
        return np.maximum(a, b)
    outside = np.hypot(np.maximum(a, 0), np.maximum(b, 0))
    return outside + np.minimum(np.maximum(a, b), 0) - np.float32(corner)


def cross(u, v, half, half_width):
    return np.minimum(box(u, v, half, half_width), box(u, v, half_width, half))


def triangle(u, v, side):
    """Equilateral, one corner up, centroid at the origin."""
    r = side / (2 * np.sqrt(3.0))
    c, s = np.float32(np.sqrt(0.75)), np.float32(0.5)
    return np.maximum(np.maximum(v, c * u - s * v), -c * u - s * v) - np.float32(r)


def capsule(u, v, a, b, radius):
    """Line from a to b with round ends; radius (ra, rb) may differ: a tapered one, a teardrop."""
    ra, rb = radius if isinstance(radius, tuple) else (radius, radius)
    d = np.subtract(b, a)
    length2 = float(d @ d) or 1e-9
    du, dv = u - np.float32(a[0]), v - np.float32(a[1])
    t = np.clip((du * np.float32(d[0]) + dv * np.float32(d[1])) * np.float32(1 / length2), 0, 1)
    return np.hypot(du - t * np.float32(d[0]), dv - t * np.float32(d[1])) - (np.float32(ra) + t * np.float32(rb - ra))


def tag_cells(code):
    """10 x 10 cells of a tag of 36 bits, 1 = white: white rim, black frame, 6 x 6 bits."""
    cells = np.ones((10, 10), np.float32)
    cells[1:9, 1:9] = 0
    for i, (x, y) in enumerate(TAG_BITS):
        cells[y + 1, x + 1] = (code >> (35 - i)) & 1
    return cells


def tag_coverage(u, v, side, cells, ramp_px):
    """(white part of each sample, distance to the outer rim) of a tag; side: of its black frame."""
    cell = side / 8.0

    def steps(t):
        """Index of the cell before the nearest cell border, and the part beyond that border."""
        s = t * np.float32(1 / cell) + np.float32(5)
        border = np.rint(s)
        part = np.clip((s - border) * np.float32(cell / ramp_px) + np.float32(0.5), 0, 1)
        k = border.astype(np.int32)
        return np.clip(k - 1, 0, 9), np.clip(k, 0, 9), part
    x0, x1, fx = steps(u)
    y0, y1, fy = steps(v)
    white = ((cells[y0, x0] * (1 - fx) + cells[y0, x1] * fx) * (1 - fy)
             + (cells[y1, x0] * (1 - fx) + cells[y1, x1] * fx) * fy)
    return white, box(u, v, 5 * cell, 5 * cell)


def displace(distance, u, v, delta_px, reach_px):
    """Moves an outline outwards by delta_px(angle), tabulated over 0 to 2 pi, near the outline only."""
    near = np.abs(distance) < np.float32(reach_px)
    angle = np.arctan2(v[near], u[near]) % (2 * np.pi)
    n = len(delta_px)
    table = np.append(delta_px, delta_px[0])
    out = distance.copy()
    out[near] -= np.interp(angle, np.arange(n + 1) * (2 * np.pi / n), table).astype(np.float32)
    return out
