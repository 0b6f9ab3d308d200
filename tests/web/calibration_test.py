#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The pages of `panelcal calibrate`, in a browser.

    calibration_test.py PANELCAL REPOSITORY
"""
import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import browser

ROOT = Path(sys.argv.pop()).resolve()
PANELCAL = str(Path(sys.argv.pop()).resolve())
sys.dont_write_bytecode = True
from facts import checked, in_page  # noqa: E402

FIXTURES = ROOT / "tests/golden/fixtures"
KEPT = ("facts", "kind", "verdict", "time", "unit")
MACHINE = """[machine]
name = "drill 1"
[vision]
search_radius_mm = 0.4
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.3
[camera]
calibration = "camera.cal.json"
focus_range_mm = [-1, 1]
[spindle]
camera_offset_mm = [45.0, -3.0]
[sim]
seed = 5
background = 0.3
target_level = 0.8
noise = 2
lamp = 50
focus_z_mm = 0.137
focus_depth_mm = 0.2
[sim.camera]
scale_mm_per_px = 0.01
rotation_rad = 0.01
"""
PLATE = "[plate]\ncolumns = 6\nrows = 5\npitch_mm = 40\ncertified = true\n[[pose]]\norigin_mm = [100, 100]\n"


def looks():
    """A table that is 100 ppm too long in x and 50 um out of square, seen at every dot."""
    for row in range(5):
        for column in range(6):
            x_mm, y_mm = 40 * column, 40 * row
            # So that there are residuals.
            noise_mm = 1e-3 * ((7 * row + 5 * column) % 5 - 2)
            yield {"pose": 0, "axis": [100 + x_mm, 100 + y_mm], "dot": [column, row],
                   "seen": [-1e-4 * x_mm + noise_mm, -2.5e-4 * x_mm - noise_mm], "cov": [1e-6, 0, 1e-6]}


class Calibration(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        shutil.copy(FIXTURES / "camera-200-px/camera.cal.json", cls.folder)
        (cls.folder / "machine.toml").write_text(MACHINE)
        (cls.folder / "plate.toml").write_text(PLATE)
        (cls.folder / "looks.jsonl").write_text("".join(json.dumps(look) + "\n" for look in looks()))
        mark = ("--machine-driver", "sim", "--at", "300,100")
        cls.calibrate("camera", *mark)
        cls.calibrate("focus", *mark)
        cls.calibrate("table", "--plate", "plate.toml", "--measurements", "looks.jsonl")
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.temporary.cleanup()

    @classmethod
    def calibrate(cls, what, *words):
        done = subprocess.run([PANELCAL, "-q", "calibrate", what, "-m", "machine.toml", "--report", f"{what}.html",
                               *words], cwd=cls.folder, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, (what, done.stderr)

    def page(self, what):
        return self.folder / f"{what}.html"

    def test_shows_values_with_sigma(self):
        facts = checked(in_page(self.page("table")), ROOT)
        self.browser.open(self.page("table"))
        rows = self.browser.texts("#values tbody tr")
        self.assertEqual(len(rows), len(facts["parameters"]))
        # 1 um of noise in each look over 200 mm: 100 ppm are some hundred sigmas of a few ppm.
        value = next(one["value"] for one in facts["parameters"] if one["name"] == "scale_x")
        self.assertAlmostEqual(value, 1e-4, delta=2e-5)

    def test_draws_an_arrow_for_each_residual_and_the_map(self):
        for what, n_residuals in (("camera", 25), ("table", 30)):
            self.browser.open(self.page(what))
            self.assertEqual(self.browser.count("#residuals svg.arrows circle.place"), n_residuals)
            said = self.browser.point_at("#residuals svg.arrows circle.place", 3)
            self.assertTrue(any("\u00b5m" in line for line in said), said)
        self.assertEqual(self.browser.count("#map svg.arrows circle.place"), 15 * 15)
        self.assertEqual(self.browser.count("#map canvas"), 1)

    def test_shows_the_curve_of_a_focus(self):
        self.browser.open(self.page("focus"))
        self.assertEqual(self.browser.count("#curve svg circle.filled"), 25)

    def test_says_what_became_of_it(self):
        facts = checked(in_page(self.page("camera")), ROOT)
        for verdict, said in (("measured", "Measured, not installed"), ("refused", "Refused: it is bent")):
            facts.update({"verdict": verdict, "objection": "it is bent" if verdict == "refused" else ""})
            self.browser.open(browser.with_facts(self.page("camera"), facts, self.folder / "other.html"))
            self.assertEqual(self.browser.texts(".verdict p"), [said])
        self.assertEqual(self.browser.count(".verdict.hold"), 1)

    def test_fits_every_screen(self):
        for what in ("camera", "focus", "table"):
            for width in browser.WIDTHS:
                self.browser.open(self.page(what), width, dark=width == 400)
                self.assertEqual(self.browser.cut_off(), [], (what, width))

    def test_shows_texts_as_texts(self):
        for what in ("camera", "table"):
            facts = in_page(self.page(what))
            scale = facts["parameters"][0]["name"]
            facts = browser.hostile(facts, KEPT)
            facts["parameters"][0]["name"] = scale
            self.browser.open(browser.with_facts(self.page(what), facts, self.folder / "hostile.html"))
            self.assertIsNone(self.browser.run("return window.injected ?? null"))
            self.assertEqual(self.browser.count("main img, main script"), 0)


if __name__ == "__main__":
    browser.skip_without_browser()
    unittest.main()
