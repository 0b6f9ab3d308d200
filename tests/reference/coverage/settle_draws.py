# SPDX-License-Identifier: Apache-2.0
"""A stage that swings or creeps to rest, seen a while after each of many moves."""
import numpy as np

NAMES = ["wait"]
LIMIT_MM = 0.001


def seen(rng, case, motion, delays):
    """A view after each delay; the clock is late by up to a millisecond and knows it."""
    lines = []
    for t in delays:
        t += rng.exponential(2e-4)
        at = motion(t) + case["noise_mm"] * rng.standard_normal(2)
        var = case.get("stated_mm", case["noise_mm"]) ** 2
        lines.append("view %.17g %.17g %.17g %.17g 0 %.17g" % (t, *at, var, var))
    return lines


def draw(rng, case, ask):
    size, tau = case["size_mm"], case["tau_s"] * rng.uniform(0.9, 1.1)
    hz = case["hz"] * rng.uniform(0.9, 1.1)
    turn, phase = rng.uniform(0, 2 * np.pi, 2)
    rest = rng.uniform(-0.05, 0.05, 2)
    along = np.array([np.cos(turn), np.sin(turn)])

    def motion(t):
        swing = np.cos(2 * np.pi * hz * t + phase) if hz > 0 else 1
        return rest + size * np.exp(-t / tau) * swing * along
    lines = [f"limit {LIMIT_MM}"]
    longest = case.get("longest_s", 1.0)
    for i_round in range(3):
        delays = ask("delays", lines + [f"rounds 12 {longest} {i_round}"])["value"]
        lines += seen(rng, case, motion, delays)
    return lines, [tau * np.log(size / LIMIT_MM)]


CASES = {
    "swing 30 um, 0.05 s, 20 Hz": dict(size_mm=0.03, tau_s=0.05, hz=20, noise_mm=0.0003),
    "swing 30 um, 0.05 s, 20 Hz, noise 1 um": dict(size_mm=0.03, tau_s=0.05, hz=20, noise_mm=0.001),
    "swing 10 um, 0.1 s, 8 Hz": dict(size_mm=0.01, tau_s=0.1, hz=8, noise_mm=0.0003),
    "swing 50 um, 0.03 s, 45 Hz": dict(size_mm=0.05, tau_s=0.03, hz=45, noise_mm=0.0003),
    "creep 20 um, 0.1 s": dict(size_mm=0.02, tau_s=0.1, hz=0, noise_mm=0.0003),
    # Scatter that is not as stated is rightly refused at times.
    "swing, noise a quarter more than stated": dict(size_mm=0.03, tau_s=0.05, hz=20, noise_mm=0.0004, stated_mm=0.00032,
                                                    refusable=0.15),
}
