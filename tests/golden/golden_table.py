# SPDX-License-Identifier: Apache-2.0
"""Makes table calibrations for cases, from docs/formats/calibration.md and without panelcal."""
import json

GEOMETRY = ("scale_x", "scale_y", "squareness", "linearity_x_2", "linearity_x_3", "linearity_y_2",
            "linearity_y_3", "straightness_x_2", "straightness_x_3", "straightness_y_2",
            "straightness_y_3")


def bowed(x_mm, y_mm):
    """100 ppm of scale in x, and 40 um of bow over 200 mm of the x axis; exact in 1/1024 mm."""
    return 1e-4 * x_mm, 0.04 * (x_mm / 200) ** 2


def table(error_mm, low_mm=(0, 0), high_mm=(400, 300), steps=(8, 6), sigma_mm=0.0005):
    """Of an error that is a polynomial of the third degree at most: a bicubic B-spline of it."""
    step = [(high - low) / n for low, high, n in zip(low_mm, high_mm, steps)]
    knots = []
    for j in range(-1, steps[1] + 2):
        for i in range(-1, steps[0] + 2):
            at = (low_mm[0] + i * step[0], low_mm[1] + j * step[1])
            here = error_mm(*at)
            around = [error_mm(at[0] + dx * step[0], at[1] + dy * step[1])
                      for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))]
            knots.append([e - (sum(other[k] for other in around) - 4 * e) / 6
                          for k, e in enumerate(here)])
    return json.dumps({
        "kind": "table", "version": 1, "date": "2026-11-01T00:00:00Z", "provenance": "made up",
        "units": {"length": "mm", "angle": "rad"},
        "grid": {"low_mm": low_mm, "high_mm": high_mm, "steps": steps},
        "coefficients_mm": knots,
        "geometry": {name: 0 for name in GEOMETRY},
        "geometry_covariance": [[1e-12 if i == j else 0 for j in range(11)] for i in range(11)],
        "undetermined": [], "sigma_mm": sigma_mm, "rms_mm": 0.001, "held_out_rms_mm": None})


def write(path="table.cal.json", error_mm=bowed, **words):
    with open(path, "w", encoding="ascii") as file:
        file.write(table(error_mm, **words) + "\n")
