#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The report of a job in a real browser, and its facts against their schema.

    job_report_test.py PANELCAL REPOSITORY
"""
import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import browser  # noqa: E402
import facts  # noqa: E402
import json_schema  # noqa: E402

browser.skip_without_browser()
ROOT = Path(sys.argv.pop())
PANELCAL = Path(sys.argv.pop()).resolve()
DEMO = ROOT / "datasets/demo"
MAX_REPORT_BYTES = 1_000_000
# A file name has no slash.
HOSTILE_NAME = "<img src=x onerror=window.injected=1>'\"&amp;.exc"


def schema(name):
    return json.loads((ROOT / f"share/schema/{name}.schema.json").read_text(encoding="utf-8"))


class JobReport(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp())
        cls.demo = cls.folder / "demo.html"
        cls.run_panelcal("run", DEMO / "panel.exc", "-m", DEMO / "machine.toml", "--images", DEMO / "images",
                         "--truth", DEMO / "images/truth.json", "-o", cls.folder / "corrected.drl",
                         "--report", cls.demo, "--json", cls.folder / "demo.json",
                         "--save-measurements", cls.folder / "m.jsonl")
        cls.facts = json.loads((cls.folder / "demo.json").read_text(encoding="utf-8"))
        cls.page = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.page.close()
        shutil.rmtree(cls.folder)

    @classmethod
    def run_panelcal(cls, *words, code=0):
        done = subprocess.run([PANELCAL, *words], cwd=cls.folder, capture_output=True, text=True, timeout=300)
        assert done.returncode == code, done.stderr
        return done

    def script(self, text, *values):
        return self.page.run(text, *values)

    def picture_of_the_map(self):
        return self.script("return document.querySelector('.map canvas').toDataURL()")

    def test_facts_follow_their_schema(self):
        self.assertEqual(json_schema.problems(schema("job"), self.facts), [])
        self.assertEqual(facts.in_page(self.demo), self.facts)
        for kind in ("job", "check"):
            self.assertTrue(json_schema.is_closed(schema(kind)), "a key could come unnoticed")

    def test_findings_of_a_check_follow_their_schema(self):
        for words, code in ((["check", DEMO / "panel.exc", "-m", DEMO / "machine.toml"], 0),
                            (["check", "-m", DEMO / "machine.toml"], 0),
                            (["check", DEMO / "machine.toml"], 2)):
            with self.subTest(words=words):
                done = self.run_panelcal(*words, "--json", "-", code=code)
                found = json.loads(done.stdout)
                self.assertEqual(json_schema.problems(schema("check"), found), [])
                self.assertEqual(found["has_errors"], code != 0)
        self.assertEqual(self.facts["places"]["n_holes"], 990)

    def test_a_report_of_21_targets_is_small(self):
        self.page.open(self.demo)
        self.assertEqual(len(self.facts["targets"]), 21)
        self.assertEqual(len(self.script("return JSON.parse(document.getElementById('pictures').textContent)")), 21)
        self.assertLess(self.demo.stat().st_size, MAX_REPORT_BYTES)

    def test_the_page_opens_without_complaint_and_nothing_is_cut_off(self):
        for width_px in browser.WIDTHS:
            with self.subTest(width_px=width_px):
                self.page.open(self.demo, width_px)
                self.assertEqual(self.page.cut_off(), [])
                self.assertIn("DRILL", self.script("return document.querySelector('.verdict .word').textContent"))
                # Rows of a table are as tall as their text.
                tallest = self.script("return Math.max(...[...document.querySelectorAll('#tolerance tbody tr')].map("
                                      "(row) => row.getBoundingClientRect().height))")
                self.assertLess(tallest, 60)

    def test_every_target_has_its_card_and_its_picture_opens_large(self):
        self.page.open(self.demo)
        self.assertEqual(self.script("return document.querySelectorAll('article.card').length"), 21)
        self.assertEqual(self.script("return document.querySelectorAll('.thumbnail .outline').length > 20"), True)
        self.script("document.querySelector('.thumbnail').click()")
        box = self.script("const b = document.querySelector('dialog[open] svg').getBoundingClientRect();"
                          "return [b.width, b.height]")
        self.assertGreater(min(box), 300)
        self.assertIn("95", self.script("return document.querySelector('dialog[open]').textContent"))

    def test_the_map_names_the_hole_under_the_pointer(self):
        self.page.open(self.demo)
        # The first hole's pixel, from the map's own box: holes fill it but for a margin.
        hint = self.script("""
          const canvas = document.querySelector(".map canvas");
          const box = canvas.getBoundingClientRect();
          for (let x = 40; x < box.width - 40; x += 4) for (let y = 40; y < box.height - 40; y += 7) {
            const at = { clientX: box.left + x, clientY: box.top + y, bubbles: true };
            canvas.dispatchEvent(new PointerEvent("pointermove", at));
            const hint = document.querySelector(".map .hint:not([hidden])");
            if (hint) return hint.innerText;
          }
          return "";""")
        self.assertRegex(hint, r"hole, T\d+\n.*line \d+.*\nnominal \(")
        self.assertRegex(hint, r"sigma [\d.]+")

    def test_the_map_is_moved_zoomed_and_read_by_touch(self):
        self.page.open(self.demo, 400)
        x, y = self.script("""
          const canvas = document.querySelector(".map canvas");
          canvas.scrollIntoView({block: "center"});
          const box = canvas.getBoundingClientRect();
          return [box.left + box.width / 2, box.top + box.height / 2];""")
        self.page.settle()
        pictures = {self.picture_of_the_map()}
        before = self.script("return scrollY")
        for steps in ([[(x, y)], [(x + 20, y + 30)], [(x + 40, y + 60)]],
                      [[(x - 20, y), (x + 20, y)], [(x - 50, y), (x + 50, y)], [(x - 90, y), (x + 90, y)]]):
            self.page.touch(*steps)
            self.page.until(lambda: self.picture_of_the_map() not in pictures)
            pictures.add(self.picture_of_the_map())
        # Neither the page nor its scale has moved instead.
        self.assertEqual(self.script("return [scrollY, visualViewport.scale]"), [before, 1])
        # A tap near a hole says its numbers, and they stay when the finger is lifted.
        for dx in range(-120, 121, 8):
            self.page.touch([(x + dx, y)])
            if self.page.count(".map .hint:not([hidden])"):
                break
        self.assertRegex("".join(self.page.texts(".map .hint:not([hidden])")), r"hole, T\d+line \d+")

    def test_the_map_shows_other_colours_for_other_values(self):
        self.page.open(self.demo)
        pictures = {self.picture_of_the_map()}
        modes = self.script("return [...document.querySelectorAll('#panel select option')].map((o) => o.value)")
        self.assertEqual(modes, ["tool", "shift", "sigma", "risk"])
        for mode in modes[1:]:
            self.script("const s = document.querySelector('#panel select'); s.value = arguments[0];"
                        "s.dispatchEvent(new Event('change'))", mode)
            self.page.until(lambda: self.picture_of_the_map() not in pictures)
            pictures.add(self.picture_of_the_map())

    def test_the_surface_of_depths_and_an_autofocus_are_drawn(self):
        # A plane that rises by 0.01 mm from node to node along x.
        n = 8
        heights = [1.5 + 0.01 * (i % n) if i else None for i in range(n * n)]
        depth_map = {"axis": 1, "zone": "", "low_mm": [0, 0], "step_mm": 10, "n_x": n, "n_y": n, "height_mm": heights,
                     "sigma_um": [2] * (n * n)}
        worst = {"axis": 1, "line": 30, "file": None, "board": [], "nominal_mm": [30, 30], "mean_um": 1, "sigma_um": 2,
                 "risk_too_shallow": 0.1, "risk_too_deep": 0.2}
        tool = {"tool": 1, "n_depths": 1, "n_judged": 1, "too_shallow_um": 9, "too_deep_um": 9, "largest_mean_um": 1,
                "largest_sigma_um": 2, "expected_too_shallow": 0.1, "expected_too_deep": 0.2, "n_warned": 0, "n_held": 0,
                "worst": worst}
        depth = {"sentence": "depths hold", "n_judged": 1, "expected_broken": 0.3, "worst_risk": 0.2, "warn_above": 0.01,
                 "hold_above": 0.1, "machine_sigma_um": 1, "surface_lines": [], "tools": [tool], "maps": [depth_map]}
        curve = [{"z_mm": 10 + 0.1 * k, "sharpness": 9 - (k - 3) ** 2} for k in range(7)]
        focus = [{"line": 5, "expected_mm": [1, 2], "is_found": True, "z_mm": 10.3, "sigma_um": 4, "reason": "", "curve": curve}]
        page = browser.with_facts(self.demo, {**self.facts, "depth": depth, "focus": focus}, self.folder / "depth.html")
        for width_px in browser.WIDTHS:
            self.page.open(page, width_px)
            self.assertEqual(self.page.cut_off(), [])
        said = self.script("""
          const canvas = document.querySelector("#depth canvas"), box = canvas.getBoundingClientRect();
          canvas.dispatchEvent(new PointerEvent("pointermove", {clientX: box.left + box.width / 2, clientY: box.top + box.height / 2}));
          return [...document.querySelectorAll("#depth .hint div")].map((one) => one.textContent);""")
        x = float(re.match(r"\(([\d.]+),", said[0])[1])
        self.assertAlmostEqual(float(said[1].split("\u00a0")[0]), 1.5 + 0.001 * x, delta=1e-4)
        self.assertEqual(self.page.count("#focus svg circle.filled"), len(curve))
        self.assertEqual(self.page.point_at("#focus svg circle.filled", 3)[-1], "10.3000\u00a0mm: 9.00")

    def test_german_and_english(self):
        self.page.open(self.demo)
        self.assertIn("targets found", self.script("return document.body.innerText"))
        self.script("document.querySelector('button.language').click()")
        for width_px in browser.WIDTHS:
            self.page.resize(width_px)
            self.assertEqual(self.page.cut_off(), [])
        text = self.script("return document.body.innerText")
        self.assertIn("Marken gefunden", text)
        self.assertNotIn("targets found", text)
        self.assertEqual(self.script("return document.documentElement.lang"), "de")
        keys = ("grounds", "next", "reason", "text", "advice", "sentence", "basis_words", "surface_lines", "limits")
        self.assertGreater(len(browser.sentences(self.facts, keys)), 5)
        self.assertEqual(self.page.not_marked_as_english(self.facts, keys), [])

    def nothing_is_injected(self):
        self.assertIsNone(self.script("return window.injected ?? null"))
        self.assertEqual(self.script("return document.querySelectorAll('img, iframe, object').length"), 0)
        self.assertEqual(self.script("return document.scripts.length"), 3)

    def test_hostile_names_inject_nothing(self):
        shutil.copy(DEMO / "panel.exc", self.folder / HOSTILE_NAME)
        shutil.copy(DEMO / "camera.cal.json", self.folder)
        machine = (DEMO / "machine.toml").read_text(encoding="utf-8")
        machine = re.sub(r"(?m)^name = .*$", "name = '</script><script>window.injected=2</script>'", machine, count=1)
        (self.folder / "hostile.toml").write_text(machine, encoding="utf-8")
        page = self.folder / "hostile.html"
        self.run_panelcal("run", HOSTILE_NAME, "-m", "hostile.toml", "--measurements", "m.jsonl",
                          "-o", "hostile.drl", "--report", page)
        self.page.open(page)
        self.nothing_is_injected()
        self.assertIn("onerror", self.script("return document.querySelector('h1').innerText"))
        self.assertIn("onerror", self.script("return document.title"))

    def test_hostile_facts_inject_nothing(self):
        keep = {"facts", "word", "level", "model", "state", "status", "means", "basis", "decision", "type", "base64",
                "name", "severity"}
        page = browser.with_facts(self.demo, browser.hostile(self.facts, keep), self.folder / "all.html")
        self.page.open(page)
        self.nothing_is_injected()
        shown = self.script("return document.body.innerText")
        self.assertIn("<script>window.injected=1", shown)
        # What turns the direction of writing is shown as its code.
        self.assertNotIn("\u202e", shown)
        self.assertIn("\\u202e", shown)

    def test_a_held_job_says_so_and_shows_what_it_would_have_drilled(self):
        machine = (DEMO / "machine.toml").read_text(encoding="utf-8")
        strict, n = re.subn(r"(?m)^position_um = .*$", "position_um = 0.5", machine)
        self.assertEqual(n, 1)
        shutil.copy(DEMO / "camera.cal.json", self.folder)
        (self.folder / "strict.toml").write_text(strict, encoding="utf-8")
        page = self.folder / "held.html"
        self.run_panelcal("run", DEMO / "panel.exc", "-m", "strict.toml", "--measurements", "m.jsonl",
                          "-o", "held.drl", "--report", page, code=1)
        self.assertFalse((self.folder / "held.drl").exists())
        self.assertEqual(json_schema.problems(schema("job"), facts.in_page(page)), [])
        self.page.open(page, 400)
        self.assertEqual(self.page.cut_off(), [])
        self.assertIn("HOLD", self.script("return document.querySelector('.verdict .word').textContent"))


if __name__ == "__main__":
    unittest.main()
