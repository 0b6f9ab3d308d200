# SPDX-License-Identifier: Apache-2.0
"""A coupon that is drilled from one side and looked at from several."""
import numpy as np

NAMES = ["offset x", "offset y", "backlash x", "backlash y"]
SPREADS = ["drill wander", "repeatability"]


def draw(rng, case):
    offset = np.array([52.3, -11.7]) + rng.uniform(-1, 1, 2)
    backlash = np.array(case["backlash_mm"]) * rng.uniform(0.5, 1.5, 2)
    wander, repeat = case["wander_mm"], case["repeat_mm"]
    detector = case["detector_mm"]
    lines = []
    side = case["per_side"]
    for j in range(side):
        for i in range(side):
            told = np.array([100.0 + 3 * i, 60.0 + 3 * j])
            # A stage that moves up stops short by half its backlash, moving down it stops beyond.
            hole = told - 0.5 * backlash + wander * rng.standard_normal(2)
            lines.append("hole %.17g %.17g 1 1" % tuple(told))
            for approach in case["approaches"]:
                spindle = np.round(told - offset + rng.uniform(-0.02, 0.02, 2), 4)
                stands = spindle - 0.5 * backlash * np.array(approach) + repeat * rng.standard_normal(2)
                sigma = detector * rng.uniform(0.7, 1.3)
                seen = hole - (stands + offset) + sigma * rng.standard_normal(2)
                lines.append("view %.17g %.17g %d %d %.17g %.17g %.17g 0 %.17g" % (
                    *spindle, *approach, *seen, sigma ** 2, sigma ** 2))
    return lines, list(offset) + list(backlash), [wander, repeat]


FOUR = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
CASES = {
    "9 holes, 4 looks": dict(per_side=3, approaches=FOUR, wander_mm=0.0025, repeat_mm=0.001, detector_mm=0.0004,
                             backlash_mm=(0.004, 0.003)),
    "25 holes, 4 looks": dict(per_side=5, approaches=FOUR, wander_mm=0.0025, repeat_mm=0.001, detector_mm=0.0004,
                              backlash_mm=(0.004, 0.003)),
    "9 holes, 4 looks, wander small": dict(per_side=3, approaches=FOUR, wander_mm=0.0008, repeat_mm=0.001,
                                           detector_mm=0.0004, backlash_mm=(0.004, 0.003)),
}
