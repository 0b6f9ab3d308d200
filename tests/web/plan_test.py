#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of a plan, in a browser: what it computes when a target moves is what the plan says of such a program.

    plan_test.py PANELCAL REPOSITORY
"""
import re
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
HEAD = "M48\nMETRIC,TZ\nT1C1.0F100\nT2C2.0F100\n%\nG34,1\n"
HOLES = "T1\nX20.0Y20.0\nX280.0Y270.0\nX150.0Y40.0\nX30.0Y250.0\nX220.0Y120.0\nM30\n"
KEPT = ("facts", "level", "is", "model", "reason", "places_are", "noticed_by", "model_rule", "models_with")


def program(targets, holes=HOLES):
    return HEAD + "".join(f"G36X{x:.3f}Y{y:.3f}\n" for x, y in targets) + holes


def plan(folder, text, *options):
    """The facts of a program's plan; its page is FOLDER/plan.html."""
    machine = (ROOT / "tests/golden/fixtures/three-targets-without-gates/machine.toml").read_text()
    n = text.count("G36")
    (folder / "machine.toml").write_text(re.sub(r"rotate = \d+", f"rotate = {max(1, n)}", machine))
    (folder / "job.exc").write_text(text)
    done = subprocess.run([PANELCAL, "-q", "plan", "job.exc", "-m", "machine.toml", "--report", "plan.html", *options],
                          cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return checked(in_page(folder / "plan.html"), ROOT)


class Plan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        cls.demo = cls.folder / "demo.html"
        subprocess.run([PANELCAL, "-q", "plan", DEMO / "panel.exc", "-m", DEMO / "machine.toml", "--add", "2",
                        "--report", cls.demo], check=True, capture_output=True, timeout=120)
        cls.facts = checked(in_page(cls.demo), ROOT)
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.temporary.cleanup()

    def shown(self, series=0):
        """The worst leverage that the map of a series shows now."""
        text = self.browser.texts(".leverage [role=status]")[series]
        return float(re.search(r"Worst: ([\d.,]+)", text)[1].replace(",", ""))

    def choose(self, series, select, value):
        self.browser.run("""
          const one = document.querySelectorAll(".leverage")[arguments[0]].querySelectorAll("select")[arguments[1]];
          one.value = arguments[2];
          one.dispatchEvent(new Event("change"));""", series, select, value)

    def press(self, series, button):
        self.browser.run("document.querySelectorAll('.leverage')[arguments[0]].querySelectorAll('button')[arguments[1]].click()",
                         series, button)

    def key(self, *keys):
        for key in keys:
            self.browser.run("""
              document.querySelector(".leverage canvas").dispatchEvent(new KeyboardEvent("keydown",
                {key: arguments[0].replace("shift ", ""), shiftKey: arguments[0].startsWith("shift "), bubbles: true}));""", key)

    def test_is_whole_at_every_width_and_in_both_themes(self):
        for width in browser.WIDTHS:
            for dark in (False, True):
                with self.subTest(width=width, dark=dark):
                    self.browser.open(self.demo, width, dark)
                    self.assertEqual(self.browser.cut_off(), [])
                    self.assertEqual(self.browser.count(".leverage canvas"), len(self.facts["series"]))
                    colours = self.browser.run("""
                      const canvas = document.querySelector(".leverage canvas");
                      const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
                      const seen = new Set();
                      for (let i = 0; i < pixels.length; i += 4) seen.add(pixels[i] << 16 | pixels[i + 1] << 8 | pixels[i + 2]);
                      return seen.size;""")
                    self.assertGreater(colours, 50)

    def test_computes_what_the_facts_say_of_every_model_and_proposal(self):
        self.browser.open(self.demo)
        for i, series in enumerate(self.facts["series"]):
            for model in series["models"]:
                with self.subTest(series=i, model=model["model"]):
                    self.choose(i, 0, model["model"])
                    self.assertAlmostEqual(self.shown(i), model["worst_leverage"], delta=0.006)
            for k, addition in enumerate(series["additions"]):
                with self.subTest(series=i, addition=k):
                    self.press(i, 1 + k)
                    self.assertAlmostEqual(self.shown(i), addition["worst_leverage"], delta=0.006)
            self.press(i, 0)
            written = next(one for one in series["models"] if one["model"] == series["model"])
            self.assertAlmostEqual(self.shown(i), written["worst_leverage"], delta=0.006)

    def test_moves_a_target_as_a_program_with_it_there(self):
        targets = [(0, 0), (300, 10), (15, 290)]
        facts = plan(self.folder, program([(targets[0][0] + 40, targets[0][1] + 12), *targets[1:]]))
        series = facts["series"][0]
        wanted = next(one for one in series["models"] if one["model"] == series["model"])["worst_leverage"]
        before = plan(self.folder, program(targets))["series"][0]
        self.browser.open(self.folder / "plan.html")
        self.key(" ", *["shift ArrowRight"] * 4, "shift ArrowUp", "ArrowUp", "ArrowUp")
        self.assertAlmostEqual(self.shown(), wanted, delta=0.006)
        self.assertNotAlmostEqual(wanted, before["models"][3]["worst_leverage"], delta=0.02)
        self.press(0, 0)
        self.assertAlmostEqual(self.shown(), before["models"][3]["worst_leverage"], delta=0.006)

    def test_follows_the_pointer_and_takes_a_pad(self):
        plan(self.folder, program([(0, 0), (300, 10), (15, 290)]))
        self.browser.open(self.folder / "plan.html")
        found = self.browser.run("""
          const canvas = document.querySelector(".leverage canvas"), box = canvas.getBoundingClientRect();
          const send = (type, x, y) => canvas.dispatchEvent(new PointerEvent(type, {clientX: box.left + x, clientY: box.top + y,
            pointerId: 1, buttons: 1, bubbles: true}));
          canvas.setPointerCapture = () => {};
          const hint = document.querySelector(".hint"), status = document.querySelector("[role=status]");
          // Where a place is on the canvas, by what the hint says at two points.
          const at = (x, y) => {
            send("pointermove", x, y);
            return [...hint.children].map((one) => one.textContent).find((text) => text.startsWith("(")).replaceAll("\u2212", "-").match(/-?[\\d.]+/g).map(Number);
          };
          const [ax, ay] = at(200, 200), [bx, by] = at(400, 400);
          const pixel = (x, y) => [200 + (x - ax) / (bx - ax) * 200, 200 + (y - ay) / (by - ay) * 200];
          const out = {before: status.textContent, pad: pixel(280, 270), drag: pixel(300, 10)};
          send("pointermove", ...out.drag);
          out.hint = hint.textContent;
          send("pointerdown", ...out.pad);
          send("pointerup", ...out.pad);
          out.added = status.textContent;
          send("pointerdown", ...out.drag);
          send("pointermove", out.drag[0] - 80, out.drag[1]);
          send("pointerup", out.drag[0] - 80, out.drag[1]);
          out.dragged = status.textContent;
          return out;""")
        self.assertTrue(found["hint"].startswith("target, line 8"), found["hint"])
        self.assertIn("Further targets: 1.", found["added"])
        worst = [float(re.search(r"Worst: ([\d.]+)", found[key])[1]) for key in ("before", "added", "dragged")]
        self.assertLess(worst[1], worst[0])
        self.assertGreater(worst[2], worst[1])
        self.assertIn("As written", found["dragged"])

    def test_says_what_a_wrong_target_does(self):
        # Two targets, rigid: off by e across their line, target 2 turns the panel about target 1 by e / 300, so that
        # a hole at (0, 300) moves by e; the middle moves by e / 2.
        facts = plan(self.folder, program([(0, 0), (300, 0)], "T1\nX0.0Y300.0\nX0.0Y0.1\nX150.0Y150.0\nM30\n"))
        error = facts["series"][0]["targets"][1]["error"]
        self.browser.open(self.folder / "plan.html")
        self.choose(0, 1, "1")
        text = self.browser.texts("[role=status]")[0]
        size, most = (float(one.replace(",", "")) for one in re.findall(r"(?:off by|up to) ([\d.,]+)", text))
        self.assertAlmostEqual(size, error["noticed_from_um"], delta=0.06)
        along, across = (size * part for part in error["direction"])
        # Along their line a rigid panel follows by half; across it turns about the other target.
        expected = max(abs(complex(along / 2 - across * y / 300, across * x / 300)) for x, y in ((0, 300), (150, 150)))
        self.assertAlmostEqual(most, expected, delta=0.02 * expected)

    def test_lives_without_targets_and_without_a_model(self):
        for text in (program([]), program([(0, 0), (150, 0), (300, 0)])):
            facts = plan(self.folder, text)
            self.browser.open(self.folder / "plan.html")
            self.assertEqual(self.browser.cut_off(), [])
            undetermined = [one for one in facts["series"] if not all(model["determined"] for model in one["models"])]
            self.assertEqual(self.browser.count(".leverage"), len(facts["series"]))
            if undetermined:
                self.assertIn("do not determine", self.browser.texts("[role=status]")[0])

    def test_speaks_german(self):
        self.browser.open(self.demo)
        self.browser.run("document.querySelector('button.language').click()")
        self.assertIn("Reihenfolge der Besuche", self.browser.texts("h2"))

    def test_every_text_stays_a_text(self):
        page = browser.with_facts(self.demo, browser.hostile(self.facts, KEPT), self.folder / "hostile.html")
        self.browser.open(page)
        self.assertFalse(self.browser.run("return window.injected === 1"))
        self.assertEqual(self.browser.count("main img, main script"), 0)
        self.assertTrue(any("<img" in text for text in self.browser.texts("h1")))


if __name__ == "__main__":
    browser.skip_without_browser()
    unittest.main()
