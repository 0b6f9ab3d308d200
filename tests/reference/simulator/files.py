# SPDX-License-Identifier: Apache-2.0
"""Picture files: PNG of 8 and 16 bits by the standard library, JPEG by Pillow or OpenCV."""
import struct
import zlib

import numpy as np


def png_bytes(picture):
    """A PNG of [height, width] or [height, width, 3], uint8 or uint16. Source: PNG, W3C 2003."""
    picture = np.ascontiguousarray(picture)
    h, w = picture.shape[:2]
    deep = picture.dtype == np.uint16
    raw = picture.astype(">u2") if deep else picture.astype(np.uint8)
    rows = raw.reshape(h, -1).view(np.uint8).reshape(h, -1)
    lines = np.concatenate([np.zeros((h, 1), np.uint8), rows], 1).tobytes()

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", w, h, 16 if deep else 8, 2 if picture.ndim == 3 else 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines, 1))
            + chunk(b"IEND", b""))


def write(path, picture, quality=95):
    """Writes a picture; the name's end chooses PNG or JPEG."""
    path = str(path)
    if not path.lower().endswith((".jpg", ".jpeg")):
        with open(path, "wb") as f:
            f.write(png_bytes(picture))
        return
    if picture.dtype != np.uint8:
        raise SystemExit(f'render.py: JPEG has 8 bits: "{path}"; write a PNG')
    try:
        from PIL import Image
        Image.fromarray(picture).save(path, quality=quality)
    except ImportError:
        import cv2
        cv2.imwrite(path, picture[..., ::-1] if picture.ndim == 3 else picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
