# SPDX-License-Identifier: Apache-2.0
"""A board of dots on a table whose axes err smoothly, laid down in several poses."""
import numpy as np

PLACES = np.array([[0.15, 0.2], [0.5, 0.5], [0.8, 0.35], [0.3, 0.85]])
GEOMETRY = ["scale x", "scale y", "squareness", "linearity x 2", "linearity x 3", "linearity y 2", "linearity y 3",
            "straightness x 2", "straightness x 3", "straightness y 2", "straightness y 3"]
NAMES = GEOMETRY + [f"E {i} {c}" for i in range(4) for c in "xy"]


def legendre(n, t):
    """Of mean square 1 over -1..1."""
    return np.polynomial.legendre.Legendre.basis(n)(t) * np.sqrt(2 * n + 1)


class Table:
    """Error of an axis: slow waves of random direction and phase, and a linear part."""

    def __init__(self, rng, low, high, warp_mm, linear):
        self.low, self.high = low, high
        span = (high - low).max()
        length = span * rng.uniform(0.8, 2.5, (2, 6))
        turn = rng.uniform(0, 2 * np.pi, (2, 6))
        self.k = 2 * np.pi / length * np.array([np.cos(turn), np.sin(turn)])
        self.phase = rng.uniform(0, 2 * np.pi, (2, 6))
        self.size = warp_mm * rng.standard_normal((2, 6)) / np.sqrt(3)
        self.linear = linear * rng.standard_normal((2, 2))
        self.conventions = np.zeros((2, 3))

    def raw(self, c):
        c = np.atleast_2d(c)
        out = (c - 0.5 * (self.low + self.high)) @ self.linear.T
        for a in range(2):
            arg = c @ self.k[:, a, :] + self.phase[a]
            out[:, a] += np.sin(arg) @ self.size[a]
        return out

    def moments(self, error):
        """Share of each polynomial of x and y in an error over the rectangle, by Gauss' rule."""
        t, w = np.polynomial.legendre.leggauss(24)
        x, y = np.meshgrid(t, t)
        weight = np.outer(w, w).ravel() / 4
        at = self.low + 0.5 * (np.stack([x.ravel(), y.ravel()], 1) + 1) * (self.high - self.low)
        e = error(at)
        return lambda axis, i, j: np.sum(weight * e[:, axis] * legendre(i, x.ravel()) * legendre(j, y.ravel()))

    def geometry(self, error):
        m = self.moments(error)
        reach = (self.high - self.low) / (2 * np.sqrt(3))
        rows = [m(0, 1, 0) / reach[0], m(1, 0, 1) / reach[1], m(0, 0, 1) / reach[1] + m(1, 1, 0) / reach[0]]
        end = lambda d: np.sqrt(2 * d + 1)
        rows += [end(2) * m(0, 2, 0), end(3) * m(0, 3, 0), end(2) * m(1, 0, 2), end(3) * m(1, 0, 3)]
        rows += [end(2) * m(1, 2, 0), end(3) * m(1, 3, 0), end(2) * m(0, 0, 2), end(3) * m(0, 0, 3)]
        return np.array(rows)

    def without_conventions(self, scale_is_open):
        """The error with no shift, the x axis along x, and no common scale where that is open."""
        m = self.moments(self.raw)
        reach = (self.high - self.low) / (2 * np.sqrt(3))
        shift = np.array([m(0, 0, 0), m(1, 0, 0)])
        turn = m(1, 1, 0) / reach[0]
        scale = 0.0
        if scale_is_open:
            # The part of (x, y) by means over the rectangle.
            scale = (m(0, 1, 0) * reach[0] + m(1, 0, 1) * reach[1]) / (reach @ reach)
        middle = 0.5 * (self.low + self.high)

        def error(c):
            d = np.atleast_2d(c) - middle
            return self.raw(c) - shift - turn * np.stack([-d[:, 1], d[:, 0]], 1) - scale * d
        return error


def draw(rng, case):
    n, pitch = case["n"], case["pitch"]
    noise = case["noise_mm"]
    certified = case.get("certified", False)
    nominal = np.array([[i * pitch, j * pitch] for j in range(n) for i in range(n)]) - 0.5 * (n - 1) * pitch
    dots = nominal + (0 if certified else case.get("plate_mm", 0.003)) * rng.standard_normal(nominal.shape)
    centre = np.array([250.0, 200.0])
    poses = []
    for turn_deg, shift in case["poses"]:
        poses.append((np.deg2rad(turn_deg) + 2e-3 * rng.standard_normal(),
                      centre + np.array(shift) * pitch + rng.uniform(-0.3, 0.3, 2)))
    stops, looks = [], []
    for k, (angle, shift) in enumerate(poses):
        c, s = np.cos(angle), np.sin(angle)
        nominal_at = nominal @ np.array([[c, -s], [s, c]]).T + shift
        for j in range(len(dots)):
            stop = np.round(nominal_at[j] + case.get("jitter_mm", 0.05) * rng.uniform(-1, 1, 2), 4)
            stops.append(stop)
            looks.append((k, j, dots[j] @ np.array([[c, -s], [s, c]]).T + shift))
    stops = np.array(stops)
    table = Table(rng, stops.min(0), stops.max(0), case["warp_mm"], case["linear"])
    error = table.without_conventions(not certified)
    stands = stops + table.raw(stops)
    lines = ["dot %.17g %.17g %d" % (*d, certified) for d in nominal]
    var = case["stated_mm"] ** 2
    for (k, j, at), stop, stand in zip(looks, stops, stands):
        seen = at - stand + noise * rng.standard_normal(2)
        lines.append("look %d %.17g %.17g %d %.17g %.17g %.17g 0 %.17g" % (k, *stop, j, *seen, var, var))
    places = table.low + PLACES * (table.high - table.low)
    lines += ["at %.17g %.17g" % tuple(p) for p in places]
    truth = table.geometry(error)
    return lines, list(truth) + list(error(places).ravel())


THREE = [(0, (0, 0)), (90, (0, 0)), (0, (1, 0))]
FOUR = THREE + [(180, (0, 1))]
BASE = dict(noise_mm=0.0005, stated_mm=0.0005, warp_mm=0.006, linear=5e-5)
CASES = {
    "certified plate, 9 x 9, one pose": dict(BASE, n=9, pitch=20, poses=[(0, (0, 0))], certified=True),
    "9 x 9, three poses": dict(BASE, n=9, pitch=20, poses=THREE),
    "15 x 15, three poses": dict(BASE, n=15, pitch=12, poses=THREE, is_slow=True),
    "15 x 15, four poses": dict(BASE, n=15, pitch=12, poses=FOUR, is_slow=True),
}
