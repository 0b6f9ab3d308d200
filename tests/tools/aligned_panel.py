# SPDX-License-Identifier: Apache-2.0
"""Panels of the tests of `panelcal align`: where everything on them lies, by the equations of
docs/formulation.md and nothing of the program."""

import json
import math
import random

PADS = [(5, 5), (75, 5), (75, 55), (5, 55)]
PTH = [(10 + 7.5 * i, 8 + 11 * k) for i in range(9) for k in range(5)]
NPTH = [(3, 3), (77, 3), (77, 57), (3, 57), (40, 30)]
SIGMA_LIMIT_UM = 5  # at 10 um per pixel
# The virtual machine's stage, table and drill do not err, so that sigma is that of the fit.
STAGE_UM = TABLE_UM = WANDER_UM = 0

MACHINE = """[machine]
name = "virtual"
[vision]
rotate = 4
search_radius_mm = 0.9
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 1.0
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [50.0, 3.0]
camera_offset_sigma_um = 1e-6
[gates]
rotation_mrad = 10
offset_mm = 2
[uncertainty]
stage_repeatability_um = {stage}
table_residual_um = {table}
drill_wander_um = {wander}
[sim]
seed = {seed}
panel_offset_mm = [{x}, {y}]
panel_rotation_mrad = {rotation}
stretch_ppm = [{stretch_x}, {stretch_y}]
picture_px = [256, 256]
blur_px = 1.0
noise = 3
"""

CAMERA = {
    "kind": "camera", "version": 1, "date": "2026-11-01T00:00:00Z", "provenance": "made up for a test",
    "units": {"length": "mm", "angle": "rad", "picture": "px"}, "picture_px": [256, 256],
    "parameters": {"scale_mm_per_px": 0.01, "rotation_rad": 0.004, "axis_px": [130.7, 123.4], "k1_per_px2": 4e-8},
    "covariance": [[1e-22 if i == k else 0 for k in range(5)] for i in range(5)],
}


class Panel:
    """A panel that lies somewhere, turned and stretched."""

    def __init__(self, seed):
        draw = random.Random(1000 + seed)
        self.seed = seed + 1
        self.x, self.y = draw.uniform(-0.4, 0.4), draw.uniform(-0.4, 0.4)
        self.rotation = draw.uniform(-3e-3, 3e-3)
        self.stretch = draw.uniform(-4e-4, 4e-4), draw.uniform(-4e-4, 4e-4)

    def moved(self, x_mm):
        self.x += x_mm
        return self

    def actual(self, nominal):
        """R(rotation) diag(scale) nominal + offset."""
        x, y = nominal[0] * (1 + self.stretch[0]), nominal[1] * (1 + self.stretch[1])
        cos, sin = math.cos(self.rotation), math.sin(self.rotation)
        return cos * x - sin * y + self.x, sin * x + cos * y + self.y


def machine_text(panel):
    return MACHINE.format(stage=STAGE_UM, table=TABLE_UM, wander=WANDER_UM, seed=panel.seed, x=panel.x,
                          y=panel.y, rotation=panel.rotation * 1e3, stretch_x=panel.stretch[0] * 1e6,
                          stretch_y=panel.stretch[1] * 1e6)


def drill_text(holes):
    """As KiCad writes it: metric, decimal points, no targets."""
    return ("M48\nFMAT,2\nMETRIC\nT1C0.800F100\n%\nG90\nG05\nT1\n"
            + "".join(f"X{x:.3f}Y{y:.3f}\n" for x, y in holes) + "T0\nM30\n")


def distance_in_sigmas(hole, panel):
    """Of the error of what the machine is told, in sigmas of what is drilled: x and y apart."""
    true = panel.actual(hole["nominal"])
    return max(abs(a - t) / s for a, t, s in zip(hole["actual"], true, hole["sigma"]))


def prepare(folder, panel):
    (folder / "machine.toml").write_text(machine_text(panel))
    (folder / "pth.drl").write_text(drill_text(PTH))
    (folder / "npth.drl").write_text(drill_text(NPTH))
    (folder / "pads.exc").write_text("M48\nMETRIC,TZ\nVER,1\n%\nG34,1\n" + "".join(
        f"G36X{x:.3f}Y{y:.3f}\n" for x, y in PADS) + "M30\n")
    (folder / "camera.cal.json").write_text(json.dumps(CAMERA))
