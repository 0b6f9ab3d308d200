# SPDX-License-Identifier: Apache-2.0
"""Sharpness over the height of a camera, and contrast over the level of a lamp."""
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


class Light:
    """Contrast that grows with the lamp until it saturates; the stated sigma is that of a step."""

    NAMES = ["level"]
    CASES = {"10 levels": dict(noise=0.003)}

    @staticmethod
    def draw(rng, case):
        # Pixels of a bright mark have a normal spread of brightness, and clip one by one.
        mark, spread = rng.uniform(0.008, 0.012), rng.uniform(0.04, 0.08)
        levels = np.linspace(10, 100, 10)

        def clipped(level):
            from math import erfc
            return 0.2 * 0.5 * erfc((1 - mark * level) / (mark * level * spread) / np.sqrt(2))
        lines = []
        for level in levels:
            contrast = min(1.0, mark * level) * 0.8 + case["noise"] * rng.standard_normal()
            lines.append("sample %.17g %.17g %.17g" % (level, contrast, clipped(level)))
        # The brightest level that does not clip more than a thousandth of the picture.
        low, high = 1.0, 200.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if clipped(middle) <= 0.001 else (low, middle)
        return lines, [min(low, 100.0)]
