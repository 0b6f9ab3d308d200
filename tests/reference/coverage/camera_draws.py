# SPDX-License-Identifier: Apache-2.0
"""Looks of a camera at one mark, driven over the picture; written from docs/conventions.md alone."""
import numpy as np

WIDTH_PX, HEIGHT_PX = 640, 480
AXIS_PX = np.array([319.5, 239.5])
CORNERS_PX = np.array([[40.0, 40.0], [600.0, 60.0], [320.0, 440.0]])


class Lens:
    """Pixel to millimetres about the axis: pixels are straightened, then turned, then projected."""

    def __init__(self, scale, turn, k1=0.0, k2=0.0, p=(0.0, 0.0), tilt=(0.0, 0.0), focal=np.inf):
        self.scale, self.turn, self.k1, self.k2, self.p = scale, turn, k1, k2, p
        self.tilt, self.focal = np.array(tilt), focal

    def place_mm(self, u_px):
        d = np.atleast_2d(u_px) - AXIS_PX
        x, y = d[:, 0], d[:, 1]
        r2 = x * x + y * y
        bend = 1 + self.k1 * r2 + self.k2 * r2 * r2
        sx = x * bend + 2 * self.p[0] * x * y + self.p[1] * (r2 + 2 * x * x)
        sy = y * bend + self.p[0] * (r2 + 2 * y * y) + 2 * self.p[1] * x * y
        c, s = np.cos(self.turn), np.sin(self.turn)
        w = np.stack([c * sx + s * sy, s * sx - c * sy], axis=1)
        # A ray (w, focal) meets a panel whose normal is tilted against the axis by atan |q|; on the
        # panel a step along q is longer than across by sqrt(1 + |q|^2).
        q = self.tilt
        along = w @ q
        out = w + np.outer(along / (1 + np.sqrt(1 + q @ q)), q)
        return self.scale * out / (1 - along / self.focal)[:, None]

    def pixel(self, place_mm):
        u = AXIS_PX + np.array([place_mm[0], -place_mm[1]]) / self.scale
        for _ in range(50):
            miss = place_mm - self.place_mm(u)[0]
            c, s = np.cos(self.turn), np.sin(self.turn)
            step = np.array([c * miss[0] + s * miss[1], s * miss[0] - c * miss[1]]) / self.scale
            u = u + step
            if np.abs(step).max() < 1e-12:
                break
        return u


def draw(rng, case):
    """One calibration: lines for the program, and the truth of what it estimates."""
    n = case["per_side"]
    noise_px = case["noise_px"]
    k1 = case["k1_sigmas"] * case["k1_sigma"] * rng.uniform(*case.get("k1_part", (0.5, 1)))
    k1 *= rng.choice([-1, 1])
    tilted = case.get("focal_px") is not None
    lens = Lens(scale=0.01 * (1 + 0.01 * rng.standard_normal()),
                turn=0.02 * rng.standard_normal(),
                k1=k1,
                p=tuple(case.get("p_per_px", 0) * rng.standard_normal(2)),
                tilt=tuple(case.get("tilt_rad", 0) * rng.standard_normal(2)),
                focal=case["focal_px"] if tilted else np.inf)
    if "p_from_to_per_px" in case:
        lens.p = tuple(rng.choice([-1, 1], 2) * rng.uniform(*case["p_from_to_per_px"], 2))
    if "k2_from_to_per_px4" in case:
        lens.k2 = rng.choice([-1, 1]) * rng.uniform(*case["k2_from_to_per_px4"])
    mark = np.array([120.0, 80.0]) + rng.uniform(-0.1, 0.1, 2)
    lines = [f"picture {WIDTH_PX} {HEIGHT_PX}"]
    if tilted:
        lines.append(f"focal {lens.focal}")
    if "form" in case:
        lines.append(f"form {case['form']}")
    margin = 40
    for v in np.linspace(margin, HEIGHT_PX - margin, n):
        for u in np.linspace(margin, WIDTH_PX - margin, n):
            shown = lens.place_mm(np.array([u, v]))[0] + rng.uniform(-0.01, 0.01, 2)
            axis = np.round(np.array([120.0, 80.0]) - shown, 4)
            seen = lens.pixel(mark - axis) + noise_px * rng.standard_normal(2)
            var = (case["stated_px"]) ** 2
            lines.append("look %.17g %.17g %.17g %.17g %.17g 0 %.17g" % (*axis, *seen, var, var))
    truth = [lens.scale, lens.turn]
    for corner in CORNERS_PX:
        lines.append("at %.17g %.17g" % tuple(corner))
        truth += list(lens.place_mm(corner)[0])
    return lines, truth


# k1_sigma: of k1 as these looks show it, from a least-squares fit of the same looks.
CASES = {
    "flat, 25 looks": dict(per_side=5, noise_px=0.02, stated_px=0.02, k1_sigma=4.5e-10, k1_sigmas=0),
    "k1 of 1..2 sigmas, 25 looks": dict(per_side=5, noise_px=0.02, stated_px=0.02, k1_sigma=4.5e-10, k1_sigmas=2),
    "k1 of 2..4 sigmas, 25 looks": dict(per_side=5, noise_px=0.02, stated_px=0.02, k1_sigma=4.5e-10, k1_sigmas=4),
    "k1 of 1..2 sigmas, 9 looks": dict(per_side=3, noise_px=0.02, stated_px=0.02, k1_sigma=6e-10, k1_sigmas=2),
    "noise unstated, 9 looks": dict(per_side=3, noise_px=0.05, stated_px=0.01, k1_sigma=15e-10, k1_sigmas=2),
    "noise unstated, 25 looks": dict(per_side=5, noise_px=0.05, stated_px=0.01, k1_sigma=11e-10, k1_sigmas=2),
    "tilt barely seen, 25 looks": dict(per_side=5, noise_px=0.02, stated_px=0.02, k1_sigma=4.5e-10, k1_sigmas=4,
                                       focal_px=5000, tilt_rad=6e-4),
    "lens off centre, 25 looks": dict(per_side=5, noise_px=0.02, stated_px=0.02, k1_sigma=4.5e-10, k1_sigmas=4,
                                      focal_px=5000, tilt_rad=6e-4, p_per_px=4e-8),
    # A telecentric lens: what is softer than k1 counts where an F test shows it, so these show it.
    "telecentric, far off centre, 25 looks": dict(per_side=5, noise_px=0.02, stated_px=0.02, k1_sigma=4.5e-10,
                                                  k1_sigmas=4, p_from_to_per_px=(3e-7, 1e-6)),
    "telecentric, k2 of 1..3 px, 25 looks": dict(per_side=5, noise_px=0.02, stated_px=0.02, k1_sigma=4.5e-10,
                                                 k1_sigmas=4, k2_from_to_per_px4=(1e-13, 3e-13)),
}
NAMES = ["scale", "rotation"] + [f"K {i} {c}" for i in (1, 2, 3) for c in "xy"]
