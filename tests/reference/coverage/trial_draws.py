# SPDX-License-Identifier: Apache-2.0
"""Sharpness over the height of a camera."""
import numpy as np


class Focus:
    """Edges whose blur grows as a lens' does; 11 heights over the range, then twice 7 around the sharpest."""

    NAMES = ["height"]
    CASES = {
        "noise 1 %": dict(noise=0.01, depth_mm=0.3),
        "noise 3 %": dict(noise=0.03, depth_mm=0.3),
        "deep, noise 1 %": dict(noise=0.01, depth_mm=0.8),
    }

    @staticmethod
    def draw(rng, case):
        best = rng.uniform(-0.4, 0.4)

        def sharpness(z):
            blur = np.sqrt(1 + ((z - best) / case["depth_mm"]) ** 2)
            return 0.02 / blur * (1 + case["noise"] * rng.standard_normal())
        low, high = -1.5, 1.5
        samples = [(z, sharpness(z)) for z in np.linspace(low, high, 11)]
        step = (high - low) / 10
        for _ in range(2):
            step /= 3
            middle = max(samples, key=lambda s: s[1])[0]
            samples += [(z, sharpness(z)) for z in middle + step * np.arange(-3, 4) if low <= z <= high]
        return ["sample %.17g %.17g" % s for s in samples], [best]
