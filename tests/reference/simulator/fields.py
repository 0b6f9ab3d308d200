# SPDX-License-Identifier: Apache-2.0
"""Random fields: stationary noise with a correlation length, streaks, blotches, rim profiles."""
import zlib

import numpy as np


def stream(seed, name):
    """Generator of one effect: the same seed and name give the same numbers, whatever else is on."""
    return np.random.default_rng(np.random.SeedSequence([int(seed) & 0xFFFFFFFF, zlib.crc32(name.encode())]))


def _spline(n, step, rng):
    """(first knots, 4 weights each, number of knots) of a cubic B-spline of random phase, n samples."""
    s = np.arange(n) * step + rng.random()
    k = s.astype(int)
    f = s - k
    weights = ((1 - f) ** 3 / 6, (4 - 6 * f ** 2 + 3 * f ** 3) / 6,
               (1 + 3 * f + 3 * f ** 2 - 3 * f ** 3) / 6, f ** 3 / 6)
    return k, [w.astype(np.float32)[:, None] for w in weights], int(k[-1]) + 4


def noise(rng, ny, nx, step_px, corr_px):
    """Gaussian noise of unit variance on an ny x nx grid of pitch step_px, smooth over corr_px.

    corr_px is a number or (along x, along y). White knots, interpolated by cubic B-splines; the
    correlation falls to 1/2 at about 1.4 corr_px.
    """
    cx, cy = corr_px if isinstance(corr_px, (tuple, list)) else (corr_px, corr_px)
    kx, wx, mx = _spline(nx, step_px / max(cx, step_px), rng)
    ky, wy, my = _spline(ny, step_px / max(cy, step_px), rng)
    # the sum of squared weights is 0.479 on average over the phase, along each axis
    white = rng.standard_normal((mx, my), dtype=np.float32) * np.float32(1 / 0.479)
    columns = np.ascontiguousarray(sum(w * white[kx + i] for i, w in enumerate(wx)).T)
    return sum(w * columns[ky + i] for i, w in enumerate(wy))


def turned(field, u, v, angle_rad, step_px):
    """A square field looked up along axes turned by angle_rad; wraps at its borders."""
    c, s = np.cos(angle_rad) / step_px, np.sin(angle_rad) / step_px
    n = len(field)
    i = np.rint(u * np.float32(c) + v * np.float32(s)).astype(np.int32) % n
    j = np.rint(v * np.float32(c) - u * np.float32(s)).astype(np.int32) % n
    return field[j, i]


def streaks(rng, u, v, angle_deg, length_px, width_px, step_px):
    """Noise of unit variance that is long along angle_deg and narrow across it."""
    n = max(u.shape) * 3 // 2
    field = noise(rng, n, n, step_px, (length_px, width_px))
    return turned(field, u, v, np.deg2rad(angle_deg), step_px)


def rim_profile(rng, corr_px, radius_px, n=720):
    """Periodic noise of unit variance over 0 to 2 pi, Gaussian correlation of corr_px of arc."""
    k = np.fft.rfftfreq(n, 1 / n)
    corr_rad = corr_px / max(radius_px, 1)
    spectrum = np.exp(-0.25 * (k * corr_rad) ** 2)
    spectrum[0] = 0
    power = 2 * np.sum(spectrum[1:] ** 2)
    x = np.fft.irfft(spectrum * (rng.standard_normal(len(k)) + 1j * rng.standard_normal(len(k))), n) * n
    return x / np.sqrt(2 * power)


def lobe(n, azimuth_rad, width_rad):
    """Smooth bump of height 1 at azimuth_rad over n angles: a one-sided defect of a rim."""
    t = np.arange(n) * (2 * np.pi / n) - azimuth_rad
    return np.exp((np.cos(t) - 1) / (0.25 * width_rad ** 2))


def blotches(field, part, soft=0.35):
    """0 to 1: about `part` of a unit-variance field is covered, with soft borders."""
    # logistic approximation of the normal quantile, good to 2 % of area
    part = min(max(part, 1e-4), 1 - 1e-4)
    level = -np.log(part / (1 - part)) / 1.702
    return np.clip((level - field) * np.float32(-1 / soft) + np.float32(0.5), 0, 1)
