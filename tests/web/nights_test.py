#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The pages of nights and of ledgers, in a browser.

    nights_test.py PANELCAL REPOSITORY
"""
import copy
import math
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
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tests" / "golden"))
import golden_ledger  # noqa: E402
from facts import checked, in_page  # noqa: E402

FIXTURES = ROOT / "tests" / "golden" / "fixtures"
# Words of the schema, and times.
KEPT = ("facts", "time", "now", "until", "started", "finished", "drill_until", "state", "verdict", "outcome", "answer",
        "unit", "command", "hash", "sha256", "result_sha256", "night")


def panelcal(*words, codes=(0,)):
    done = subprocess.run([PANELCAL, "-q", *map(str, words)], capture_output=True, text=True, timeout=120)
    assert done.returncode in codes, (words, done.returncode, done.stderr)


def many_nights(record):
    """Sixty nights of one, of which the 46th was refused far off, the 51st was a fresh start and the last alarms."""
    facts = copy.deepcopy(record)
    step = facts["steps"][0]
    last = step["series"][-1]
    middle = last["value"]
    step["series"] = [{
        **last, "time": f"2026-{9 + i // 30:02}-{1 + i % 30:02}T02:00:00Z", "asked_by": "timer", "ledger_id": i + 1,
        "value": [middle[0] + 1e-3 * math.sin(i), middle[1] + 1e-3 * math.cos(i)], "refused": i == 45,
        "fresh_start": i == 50, "alarm": i == 59, "by_hand": i == 50} for i in range(60)]
    step["series"][45]["value"] = [middle[0] + 0.214, middle[1]]
    return facts


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        for name in ("night/machine.toml", "camera-320-px/camera.cal.json"):
            shutil.copy(FIXTURES / name, ".")
        for day in (20, 21, 22):
            panelcal("nightly", "-m", "machine.toml", "--by", "Ann", "--clock", f"2026-11-{day}T23:00:00Z")
        cls.page = "reports/2026-11-22.html"
        cls.facts = in_page(cls.page)
        shutil.copytree(FIXTURES / "drill-1-job", "job")
        golden_ledger.two_nights("job/two.ledger").close()
        ledger = ("-l", "job/two.ledger")
        panelcal("history", "list", *ledger, "--report", "list.html")
        panelcal("history", "show", "2", *ledger, "--report", "show.html")
        panelcal("history", "plot", *ledger, "--machine", "drill 1", "--kind", "spindle-camera", "--subject",
                 "spindle 1 station 1", "--parameter", "offset_x", "--report", "plot.html")
        golden_ledger.two_nights("job/back.ledger").close()
        key = ("-l", "job/back.ledger", "--machine", "drill 1", "--kind", "spindle-camera", "--subject", "spindle 1 station 1")
        panelcal("history", "rollback", *key, "--reason", "holes are off")
        panelcal("history", "plot", *key, "--parameter", "offset_x", "--report", "back.html")
        panelcal("history", "diff", "1", "2", *ledger, "--program", "job/job.exc", "-m", "job/machine.toml",
                 "--report", "diff.html")
        maps = [(FIXTURES / name / "map.json").read_text() for name in ("plane-tilted", "plane-tilted-20-um-higher")]
        golden_ledger.make("surfaces.ledger", [
            (golden_ledger.offset(0, 0, f"2026-11-{19 + i}T02:00:00Z", subject="table", kind="surface", covariance=[[1e-6]],
                                  parameters=[{"name": "offset", "value": 1.6, "unit": "mm"}])[0], text)
            for i, text in enumerate(maps)]).close()
        panelcal("history", "diff", "1", "2", "-l", "surfaces.ledger", "--report", "surfaces.html")
        panelcal("surface", "fit", ROOT / "tests/tools/surface/plane.jsonl", "-o", "map.json", "--report", "map.html")
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        os.chdir("/")
        cls.folder.cleanup()

    def changed(self, **changes):
        return browser.with_facts(self.page, {**self.facts, **changes}, "changed.html")

    def test_facts_keep_to_their_schemas(self):
        for page in (self.page, "list.html", "show.html", "plot.html", "diff.html", "surfaces.html"):
            checked(in_page(page), ROOT)

    def test_says_first_whether_to_drill(self):
        self.browser.open(self.page)
        self.assertEqual(self.browser.texts("main h1, main .word, main h2")[:3],
                         ["Night of 2026-11-22 on drill 1", "DRILL", "Since last week"])
        self.assertIn(self.facts["verdict"], self.browser.texts(".verdict .top p"))
        self.assertEqual(self.browser.count(".verdict .next"), 0)
        self.browser.open(self.changed(may_drill=False, drill_until=None, outcome="refused"))
        self.assertEqual(self.browser.texts(".verdict.hold .word"), ["HOLD"])
        self.assertIn("fresh-start", self.browser.texts(".verdict .next")[0])
        self.assertIn("do not drill", self.browser.texts(".verdict .tile")[0])
        self.browser.open(self.changed(dry_run=True))
        self.assertEqual(self.browser.texts(".verdict.forced .word"), ["DRY RUN"])

    def test_refused_gates_have_a_word_and_not_a_colour_alone(self):
        facts = copy.deepcopy(self.facts)
        gates = facts["steps"][0]["decision"]["gates"]
        gates[0]["passed"] = False
        self.browser.open(browser.with_facts(self.page, facts, "changed.html"))
        lines = self.browser.texts("#step-1 .messages li")
        self.assertIn(f"refused {gates[0]['name']} {gates[0]['text']}", lines)
        self.assertIn(f"passed {gates[1]['name']} {gates[1]['text']}", lines)

    def test_every_night_can_be_pointed_at(self):
        self.browser.open(browser.with_facts(self.page, many_nights(self.facts), "changed.html"))
        self.assertEqual(self.browser.count("svg.chart:not(.sample)"), 2)
        self.assertEqual(self.browser.count("svg.chart:not(.sample) circle.filled"), 2 * 59)
        self.assertEqual(self.browser.count("svg.chart:not(.sample) .cross"), 2)
        # Refused far off: on the edge of the chart of x, with its distance.
        self.assertEqual(self.browser.count("svg.chart text.beyond"), 1)
        self.assertRegex(self.browser.texts("svg.chart text.beyond")[0], r"\+21\d\.\d")
        lines = self.browser.point_at("svg.chart circle.filled", 10)
        step = self.facts["steps"][0]
        x = step["series"][-1]["value"][0] + 1e-3 * math.sin(10)
        self.assertEqual(lines[0], "2026-09-11 02:00 UTC")
        self.assertTrue(lines[1].startswith(f"{x:.4f}\u00a0mm"), lines)
        self.assertEqual(lines[2], "installed, entry 11")
        self.assertIn("asked by timer", lines)
        self.assertTrue(any("limit" in line for line in lines), lines)
        self.assertIn("refused, entry 46", self.browser.point_at("svg.chart .cross")[2])
        self.assertIn("installed by a person", self.browser.point_at("svg.chart circle.filled", 49)[2])

    def test_arrow_keys_read_a_chart(self):
        self.browser.open(browser.with_facts(self.page, many_nights(self.facts), "changed.html"))
        for key, expected in (("ArrowRight", "2026-09-01"), ("ArrowRight", "2026-09-02"), ("ArrowLeft", "2026-09-01")):
            self.browser.run("""const chart = document.querySelector("svg.chart");
              chart.dispatchEvent(new KeyboardEvent("keydown", {key: arguments[0], bubbles: true}));""", key)
            self.assertTrue(self.browser.texts(".hint:not([hidden]) div")[0].startswith(expected))

    def test_what_is_not_known_is_a_dash(self):
        facts = copy.deepcopy(self.facts)
        step = facts["steps"][0]
        step["series"][0]["value"] = [None, None]
        step["series"][1]["sigma"] = []
        step["holes"][0]["residual_mm"] = [None, 0]
        step["axes"][0].update(new=None, sigma=None, expected=None, expected_sigma=None)
        step.update(tolerance=None, decision=None, change=None)
        self.browser.open(browser.with_facts(self.page, facts, "changed.html"))
        self.assertNotIn("NaN", self.browser.run("return document.body.innerHTML.split('<script')[0]"))
        self.assertEqual(self.browser.texts("#step-1 tbody tr:first-child td")[2:4], ["\u2013", "\u2013"])
        step.update(series=[], holes=[], axes=[])
        self.browser.open(browser.with_facts(self.page, facts, "changed.html"))
        self.assertEqual(self.browser.count("svg"), 0)

    def test_warming_up_is_drawn(self):
        looks = [[60 * i, 300 + 0.008 * math.exp(-i / 5), 200, 0.0003] for i in range(10)]
        fit = {"warm_mm": [300, 200], "cold_offset_mm": [0.008, 0], "time_constant_s": 300,
               "time_constant_sigma_s": 20, "wait_s": 416, "wait_sigma_s": 20}
        warm_up = {"limit_mm": 0.002, "warm": True, "text": "warm after 6.9 min", "looks": looks, "fit": fit}
        checked({**self.facts, "warm_up": warm_up}, ROOT)
        self.browser.open(self.changed(warm_up=warm_up))
        self.assertEqual(self.browser.texts("#warm-up h2"), ["Warming up warm"])
        self.assertEqual([self.browser.count(f"#warm-up svg .{one}") for one in ("filled", "hollow", "step", "event")],
                         [10, 10, 2, 1])
        self.assertEqual(self.browser.point_at("#warm-up circle.filled")[0], "after 0.0 min")

    def test_a_probed_surface_is_drawn(self):
        facts = copy.deepcopy(self.facts)
        facts["steps"][0].update(kind="surface", subject="table", surface=in_page("map.html"))
        self.browser.open(browser.with_facts(self.page, checked(facts, ROOT), "changed.html"))
        self.assertIn("The surface tonight", self.browser.texts("#step-1 h3"))
        # Heights, sigmas, residuals.
        self.assertEqual(self.browser.count("#step-1 canvas"), 3)
        self.assertEqual(self.browser.cut_off(), [])
        self.browser.open("surfaces.html")
        # 20 um higher, as the fixture's name says.
        self.assertTrue(any("+20.0" in text for text in self.browser.texts(".tile")), self.browser.texts(".tile"))
        self.assertEqual(self.browser.count("#difference canvas"), 1)

    def test_ledgers_entries_stand_over_time(self):
        self.browser.open("list.html")
        # Three things are calibrated, five entries; three of them are installed.
        self.assertEqual(self.browser.count("#timeline text.lane"), 3)
        self.assertEqual([self.browser.count(f"#timeline svg.chart:not(.sample) .{one}")
                          for one in ("filled", "cross", "hollow")], [3, 1, 1])
        self.assertIn("change 946 um, limit 50 um", self.browser.point_at("#timeline svg.chart .cross"))
        rows = self.browser.texts("#entries tbody tr")
        self.assertEqual(len(rows), 5)
        self.assertTrue(rows[0].startswith("52026-11-21 02:10camera zoom 1, drill 1measured only"), rows[0])
        self.assertIn("in force", rows[3])
        self.assertEqual(self.browser.count("#charts svg.chart:not(.sample)"), 2)

    def test_a_parameter_is_drawn_with_what_was_in_force(self):
        self.browser.open("plot.html")
        self.assertEqual([self.browser.count(f"#chart svg.chart:not(.sample) .{one}")
                          for one in ("filled", "cross", "step")], [2, 1, 1])
        self.assertIn("50.3000\u00a0mm (+295.9\u00a0\u00b5m \u00b1 1.0\u00a0\u00b5m)",
                      self.browser.point_at("#chart svg.chart .cross"))
        # Gone back to the first: it is the zero now, and the second 4.1 um off.
        self.browser.open("back.html")
        self.assertIn("(50.0000\u00a0mm)", self.browser.texts("#chart figcaption")[0])
        self.assertIn("50.0041\u00a0mm (+4.1\u00a0\u00b5m \u00b1 1.0\u00a0\u00b5m)", self.browser.point_at("#chart circle.filled", 1))
        self.browser.open("show.html")
        self.assertEqual(self.browser.texts("#entry-2 > .scroll tbody tr"), ["offset_x50.0041\u00a0mm1.0\u00a0\u00b5m",
                                                                  "offset_y\u22123.0002\u00a0mm2.0\u00a0\u00b5m"])

    def test_a_change_is_drawn_as_arrows_over_the_panel(self):
        self.browser.open("diff.html")
        # Four holes and the scale; three targets. sqrt(4.1^2 + 0.2^2) = 4.105.
        self.assertEqual(self.browser.count("#job svg .arrow"), 5)
        self.assertEqual(self.browser.count("#job svg .target"), 3)
        self.assertIn("4.10\u00a0\u00b5m", self.browser.texts("#job .tile")[0])
        lines = self.browser.point_at("#job svg .place")
        self.assertEqual(lines[:2], ["(20.000, 20.000)\u00a0mm", "moves by 4.10 \u00b5m: (+4.10, \u22120.20) \u00b5m"])
        self.assertIn("line 13, tool 1", lines[2])

    def test_nothing_is_cut_off(self):
        pages = [browser.with_facts(self.page, many_nights(self.facts), "many.html"), "list.html", "plot.html",
                 "diff.html", "show.html"]
        for page in pages:
            for width in browser.WIDTHS:
                for dark in (False, True):
                    with self.subTest(page=page, width=width, dark=dark):
                        self.browser.open(page, width, dark)
                        self.assertEqual(self.browser.cut_off(), [])

    def test_hostile_names_inject_nothing(self):
        for page in (self.page, "list.html", "show.html", "diff.html"):
            with self.subTest(page=page):
                facts = browser.hostile(in_page(page), KEPT)
                self.browser.open(browser.with_facts(page, facts, "hostile.html"))
                self.assertIsNone(self.browser.run("return window.injected ?? null"))
                self.assertEqual(self.browser.count("img"), 0)
                self.assertEqual(self.browser.count("script"), 3)
                self.assertIn(browser.HOSTILE_SHOWN, "".join(self.browser.texts("main")))

    def test_speaks_german(self):
        self.browser.open(self.page)
        self.browser.run("document.querySelector('button.language').click()")
        self.assertEqual(self.browser.texts(".word"), ["BOHREN"])
        self.assertEqual(self.browser.run("return document.title"), "Nacht vom 2026-11-22 an drill 1")

    def test_sentences_of_the_program_are_marked_as_english(self):
        keys = ("verdict", "changes", "notes", "summary", "text", "reasons", "alarms", "since_when", "fit_report")
        facts = copy.deepcopy(self.facts)
        facts["notes"] = ["a note of some words"]
        facts["steps"][0].update(alarms=["the chart of drift is out of its limit"], since_when="off since Monday at noon")
        self.assertGreater(len(browser.sentences(facts, keys)), 15)
        self.browser.open(browser.with_facts(self.page, facts, "changed.html"))
        self.browser.run("document.querySelector('button.language').click()")
        self.assertEqual(self.browser.run("return document.documentElement.lang"), "de")
        self.assertEqual(self.browser.not_marked_as_english(facts, keys), [])
        for width in browser.WIDTHS:
            self.browser.open("changed.html", width)
            self.browser.run("document.querySelector('button.language').click()")
            self.browser.settle()
            self.assertEqual(self.browser.cut_off(), [])


if __name__ == "__main__":
    browser.skip_without_browser()
    unittest.main()
