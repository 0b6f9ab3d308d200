# SPDX-License-Identifier: Apache-2.0
"""Working grid: where each sample of the scene lies in the picture and on the board.

Frames: picture, px, (0, 0) = centre of the top-left pixel, x right, y down; board, px of nominal
magnification, origin at the target's centre, same directions.
"""
import numpy as np


def smooth_size(least):
    """Smallest n >= least, n divisible by 4, whose prime factors are 2, 3 and 5: a fast FFT length."""
    n = (least + 3) // 4 * 4
    while True:
        m = n
        for p in (2, 3, 5):
            while m % p == 0:
                m //= p
        if m == 1:
            return n
        n += 4


class View:
    """Camera above a plane board: telecentric or entocentric, either of them tilted.

    Along the tilt's azimuth q, across it s, both on the board from the optical axis, distance d:
      entocentric  q' = q cos(t) d / (d + q sin(t)),  s' = s d / (d + q sin(t))
      telecentric  the limit of d to infinity: q' = q cos(t), s' = s
    Source: central projection of a plane that is turned by t about the axis point.
    """

    def __init__(self, view, centre_px):
        self.d = float(view["distance_px"]) if view["kind"] == "entocentric" else None
        self.tilt = np.deg2rad(view["tilt_deg"])
        azimuth = np.deg2rad(view["tilt_azimuth_deg"])
        self.e = np.array([np.cos(azimuth), np.sin(azimuth)])
        self.axis = np.array(view["axis_px"], float)
        self.origin = np.zeros(2)
        self.origin = np.array(self.board(np.float64(centre_px[0]), np.float64(centre_px[1])))

    def board(self, x, y):
        """Board coordinates (px, from the target's centre) of picture coordinates."""
        ex, ey = self.e
        dx, dy = x - self.axis[0], y - self.axis[1]
        p, s = dx * ex + dy * ey, dy * ex - dx * ey
        c, n = np.cos(self.tilt), np.sin(self.tilt)
        if self.d is None:
            q = p / c
        else:
            q = p * self.d / (self.d * c - p * n)
            s = s * (self.d + q * n) / self.d
        return q * ex - s * ey - self.origin[0], q * ey + s * ex - self.origin[1]

    def lower_face(self, depth_px):
        """(shift [u, v] px, scale) with which the lower face, depth_px down, appears at the target.

        A point at depth t seems shifted by t tan(tilt) against the tilt's azimuth and, in an
        entocentric view, by -U t / (d + t) towards the axis, U from the axis.
        """
        shift = -depth_px * np.tan(self.tilt) * self.e
        scale = 1.0
        if self.d is not None:
            scale = self.d / (self.d + depth_px)
            shift = shift - self.origin * (1 - scale)
        return shift, scale


class Grid:
    """Samples of pitch 1/ss px over the picture and a margin for the point spread function."""

    def __init__(self, width_px, height_px, ss, view, margin_px=10):
        self.width, self.height, self.ss = width_px, height_px, ss
        self.nx, self.ny = smooth_size(width_px + 2 * margin_px), smooth_size(height_px + 2 * margin_px)
        self.left, self.top = (self.nx - width_px) // 2, (self.ny - height_px) // 2
        self.view = view
        self.h = 1.0 / ss
        self.x = ((np.arange(self.nx * ss) + 0.5) / ss - 0.5 - self.left).astype(np.float32)
        self.y = ((np.arange(self.ny * ss) + 0.5) / ss - 0.5 - self.top).astype(np.float32)
        self.u, self.v = self._board(self.x, self.y)

    def _board(self, x, y):
        if self.view.d is None:  # affine: three points have it, and rows and columns add up
            u0, v0 = self.view.board(np.float64(0), np.float64(0))
            ux, vx = self.view.board(np.float64(1), np.float64(0))
            uy, vy = self.view.board(np.float64(0), np.float64(1))
            column, row = y.astype(np.float64)[:, None], x.astype(np.float64)[None, :]
            return tuple(((b - o) * column).astype(np.float32) + ((a - o) * row + o).astype(np.float32)
                         for o, a, b in ((u0, ux, uy), (v0, vx, vy)))
        u, v = self.view.board(x[None, :].astype(np.float64), y[:, None].astype(np.float64))
        shape = (len(y), len(x))
        return (np.ascontiguousarray(np.broadcast_to(u, shape), np.float32),
                np.ascontiguousarray(np.broadcast_to(v, shape), np.float32))

    @property
    def shape(self):
        return self.u.shape

    def coarse(self):
        """(u, v) of half the working resolution, for textures; spread() brings them back."""
        x = self.x.reshape(-1, 2).mean(1)
        y = self.y.reshape(-1, 2).mean(1)
        return self._board(x, y)

    @staticmethod
    def spread(field):
        """A coarse field on the working grid; each value fills its 2 x 2 samples, so nothing shifts."""
        out = np.empty((2 * field.shape[0], 2 * field.shape[1]), field.dtype)
        out[::2, ::2] = field
        out[::2, 1::2] = field
        out[1::2] = out[::2]
        return out

    def window(self, u, v, radius_px):
        """Slices that hold all samples within radius_px of board place (u, v); possibly empty."""
        x, y = self._picture(u, v)
        r = radius_px * 1.05 + 1

        def span(t, axis):
            a = np.searchsorted(axis, t - r)
            return slice(int(a), int(np.searchsorted(axis, t + r)))
        return span(y, self.y), span(x, self.x)

    def _picture(self, u, v):
        """Picture coordinates of a board place, by a few fixed-point steps (the map is near 1)."""
        x, y = float(u), float(v)
        for _ in range(8):
            bu, bv = self.view.board(np.float64(x), np.float64(y))
            x, y = x + (u - bu), y + (v - bv)
        return x, y

    def local(self, window, u=0.0, v=0.0, angle_rad=0.0):
        """Coordinates about (u, v), turned by angle_rad, of the samples of a window."""
        du, dv = self.u[window] - np.float32(u), self.v[window] - np.float32(v)
        if angle_rad == 0:
            return du, dv
        c, s = np.float32(np.cos(angle_rad)), np.float32(np.sin(angle_rad))
        return du * c + dv * s, dv * c - du * s
