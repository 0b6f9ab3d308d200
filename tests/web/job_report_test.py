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
import json_schema  # noqa: E402

browser.require()
ROOT = Path(sys.argv.pop())
PANELCAL = Path(sys.argv.pop()).resolve()
DEMO = ROOT / "datasets/demo"
MAX_REPORT_BYTES = 1_000_000
HOSTILE = "<img src=x onerror=document.title=1>'\"&amp;"


def schema(name):
    return json.loads((ROOT / f"share/schema/{name}.schema.json").read_text(encoding="utf-8"))


def embedded(page, part="facts"):
    text = page.read_text(encoding="utf-8")
    return json.loads(re.search(rf'<script type="application/json" id="{part}">(.*?)</script>', text, re.DOTALL)[1])


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
        cls.browser = browser.start()

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        shutil.rmtree(cls.folder)

    @classmethod
    def run_panelcal(cls, *words, code=0):
        done = subprocess.run([PANELCAL, *words], cwd=cls.folder, capture_output=True, text=True, timeout=300)
        assert done.returncode == code, done.stderr
        return done

    def script(self, text, *values):
        return self.browser.execute_script(text, *values)

    def test_facts_follow_their_schema(self):
        self.assertEqual(json_schema.problems(schema("job"), self.facts), [])
        self.assertEqual(embedded(self.demo), self.facts)
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
        self.assertEqual(len(self.facts["targets"]), 21)
        self.assertEqual(len(embedded(self.demo, "pictures")), 21)
        self.assertLess(self.demo.stat().st_size, MAX_REPORT_BYTES)

    def test_the_page_opens_without_complaint_and_nothing_is_cut_off(self):
        for width_px in browser.WIDTHS_PX:
            with self.subTest(width_px=width_px):
                browser.show(self.browser, self.demo, width_px)
                self.assertEqual(browser.complaints(self.browser), [])
                self.assertEqual(browser.cut_off(self.browser), [])
                self.assertIn("DRILL", self.script("return document.querySelector('.verdict .word').textContent"))
                # Rows of a table are as tall as their text.
                tallest = self.script("return Math.max(...[...document.querySelectorAll('#tolerance tbody tr')].map("
                                      "(row) => row.getBoundingClientRect().height))")
                self.assertLess(tallest, 60)

    def test_every_target_has_its_card_and_its_picture_opens_large(self):
        browser.show(self.browser, self.demo, 1280)
        self.assertEqual(self.script("return document.querySelectorAll('article.card').length"), 21)
        self.assertEqual(self.script("return document.querySelectorAll('.thumbnail .outline').length > 20"), True)
        self.script("document.querySelector('.thumbnail').click()")
        box = self.script("const b = document.querySelector('dialog[open] svg').getBoundingClientRect();"
                          "return [b.width, b.height]")
        self.assertGreater(min(box), 300)
        self.assertIn("95", self.script("return document.querySelector('dialog[open]').textContent"))

    def test_the_map_names_the_hole_under_the_pointer(self):
        browser.show(self.browser, self.demo, 1280)
        # The first hole's pixel, from the map's own box: holes fill it but for a margin.
        hint = self.script("""
          const canvas = document.querySelector(".map canvas");
          const box = canvas.getBoundingClientRect();
          for (let x = 40; x < box.width - 40; x += 4) for (let y = 40; y < box.height - 40; y += 7) {
            const at = { clientX: box.left + x, clientY: box.top + y, bubbles: true };
            canvas.dispatchEvent(new PointerEvent("pointermove", at));
            const hint = document.querySelector(".map .hint");
            if (hint) return hint.innerText;
          }
          return "";""")
        self.assertRegex(hint, r"hole, T\d+\n.*line \d+.*\nnominal \(")
        self.assertRegex(hint, r"sigma [\d.]+")

    def test_the_map_shows_other_colours_for_other_values(self):
        browser.show(self.browser, self.demo, 1280)
        pictures = set()
        for mode in self.script("return [...document.querySelectorAll('#panel select option')].map((o) => o.value)"):
            self.script("const s = document.querySelector('#panel select'); s.value = arguments[0];"
                        "s.dispatchEvent(new Event('change'))", mode)
            pictures.add(self.script("return document.querySelector('.map canvas').toDataURL()"))
        self.assertGreaterEqual(len(pictures), 3)

    def test_german_and_english(self):
        browser.show(self.browser, self.demo, 1280)
        self.assertIn("targets found", self.script("return document.body.innerText"))
        self.script("document.querySelector('button.language').click()")
        text = self.script("return document.body.innerText")
        self.assertIn("Marken gefunden", text)
        self.assertNotIn("targets found", text)
        self.assertEqual(self.script("return document.documentElement.lang"), "de")
        self.assertEqual(browser.complaints(self.browser), [])

    def test_hostile_names_inject_nothing(self):
        shutil.copy(DEMO / "panel.exc", self.folder / f"a{HOSTILE}.exc")
        shutil.copy(DEMO / "camera.cal.json", self.folder)
        machine = (DEMO / "machine.toml").read_text(encoding="utf-8")
        machine = re.sub(r'(?m)^name = .*$', f"name = '''{HOSTILE}</script><script>document.title=2</script>'''",
                         machine, count=1)
        (self.folder / "hostile.toml").write_text(machine, encoding="utf-8")
        page = self.folder / "hostile.html"
        self.run_panelcal("run", f"a{HOSTILE}.exc", "-m", "hostile.toml", "--measurements", "m.jsonl",
                          "-o", "hostile.drl", "--report", page)
        browser.show(self.browser, page, 1280)
        self.assertEqual(browser.complaints(self.browser), [])
        self.assertEqual(self.script("return document.querySelectorAll('img, iframe, object').length"), 0)
        self.assertEqual(self.script("return document.scripts.length"), 3)
        self.assertIn("onerror", self.script("return document.querySelector('h1').innerText"))
        self.assertIn("onerror", self.script("return document.title"))

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
        self.assertEqual(json_schema.problems(schema("job"), embedded(page)), [])
        browser.show(self.browser, page, 400)
        self.assertEqual(browser.complaints(self.browser), [])
        self.assertEqual(browser.cut_off(self.browser), [])
        self.assertIn("HOLD", self.script("return document.querySelector('.verdict .word').textContent"))


if __name__ == "__main__":
    unittest.main()
