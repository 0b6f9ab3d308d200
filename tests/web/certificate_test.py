#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of a machine's quality certificate, in a browser.

    certificate_test.py PANELCAL REPOSITORY
"""
import copy
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import browser

ROOT = Path(sys.argv.pop()).resolve()
PANELCAL = str(Path(sys.argv.pop()).resolve())
from facts import checked, in_page  # noqa: E402

KEPT = ("facts", "time", "unit", "command", "hash", "sha256", "head", "type", "axis")


def panelcal(*words):
    done = subprocess.run([PANELCAL, "-q", *map(str, words)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, (words, done.returncode, done.stderr)


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        for name in ("night/machine.toml", "camera-320-px/camera.cal.json"):
            shutil.copy(ROOT / "tests/golden/fixtures" / name, ".")
        for day in (20, 21, 22):
            panelcal("nightly", "-m", "machine.toml", "--by", "Ann", "--clock", f"2026-11-{day}T02:00:00Z")
        panelcal("history", "certificate", "-l", "drill1.ledger", "-m", "machine.toml", "--report", "page.html")
        cls.facts = checked(in_page("page.html"), ROOT)
        # What these nights have not: a plate, and a table's figures.
        cls.whole = {**cls.facts, "table_entry": 9, "stage": [*cls.facts["stage"], *(
            {"axis": axis, "quantity": quantity, "value": 3e-5, "sigma": 2e-6, "unit": unit, "nights": 1, "origin": "entry 9"}
            for axis, quantity, unit in (("x", "scale", "1"), ("xy", "squareness", "rad"), ("y", "straightness_3", "mm")))],
            "plate": {"file": "plate.toml", "sha256": 64 * "a", "entry": 9, "name": "B 17", "columns": 9, "rows": 9, "pitch_mm": 25,
                      "certified": True, "certificate": "123 of 2026", "expanded_uncertainty_um": 0.6, "coverage_factor": 2}}
        checked(cls.whole, ROOT)
        browser.with_facts("page.html", cls.whole, "whole.html")
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        os.chdir("/")
        cls.folder.cleanup()

    def test_says_what_was_found(self):
        self.browser.open("page.html")
        whole = copy.deepcopy(self.whole)
        (spindle,) = self.facts["spindles"]
        tiles = self.browser.texts(".tile")
        self.assertIn(f"{max(spindle['budget']['expanded_um']):.2f}\u00a0\u00b5m", tiles[0])
        self.assertIn("Not in it: error of the table that is in no map.", tiles[0])
        self.assertIn(f"{spindle['gauge']['percent_of_tolerance']:.1f}\u00a0%", tiles[1])
        self.assertIn("to nothing", tiles[2])
        rows = self.browser.texts("#spindle-1 tbody tr")
        self.assertIn(f"R&R{spindle['gauge']['both_um']['sigma']:.3f}\u00a0\u00b5m", "".join(rows))
        self.assertEqual(self.browser.count("#spindle-1 svg.chart:not(.sample) circle.filled"), 2 * 3)
        self.assertEqual(self.browser.texts("#not-measured tbody td:first-child"), [one["what"] for one in self.facts["not_measured"]])
        self.assertEqual(self.browser.count(".verdict.forced, .verdict.hold"), 1)
        whole["spindles"][0]["gauge"]["percent_of_tolerance"] = 5
        self.browser.open(browser.with_facts("page.html", whole, "good.html"))
        self.assertEqual(self.browser.count(".verdict.forced, .verdict.hold"), 0)
        self.assertIn("good", self.browser.texts(".tile")[1])
        self.browser.open("whole.html")
        self.assertIn("certified plate", self.browser.texts(".tile")[2])
        self.assertIn("U = 0.600\u00a0\u00b5m, k = 2.00", "".join(self.browser.texts("#plate dd")))
        rows = self.browser.texts("#stage tbody tr")
        self.assertIn("xysquareness+30.00\u00a0\u00b5rad2.00\u00a0\u00b5rad1entry 9", rows)
        self.assertIn("xscale+30.00\u00a0ppm2.00\u00a0ppm1entry 9", rows)

    def test_what_is_not_known_is_a_dash(self):
        bare = {**self.facts, "tolerance": None, "repeatability": [], "stage": [],
                "spindles": [{**self.facts["spindles"][0], "gauge": None, "budget": None, "nights": []}]}
        self.browser.open(browser.with_facts("page.html", checked(bare, ROOT), "bare.html"))
        self.assertNotIn("NaN", self.browser.run("return document.body.innerHTML.split('<script')[0]"))
        self.assertEqual(self.browser.count("#repeatability, #stage, #plate"), 0)

    def test_nothing_is_cut_off(self):
        for width in browser.WIDTHS:
            for dark in (False, True):
                self.browser.open("whole.html", width, dark)
                with self.subTest(width=width, dark=dark):
                    self.assertEqual(self.browser.cut_off(), [])
                self.browser.run("document.querySelector('button.language').click()")
                self.assertEqual(self.browser.cut_off(), [], "in German")

    def test_hostile_names_inject_nothing(self):
        self.browser.open(browser.with_facts("page.html", browser.hostile(self.whole, KEPT), "hostile.html"))
        self.assertIsNone(self.browser.run("return window.injected ?? null"))
        self.assertEqual(self.browser.count("img"), 0)
        self.assertIn(browser.HOSTILE_SHOWN, "".join(self.browser.texts("main")))

    def test_speaks_german(self):
        self.browser.open("whole.html")
        self.browser.run("document.querySelector('button.language').click()")
        self.assertEqual(self.browser.run("return document.title"), "Qualitätszeugnis von drill 1")
        self.assertIn("xyRechtwinkligkeit+30,00\u00a0\u00b5rad2,00\u00a0\u00b5rad1entry 9", self.browser.texts("#stage tbody tr"))
        self.assertEqual(self.browser.not_marked_as_english(self.whole, ("what", "why", "origin")), [])


if __name__ == "__main__":
    browser.skip_without_browser()
    unittest.main()
