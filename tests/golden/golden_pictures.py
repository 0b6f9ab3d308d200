# SPDX-License-Identifier: Apache-2.0
"""Tiny pictures for the cases' setup.py."""
import math
import struct
import zlib


def png(width, height, rows, claims=None):
    """A grey 8-bit PNG; `claims` is the size that its header states instead."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(
            ">I", zlib.crc32(kind + data))

    raw = b"".join(b"\0" + bytes(row) for row in rows)
    header = struct.pack(">IIBBBBB", *(claims or (width, height)), 8, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw)) +
            chunk(b"IEND", b""))


def discs(width, height, places, radius, background=70, level=180):
    """Bright discs, centres in pixels, seen through a lens that blurs by one pixel."""
    def grey(x, y):
        inside = sum(0.5 * math.erfc((math.hypot(x - cx, y - cy) - radius) / math.sqrt(2))
                     for cx, cy in places)
        return round(background + (level - background) * inside)

    return png(width, height, [[grey(x, y) for x in range(width)] for y in range(height)])
