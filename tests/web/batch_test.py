#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of a batch, in a browser: its figures show what its facts say.

    batch_test.py PANELCAL REPOSITORY
"""
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

DEMO = ROOT / "datasets/demo"
KEPT = ("facts", "status", "state", "started", "name")
# Sentences of the program.
ENGLISH = ("message", "example")


class BatchPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        for name in ("panel.exc", "machine.toml", "camera.cal.json"):
            shutil.copy(DEMO / name, cls.folder)
        cls.panelcal("synth", "panel.exc", "-m", "machine.toml", "-o", "images", "--seed", "3")
        (cls.folder / "jobs.csv").write_text("id,program,machine,images,truth,lamp\n"
                                             "good,panel.exc,machine.toml,images,images/truth.json,1\n"
                                             "gone,none.exc,machine.toml,images,images/truth.json,2\n")
        cls.panelcal("batch", "jobs.csv", "-o", "out", expect=2)
        cls.panelcal("batch", "report", "out", "-o", "page.html")
        cls.page = cls.folder / "page.html"
        cls.facts = checked(in_page(cls.page), ROOT)
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.temporary.cleanup()

    @classmethod
    def panelcal(cls, *words, expect=0):
        done = subprocess.run([PANELCAL, "-q", *words], cwd=cls.folder, capture_output=True, text=True, timeout=120)
        assert done.returncode == expect, done.stderr

    def test_is_whole_at_every_width_and_in_both_themes(self):
        for width in browser.WIDTHS:
            for dark in (False, True):
                self.browser.open(self.page, width, dark)
                self.assertEqual(self.browser.cut_off(), [])

    def test_shows_what_its_facts_say(self):
        self.browser.open(self.page)
        tiles = self.browser.texts("#summary .tile dd")
        self.assertTrue(tiles[0].startswith("1 / 2"), tiles)
        self.assertTrue(tiles[1].startswith("100.00"), tiles)
        bars = sum(n > 0 for n in self.facts["error"]["counts"][:-1])
        bars += sum(n > 0 for n in self.facts["error"]["normalized_counts"])
        self.assertEqual(self.browser.count("#error rect"), bars)
        self.assertEqual(self.browser.count("#fits rect"), sum(n > 0 for n in self.facts["fits"]["exceedance_counts"]))
        self.assertEqual(self.browser.count("#worst tbody tr"), len(self.facts["worst"]))
        self.assertEqual(self.browser.count("#worst .thumbnail image"), len(self.facts["worst"]))
        self.assertEqual(self.browser.texts("#refusals tbody td")[2], "file-unreadable")
        self.assertEqual(self.browser.texts("#conditions tbody td")[0], "lamp = 1")

    def test_speaks_german(self):
        self.browser.open(self.page)
        self.browser.run("document.querySelector('.language').click()")
        self.assertIn("Marken gegen die Wahrheit", self.browser.texts("h2"))
        self.assertEqual(self.browser.not_marked_as_english(self.facts, ENGLISH), [])
        self.assertEqual(self.browser.cut_off(), [])

    def test_lives_without_truth_and_without_jobs(self):
        empty = dict(self.facts, error=None, refusals=[], not_drilled=[], conditions=[], drift=[], worst=[], sessions=[],
                     fits={"n": 0, "degrees_of_freedom": 0, "chi_square": 0, "exceedance_counts": [0] * 20})
        self.browser.open(browser.with_facts(self.page, empty, self.folder / "empty.html"))
        self.assertEqual(self.browser.cut_off(), [])
        self.assertEqual(self.browser.count("#error, #fits, #worst, #refusals"), 0)

    def test_every_text_stays_a_text(self):
        page = browser.with_facts(self.page, browser.hostile(self.facts, KEPT), self.folder / "hostile.html")
        self.browser.open(page)
        self.assertIsNone(self.browser.run("return window.injected ?? null"))
        self.assertIn(browser.HOSTILE_SHOWN, " ".join(self.browser.texts("main")))


if __name__ == "__main__":
    browser.skip_without_browser()
    unittest.main(argv=sys.argv[:1])
