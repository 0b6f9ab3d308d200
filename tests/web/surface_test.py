#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The pages of `panelcal surface`, in a browser.

    surface_test.py PANELCAL REPOSITORY
"""
import json
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

DATA = ROOT / "tests/tools/surface"
KEPT = ("facts", "command", "source", "model", "type", "base64")
ZONES = """
[[zone]]
name = "left"
rectangle_mm = [-5, -5, 40, 65]
[[zone]]
name = "right"
rectangle_mm = [40, -5, 85, 65]
[[void]]
name = "clamp"
center_mm = [10, 30]
diameter_mm = 8
"""


def pixels(browser_, index):
    """How many colours a canvas has, and a sum that changes with what it shows."""
    return browser_.run("""
      const canvas = document.querySelectorAll("canvas")[arguments[0]];
      const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
      const seen = new Set();
      let sum = 0;
      for (let i = 0; i < data.length; i += 4) {
        seen.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
        sum = (31 * sum + data[i]) % 1000003;
      }
      return [seen.size, sum];""", index)


class Surface(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        cls.run_("fit", DATA / "wild.jsonl", "-o", "wild.json", "--report", "fit.html")
        cls.run_("fit", DATA / "plane.jsonl", "-o", "plane.json", "--model", "plane")
        cls.run_("diff", "plane.json", "wild.json", "--report", "diff.html")
        cls.run_("plan", "wild.json", "--afresh", "--tolerance-um", "6", "--report", "plan.html")
        (cls.folder / "zones.toml").write_text(ZONES)
        cls.run_("fit", DATA / "wild.jsonl", "--zones", "zones.toml", "-o", "zoned.json", "--report", "zones.html")
        cls.pages = {name: checked(in_page(cls.folder / f"{name}.html"), ROOT) for name in ("fit", "diff", "plan", "zones")}
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.temporary.cleanup()

    @classmethod
    def run_(cls, *words):
        done = subprocess.run([PANELCAL, "-q", "surface", *map(str, words)], cwd=cls.folder, capture_output=True, text=True,
                              timeout=300)
        assert done.returncode == 0, (words, done.stderr)

    def test_are_whole_at_every_width_and_in_both_themes(self):
        for name in self.pages:
            for width in browser.WIDTHS:
                for dark in (False, True):
                    with self.subTest(name=name, width=width, dark=dark):
                        self.browser.open(self.folder / f"{name}.html", width, dark)
                        self.assertEqual(self.browser.cut_off(), [])
                        n_canvases = self.browser.count("canvas")
                        self.assertEqual(n_canvases, {"fit": 4, "zones": 8}.get(name, 1))
                        for i in range(n_canvases):
                            self.assertGreater(pixels(self.browser, i)[0], 20 if i % 4 == 3 else 100, i)

    def test_names_every_probe(self):
        self.browser.open(self.folder / "fit.html")
        zone = self.pages["fit"]["zones"][0]
        self.browser.run("document.querySelector('details').open = true")
        self.browser.settle()
        self.assertEqual(self.browser.count("details tbody tr"), len(zone["kept"]["x_mm"]))
        cells = self.browser.texts("td")
        self.assertTrue(any(text.endswith("wild.jsonl:17") for text in cells), cells)
        self.assertTrue(any(text.endswith("wild.jsonl:25") for text in cells), cells)

    def test_says_the_height_under_the_pointer(self):
        self.browser.open(self.folder / "fit.html")
        said = self.browser.run("""
          const canvas = document.querySelector("canvas"), box = canvas.getBoundingClientRect();
          canvas.dispatchEvent(new PointerEvent("pointermove", {clientX: box.left + box.width / 2, clientY: box.top + box.height / 2}));
          return [...canvas.parentElement.querySelectorAll(".hint div")].map((one) => one.textContent);""")
        x, y = (float(one) for one in said[0].strip("() m\u00a0").split(", "))
        done = subprocess.run([PANELCAL, "surface", "query", "wild.json", f"{x},{y}", "--json", "-"], cwd=self.folder,
                              capture_output=True, text=True, check=True)
        places = json.loads(done.stdout)["places"]
        height, sigma = (float(one.split("\u00a0")[0]) for one in said[1].split(" \u00b1 "))
        self.assertAlmostEqual(height, places["height_mm"][0], delta=2e-4)
        self.assertAlmostEqual(sigma, places["sigma_um"][0], delta=0.05 * places["sigma_um"][0])

    def test_turns_in_space(self):
        self.browser.open(self.folder / "fit.html")
        before = pixels(self.browser, 2)
        self.browser.run("document.querySelectorAll('canvas')[2].dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft'}))")
        self.browser.until(lambda: pixels(self.browser, 2) != before)

    def test_states_the_change(self):
        self.browser.open(self.folder / "diff.html")
        self.assertTrue(self.pages["diff"]["changed"])
        self.assertIn("The panel changed", self.browser.texts(".verdict p")[0])

    def test_lists_the_places_to_probe(self):
        self.browser.open(self.folder / "plan.html")
        self.assertEqual(self.browser.count("ol li"), len(self.pages["plan"]["probes_mm"]))

    def test_every_text_stays_a_text(self):
        for name, facts in self.pages.items():
            page = browser.with_facts(self.folder / f"{name}.html", browser.hostile(facts, KEPT), self.folder / "hostile.html")
            self.browser.open(page)
            self.assertFalse(self.browser.run("return window.injected === 1"))
            self.assertEqual(self.browser.count("main img, main script"), 0)


if __name__ == "__main__":
    browser.skip_without_browser()
    unittest.main()
