# SPDX-License-Identifier: Apache-2.0
"""What a camera or driver does to a picture: demosaicing, denoising, sharpening, gamma, JPEG.

Pictures are float32, 0 to 1.
"""
import numpy as np

from .sensor import BAYER

LUMA = np.array([0.299, 0.587, 0.114], np.float32)  # ITU-R BT.601


def _neighbours(a):
    """Copies of a moved by -2 to 2, mirrored about border pixels so that mosaics keep their phase."""
    p = np.pad(a, 2, mode="reflect")
    h, w = a.shape
    return lambda dy, dx: p[2 + dy:2 + dy + h, 2 + dx:2 + dx + w]


def demosaic(raw, pattern, method):
    """[3, height, width] from a mosaic: "bilinear", or "edge": Hamilton and Adams 1997.

    Hamilton-Adams takes green along the direction of the smaller gradient, corrected by the second
    difference of the pixel's own colour; red and blue are then bilinear differences to green.
    """
    h, w = raw.shape
    colour = np.empty((h, w), np.int8)
    for j in (0, 1):
        for i in (0, 1):
            colour[j::2, i::2] = BAYER[pattern][j][i]
    s = _neighbours(raw)
    if method == "edge":
        second_h, second_v = 2 * raw - s(0, -2) - s(0, 2), 2 * raw - s(-2, 0) - s(2, 0)
        dh = np.abs(s(0, -1) - s(0, 1)) + np.abs(second_h)
        dv = np.abs(s(-1, 0) - s(1, 0)) + np.abs(second_v)
        gh, gv = (s(0, -1) + s(0, 1)) / 2 + second_h / 4, (s(-1, 0) + s(1, 0)) / 2 + second_v / 4
        green = np.where(dh < dv, gh, np.where(dv < dh, gv, (gh + gv) / 2))
    else:
        green = (s(0, -1) + s(0, 1) + s(-1, 0) + s(1, 0)) / 4
    green = np.where(colour == 1, raw, green).astype(np.float32)
    out = [None, green, None]
    base = green if method == "edge" else np.zeros_like(green)
    for c in (0, 2):
        mask = (colour == c).astype(np.float32)
        d, m = _neighbours((raw - base) * mask), _neighbours(mask)
        total, weight = 0, 0
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                k = 0.5 ** (abs(dx) + abs(dy))
                total, weight = total + k * d(dy, dx), weight + k * m(dy, dx)
        out[c] = (base + total / weight).astype(np.float32)
    return np.stack(out)


def bilateral(a, radius, sigma_px, sigma_level):
    """Mean of neighbours, weighted by distance and by likeness. Source: Tomasi and Manduchi 1998."""
    p = np.pad(a, radius, mode="reflect")
    h, w = a.shape
    total, weight = np.zeros_like(a), np.zeros_like(a)
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            q = p[radius + dy:radius + dy + h, radius + dx:radius + dx + w]
            d = (q - a) * np.float32(1 / sigma_level)
            k = np.exp(np.float32(-0.5 * (dx * dx + dy * dy) / sigma_px ** 2) - np.float32(0.5) * d * d)
            total += k * q
            weight += k
    return total / weight


def _box3(a):
    p = np.pad(a, 1, mode="reflect")
    r = p[:-2] + p[1:-1] + p[2:]
    return (r[:, :-2] + r[:, 1:-1] + r[:, 2:]) * np.float32(1 / 9)


def nonlocal_means(a, radius, sigma_level):
    """Mean of neighbours, weighted by the likeness of 3 x 3 patches. Source: Buades et al. 2005."""
    p = np.pad(a, radius, mode="reflect")
    h, w = a.shape
    total, weight = np.zeros_like(a), np.zeros_like(a)
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            q = p[radius + dy:radius + dy + h, radius + dx:radius + dx + w]
            d = np.maximum(_box3((q - a) ** 2) - np.float32(2 * sigma_level ** 2 * 0.5), 0)
            k = np.exp(d * np.float32(-1 / sigma_level ** 2))
            total += k * q
            weight += k
    return total / weight


def gaussian(a, sigma_px):
    """Separable Gaussian, mirrored borders."""
    r = int(np.ceil(3 * sigma_px))
    k = np.exp(-0.5 * (np.arange(-r, r + 1) / sigma_px) ** 2)
    k = (k / k.sum()).astype(np.float32)
    p = np.pad(a, r, mode="reflect")
    h, w = a.shape
    rows = sum(k[i] * p[i:i + h] for i in range(2 * r + 1))
    return sum(k[i] * rows[:, i:i + w] for i in range(2 * r + 1))


def sharpen(a, amount, sigma_px):
    """Unsharp mask: a + amount (a - blurred a), clipped as cameras do."""
    return np.clip(a + np.float32(amount) * (a - gaussian(a, sigma_px)), 0, 1)


# ITU-T T.81, annex K.1: the tables that the Independent JPEG Group's encoder scales by quality
_LUMA_STEPS = np.array([
    16, 11, 10, 16, 24, 40, 51, 61, 12, 12, 14, 19, 26, 58, 60, 55, 14, 13, 16, 24, 40, 57, 69, 56,
    14, 17, 22, 29, 51, 87, 80, 62, 18, 22, 37, 56, 68, 109, 103, 77, 24, 35, 55, 64, 81, 104, 113, 92,
    49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99], float).reshape(8, 8)
_CHROMA_STEPS = np.full((8, 8), 99.0)
_CHROMA_STEPS[:4, :4] = [[17, 18, 24, 47], [18, 21, 26, 66], [24, 26, 56, 99], [47, 66, 99, 99]]
_K = np.arange(8)
_DCT = np.cos((2 * _K[None, :] + 1) * _K[:, None] * np.pi / 16) * np.where(_K[:, None] == 0, np.sqrt(1 / 8), 0.5)


def _jpeg_plane(plane, steps):
    """A plane (0 to 255) after rounding of its 8 x 8 DCT; entropy coding loses nothing."""
    h, w = plane.shape
    p = np.pad(plane - 128, ((0, -h % 8), (0, -w % 8)), mode="edge")
    b = p.reshape(p.shape[0] // 8, 8, p.shape[1] // 8, 8).transpose(0, 2, 1, 3)
    c = _DCT @ b @ _DCT.T
    c = np.rint(c / steps) * steps
    b = _DCT.T @ c @ _DCT
    return np.clip(np.rint(b.transpose(0, 2, 1, 3).reshape(p.shape)[:h, :w] + 128), 0, 255)


def jpeg(planes, quality):
    """Planes (1 or 3, 0 to 1, rounded to 8 bits) as a JPEG decoder gives them back; 4:2:0 colours."""
    scale = 5000 / quality if quality < 50 else 200 - 2 * quality

    def steps(table):
        return np.clip(np.floor((table * scale + 50) / 100), 1, 255)
    a = np.rint(np.clip(planes, 0, 1) * 255)
    if len(a) == 1:
        return (_jpeg_plane(a[0], steps(_LUMA_STEPS))[None] / 255).astype(np.float32)
    r, g, b = a
    y = LUMA[0] * r + LUMA[1] * g + LUMA[2] * b
    chroma = []
    for c in ((b - y) / 1.772, (r - y) / 1.402):
        h, w = c.shape
        c = np.pad(c, ((0, h % 2), (0, w % 2)), mode="edge")
        half = (c[::2, ::2] + c[1::2, ::2] + c[::2, 1::2] + c[1::2, 1::2]) / 4 + 128
        half = _jpeg_plane(half, steps(_CHROMA_STEPS)) - 128
        chroma.append(np.repeat(np.repeat(half, 2, 0), 2, 1)[:h, :w])
    y = _jpeg_plane(y, steps(_LUMA_STEPS))
    cb, cr = chroma
    rgb = np.stack([y + 1.402 * cr, y - 0.344136 * cb - 0.714136 * cr, y + 1.772 * cb])
    return (np.rint(np.clip(rgb, 0, 255)) / 255).astype(np.float32)
