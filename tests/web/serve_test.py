#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The operator's screen in a real browser, against a server that plays the states of a machine.

    serve_test.py SERVE_FRONT_END_CC
"""
import copy
import sys
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import browser  # noqa: E402
from fake_station import HEIGHT_PX, WIDTH_PX, Station, picture  # noqa: E402

browser.skip_without_browser()
MADE = sys.argv.pop()
# Away from the middle, where the screen draws a cross.
DISC_PX, DISC_RADIUS_PX = (417, 130), 40
# The middle of a disc on the screen, by its pixels above a threshold.
CLICK_TOLERANCE_PX = 0.1


def idle():
    return {"facts": "screen", "version": 1, "panelcal": "1.0", "machine": "Posalux 5", "source": "simulated machine",
            "programs": [{"name": "panel.exc", "size_bytes": 12345}, {"name": "small.exc", "size_bytes": 99}], "job": None,
            "view": {"frame": 1, "width_px": WIDTH_PX, "height_px": HEIGHT_PX, "um_per_px": 10.0, "place_mm": [12.5, 40.0]},
            "calibration": None, "kinds": ["night", "camera"],
            "history": [{"kind": "camera", "entry": "12", "when": "2026-11-26T03:10:00Z", "in_force": True, "words": "scale 10.001 um"},
                        {"kind": "camera", "entry": "9", "when": "2026-11-25T03:10:00Z", "in_force": False, "words": "scale 10.002 um"}]}


def target(seq, status="waiting", **more):
    at_mm = [20.0 + 60 * (seq % 3), 15.0 + 40 * (seq // 3)]
    return {"seq": seq, "line": 7 + seq, "command": "G36", "tool": 1, "path": [], "nominal_mm": at_mm, "expected_mm": at_mm,
            "status": status, "has_picture": status != "waiting", **more}


def found(seq, **more):
    return target(seq, "found", measured_mm=[20, 15], sigma_um=[0.4, 0.5], residual_um=[3.0 + seq, -2.0], by="camera", **more)


def with_job(state, **more):
    job = {"id": "2026-11-27-1", "program": "panel.exc", "state": state, "findings": [], "n_holes": 990,
           "targets": [target(seq) for seq in range(6)], "series": [], "question": None, "verdict": None, "outputs": [], "output_format": "excellon", **more}
    return {**idle(), "job": job}


def measuring():
    targets = [found(0), found(1), target(2, "looking"), target(3), target(4), target(5)]
    state = with_job("measuring", targets=targets)
    middle = [[320 + 40 * dx, 256 + 40 * dy] for dx, dy in ((1, 0), (0.7, 0.7), (0, 1), (-0.7, 0.7), (-1, 0), (-0.7, -0.7), (0, -1), (0.7, -0.7))]
    state["view"].update(frame=2, search={"at_px": [320, 256], "radius_px": 120}, outline_px=middle,
                         ellipse={"at_px": [320, 256], "axes_px": [0.05, 0.03], "angle_rad": 0.4}, contrast=0.8, sharpness=0.6)
    return state


def asking(question_id=3, **more):
    targets = [found(0), found(1), target(2, "rejected", reason="size 1.9 mm instead of 2.0 mm"), target(3), target(4), target(5)]
    question = {"id": question_id, "seq": 2, "reason": "rejected: size 1.9 mm instead of 2.0 mm",
                "candidates": [{"at_px": [300, 250], "size_px": 80, "score": 0.91}, {"at_px": [420, 130], "size_px": 60, "score": 0.52}],
                "choices": ["again", "search", "candidate", "hand", "skip", "leave_board_out", "keep", "stop"],
                "jog_mm": 5, "exposure_us": 2000, "why_not": {}, **more}
    state = with_job("asking", targets=targets, question=question)
    state["view"].update(frame=3, search={"at_px": [320, 256], "radius_px": 120}, lamp=40)
    return state


def asking_without_search_window():
    state = asking(candidates=[])
    del state["view"]["search"]
    return state


def done(may_drill=True):
    series = [{"line": 7, "path": [], "n_targets": 6, "is_fitted": True, "is_accepted": may_drill, "words": "panel rotated by 2.01 mrad"}]
    return with_job("done" if may_drill else "held", targets=[found(seq) for seq in range(6)], series=series,
                    verdict={"may_drill": may_drill, "words": "all places hold their tolerance"}, has_report=True, has_facts=True)


class Screen(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.page = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.page.close()

    def setUp(self):
        self.station = Station(MADE)
        self.station.say(idle())
        self.page.forget()
        # What an earlier test has provoked.
        self.page.driver.get_log("browser")

    def tearDown(self):
        self.page.run("location.href = 'about:blank'")
        self.station.close()

    def open(self, state=None, width_px=1280, take=True, **more):
        self.station.say(state or idle())
        self.page.open(self.station.address, width_px, **more)
        self.until("document.querySelector('header h1 b')?.textContent === 'Posalux 5'")
        if take:
            self.take()

    def start_anew(self):
        self.page.forget()
        self.station.orders.clear()
        self.station.held_by, self.station.key = None, ""

    def take(self, name="Anna"):
        self.until("document.getElementById('name')")
        self.script("document.getElementById('name').value = arguments[0]; document.getElementById('do-take').click()", name)
        self.until("document.getElementById('do-give')")

    def script(self, text, *values):
        return self.page.run(text, *values)

    def until(self, condition, *values):
        self.page.until(condition, *values)

    def press(self, name):
        self.until("document.getElementById(arguments[0])", f"do-{name}")
        self.until("!document.body.classList.contains('busy')")
        self.script("document.getElementById(arguments[0]).click()", f"do-{name}")

    def arrived(self, *orders):
        """The commands that the server has had so far."""
        self.until(lambda: len(self.station.orders) >= len(orders))
        self.assertEqual(self.station.orders, list(orders))

    def shown(self, frame):
        """Waits until this picture is drawn."""
        self.until("document.getElementById('picture').dataset.frame === arguments[0]", str(frame))
        self.page.settle()

    def click_disc(self, aim=None):
        """A press near the middle of the disc, wherever and however large the page has drawn it: pointers have whole
        pixels of the screen. `aim` is the button that is pressed before. The place, in px of the picture."""
        off_px = self.script("""
          const canvas = document.getElementById("picture"), box = canvas.getBoundingClientRect();
          const {data, width} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          // The mean of what is as bright as the disc, then by brightness over the ground within a wider circle about it.
          let [x, y, radius, size] = [0, 0, Infinity, 0];
          for (const weight of [(v) => v > 205 && v < 225, (v) => Math.max(0, v - 90)]) {
            let [all, across, down, count] = [0, 0, 0, 0];
            for (let i = 0; i < data.length; i += 4) {
              const column = (i / 4) % width + 0.5, row = Math.floor(i / 4 / width) + 0.5, w = Number(weight(data[i]));
              if (!w || Math.hypot(column - x, row - y) > radius) continue;
              [all, across, down, count] = [all + w, across + w * column, down + w * row, count + 1];
            }
            [x, y, size] = [across / all, down / all, Math.sqrt(count / Math.PI)];
            radius = 1.3 * size;
          }
          const at = [box.left + x * box.width / canvas.width, box.top + y * box.height / canvas.height], pressed = at.map(Math.round);
          document.getElementById(arguments[1])?.click();
          canvas.dispatchEvent(new PointerEvent("pointerdown", {bubbles: true, clientX: pressed[0], clientY: pressed[1]}));
          return pressed.map((one, k) => (one - at[k]) * arguments[0] / size);""", DISC_RADIUS_PX, aim)
        return [at + off for at, off in zip(DISC_PX, off_px)]

    def text(self, selector="main"):
        """What is seen; not the rows of the list of targets, which the browser draws when it has time."""
        return self.script("return document.querySelector(arguments[0])?.innerText ?? ''", selector)

    def test_a_program_is_opened_checked_and_started(self):
        self.open()
        self.station.answers = lambda order: self.station.say(with_job("checked", findings=[
            {"severity": "warning", "code": "tool-unused", "file": "panel.exc", "line": 3, "column": 1, "what": "T9 is not used", "expected": ""}]))
        self.press("open-panel.exc")
        self.arrived({"do": "open", "program": "panel.exc"})
        self.until("document.querySelector('#job').innerText.includes('T9 is not used')")
        self.assertEqual(self.page.count("#do-stop"), 0)
        self.station.answers = lambda order: self.station.say(measuring())
        self.press("start")
        self.until("document.getElementById('do-stop')")
        self.assertEqual(self.page.count("#do-start, #do-close, #do-open-panel\\.exc"), 0)
        self.assertEqual(self.page.count(".targets li"), 6)
        self.assertTrue(any("residual 3.6" in row for row in self.page.texts(".targets li")))
        self.assertIn("80", self.text(".bars"))
        self.station.answers = lambda order: self.station.say(with_job("stopped"))
        self.press("stop")
        self.press("close")
        self.arrived({"do": "open", "program": "panel.exc"}, {"do": "start"}, {"do": "stop"}, {"do": "close"})

    def test_a_program_with_errors_cannot_be_started(self):
        self.open(with_job("checked", findings=[{"severity": "error", "code": "x", "line": 3, "what": "no tool", "expected": "T1"}]))
        self.until("document.getElementById('do-close')")
        self.assertEqual(self.page.count("#do-start"), 0)

    def test_a_program_is_uploaded(self):
        self.open()
        path = Path(__file__).with_name("CMakeLists.txt")
        self.page.driver.find_element("id", "upload").send_keys(str(path))
        self.until(lambda: self.station.uploads)
        self.assertEqual(self.station.uploads, [("CMakeLists.txt", path.read_bytes())])

    def test_each_choice_answers_the_question_that_is_open(self):
        self.open(asking())
        expected = []
        for i, (choice, more) in enumerate((("again", {}), ("candidate", {"index": 1}), ("skip", {}), ("leave_board_out", {}), ("keep", {}), ("stop", {}))):
            self.station.say(asking(question_id=i))
            self.until("!document.body.classList.contains('busy')")
            self.page.settle()
            time.sleep(0.1)
            self.station.answers = lambda order: self.station.say(measuring())
            self.press(f"candidate-{more['index']}" if more else choice)
            expected.append({"do": "answer", "question": i, "choice": choice, **more})
            self.arrived(*expected)
            self.until("document.getElementById('question').hidden")

    def test_only_the_choices_that_are_offered_have_a_button_and_the_others_say_why(self):
        self.open(asking(choices=["again", "stop"], jog_mm=None, exposure_us=None, why_not={
            "skip": "a fit needs 3 targets", "jog": "pictures do not move", "lamp": "no lamp", "exposure": "no exposure to set"}))
        self.until("document.getElementById('do-again')")
        self.assertEqual(self.page.count("#aim-search, #aim-hand, #do-skip, #do-leave_board_out, #do-candidate-0, .jog, #question input"), 0)
        for said in ("a fit needs 3 targets", "no lamp", "no exposure to set"):
            self.assertIn(said, self.text("#question"))

    def test_what_a_person_has_to_do_is_told_and_done(self):
        question = {"id": 7, "reason": "lay entry material on the coupon", "candidates": [], "choices": ["done", "stop"], "why_not": {}}
        self.open(with_job("asking", question=question))
        self.until("document.getElementById('do-done')")
        self.assertIn("lay entry material on the coupon", self.text("#question h2"))
        self.assertNotIn("#", self.text("#question h2"))
        self.assertEqual(self.page.count("#do-again, #question input, .jog"), 0)
        self.press("done")
        self.arrived({"do": "answer", "question": 7, "choice": "done"})

    def test_a_session_is_ended_by_logging_out(self):
        self.open()
        self.assertEqual(self.page.count("#do-log-out"), 0)
        self.start_anew()
        self.station.token = "secret"
        self.page.open(self.station.address, quiet=False)
        self.until("document.getElementById('token')")
        self.script("document.getElementById('token').value = 'secret'; document.querySelector('.notice button').click()")
        self.take()
        self.press("log-out")
        self.until("document.getElementById('token')")
        self.assertEqual(self.script("return Object.keys(sessionStorage)"), [])
        self.page.driver.get_log("browser")

    def test_lamp_and_exposure_go_with_looking_again(self):
        self.open(asking())
        self.until("document.getElementById('light-lamp')")
        self.assertEqual(self.script("return document.getElementById('light-exposure').value"), "2000")
        self.script("document.getElementById('light-lamp').value = '55'; document.getElementById('light-exposure').value = '3000'")
        # What is typed stays when the state changes in between.
        self.station.say(asking(reason="rejected again"))
        self.until("document.querySelector('#question h2').textContent.includes('again')")
        self.press("again")
        self.arrived({"do": "answer", "question": 3, "choice": "again", "lamp": 55, "exposure": 3000})

    def test_a_click_says_where_to_search_in_px_of_the_picture_at_any_size(self):
        for width_px, factor in ((400, 1), (1280, 1), (1280, 2), (2560, 3)):
            with self.subTest(width_px=width_px, factor=factor):
                self.start_anew()
                self.station.picture = picture(DISC_PX)
                state = asking_without_search_window()
                # The picture of a large camera is sent smaller: a pixel of it has several of the camera.
                state["view"].update(width_px=factor * WIDTH_PX, height_px=factor * HEIGHT_PX)
                self.open(state, width_px)
                self.shown(3)
                # It means nothing until an aim is chosen.
                self.click_disc()
                self.arrived_at("search", [factor * (at + 0.5) - 0.5 for at in self.click_disc("aim-search")], factor=factor)

    def arrived_at(self, choice, at_px, frame=3, factor=1):
        self.until(lambda: self.station.orders)
        (order,) = self.station.orders
        self.assertEqual((order["do"], order["question"], order["choice"], order["frame"]), ("answer", 3, choice, frame))
        for got, wanted in zip(order["at_px"], at_px):
            self.assertAlmostEqual(got, wanted, delta=factor * CLICK_TOLERANCE_PX)

    def test_a_target_is_placed_by_hand_with_click_keys_and_enter(self):
        self.station.picture = picture(DISC_PX)
        self.open(asking_without_search_window())
        self.shown(3)
        x_px, y_px = self.click_disc("aim-hand")
        canvas = self.page.driver.find_element("id", "picture")
        for key in ("\ue014", "\ue014", "\ue015", "\ue007"):  # right, right, down, Enter
            canvas.send_keys(key)
        self.arrived_at("hand", [x_px + 0.5, y_px + 0.25])

    def test_escape_ends_aiming(self):
        self.open(asking())
        self.shown(3)
        self.script("document.getElementById('aim-search').click()")
        self.page.driver.find_element("id", "picture").send_keys("\ue00c")
        self.click_disc()
        self.station.answers = lambda order: self.station.say(measuring())
        self.press("skip")
        self.arrived({"do": "answer", "question": 3, "choice": "skip"})

    def test_a_place_comes_with_the_number_of_its_picture_so_that_an_older_one_can_be_refused(self):
        self.station.picture = picture(DISC_PX)
        self.open(asking_without_search_window())
        self.shown(3)
        self.station.refusal = {"what": "the picture is older than the last move", "expected": "a place of the picture shown now"}
        self.click_disc("aim-search")
        self.until("document.querySelector('.notice').innerText.includes('older than the last move')")
        self.station.refusal = None
        self.station.say(frame=9)
        self.shown(9)
        self.arrived_at("search", self.click_disc(), frame=9)

    def test_the_stage_is_jogged_by_buttons_and_arrow_keys(self):
        self.open(asking())
        self.station.answers = lambda order: self.station.say()
        self.until("document.getElementById('step-1')")
        self.script("document.getElementById('step-1').click()")
        self.press("jog-left")
        self.arrived({"do": "jog", "by_mm": [-1, 0]})
        self.until("!document.body.classList.contains('busy')")
        self.page.driver.find_element("id", "picture").send_keys("\ue013")  # up
        self.arrived({"do": "jog", "by_mm": [-1, 0]}, {"do": "jog", "by_mm": [0, 1]})

    def test_a_second_press_sends_nothing_before_the_next_state(self):
        self.open(asking())
        self.until("document.getElementById('do-skip')")
        self.script("document.getElementById('do-skip').click(); document.getElementById('do-skip').click();"
                    "document.getElementById('do-stop').click()")
        self.until("document.body.classList.contains('busy')")
        time.sleep(0.5)
        self.arrived({"do": "answer", "question": 3, "choice": "skip"})
        self.station.say(measuring())
        self.until("!document.body.classList.contains('busy')")

    def test_what_is_refused_says_why(self):
        self.open(asking())
        self.station.refusal = {"what": "the question is closed: 3", "expected": "an answer to question 4"}
        self.press("skip")
        self.until("document.querySelector('.notice').innerText.includes('an answer to question 4')")

    def test_a_reload_in_the_middle_keeps_job_and_controls(self):
        self.open(asking())
        self.until("document.getElementById('do-skip')")
        before = self.page.texts("#targets, #question")
        self.page.driver.refresh()
        self.until("document.getElementById('do-skip')")
        self.page.settle()
        self.assertEqual(self.page.texts("#targets, #question"), before)
        self.assertEqual(self.script("return [Object.keys(sessionStorage), Object.keys(localStorage), document.cookie]"),
                         [["panelcal-controls"], [], ""])

    def test_a_second_screen_shows_everything_and_commands_nothing(self):
        self.station.held_by, self.station.key = "Berta", "key-of-another"
        self.open(asking(), take=False)
        self.until("document.querySelector('#question').innerText.length > 5")
        self.until("document.querySelector('header').innerText.includes('Berta')")
        self.assertIn("size 1.9 mm", self.text("#question"))
        self.assertEqual(self.page.texts(".action"), ["Take them over from Berta"])
        self.shown(3)
        self.page.driver.find_element("id", "picture").send_keys("\ue013")
        self.click_disc()
        time.sleep(0.2)
        self.assertEqual(self.station.orders, [])
        # Another screen takes the controls from this one.
        self.take()
        self.station.held_by, self.station.key = "Carla", "key-of-a-third"
        self.station.say()
        self.until("document.querySelector('header').innerText.includes('Carla')")
        self.assertEqual(self.page.count("#do-skip"), 0)

    def test_a_lost_connection_is_said_and_the_way_back_is_found(self):
        self.open(asking())
        self.shown(3)
        self.station.cut_off(True)
        self.until("document.body.classList.contains('lost')")
        self.assertIn("No connection", self.text(".notice"))
        self.assertGreaterEqual(self.script("return parseFloat(getComputedStyle(document.querySelector('.notice h2')).fontSize)"), 30)
        self.script("document.getElementById('do-skip').click()")
        time.sleep(0.2)
        self.assertEqual(self.station.orders, [])
        self.station.state = measuring()
        self.station.cut_off(False)
        self.until("!document.body.classList.contains('lost')")
        self.until("document.getElementById('do-stop')")

    def test_a_token_is_asked_for_where_one_is_needed(self):
        self.station.token = "secret"
        self.page.open(self.station.address, quiet=False)
        self.until("document.getElementById('token')")
        self.assertEqual(self.script("return [...document.querySelectorAll('.desk > div > *')].filter((one) => one.offsetHeight).length"), 0)
        for token, said in (("wrong", "wrong token"), ("secret", "Posalux 5")):
            self.script("document.getElementById('token').value = arguments[0]; document.querySelector('.notice button').click()", token)
            self.until("document.querySelector('main').innerText.includes(arguments[0])", said)
        self.page.driver.get_log("browser")

    def test_of_a_thousand_targets_only_the_row_that_changes_is_made_anew(self):
        def state(n_found):
            targets = [found(seq) if seq < n_found else target(seq) for seq in range(1000)]
            return with_job("measuring", targets=targets)

        self.open(state(500))
        self.until("document.querySelectorAll('.targets li').length === 1000")
        self.script("for (const row of document.querySelectorAll('.targets li')) row.dataset.old = 1;"
                    "document.querySelector('.targets').scrollTop = 5000")
        self.station.say(state(501))
        self.until("document.querySelectorAll('.targets .found').length === 501")
        self.assertEqual(self.page.texts(".targets li:not([data-old]) b"), ["#500"])
        # Who reads the list keeps the place.
        self.assertEqual(self.script("return document.querySelector('.targets').scrollTop"), 5000)
        # The next one that is looked for is scrolled to, and the page stays where it is.
        looking = state(501)
        looking["job"]["targets"][700]["status"] = "looking"
        self.station.say(looking)
        self.until("document.querySelector('.targets .looking')")
        row, box = self.script("""return [".targets .looking", ".targets"].map((one) => {
          const {top, bottom} = document.querySelector(one).getBoundingClientRect(); return [top, bottom]; })""")
        self.assertTrue(box[0] <= row[0] and row[1] <= box[1], (row, box))
        self.assertEqual(self.script("return scrollY"), 0)

    def test_the_verdict_and_the_program_that_is_written(self):
        self.open(done())
        self.until("document.getElementById('output-name')")
        self.assertIn("DRILL", self.text("#verdict"))
        self.assertTrue(self.script("return document.querySelector('#verdict a').href").endswith("/api/jobs/2026-11-27-1/report.html?language=en"))
        self.script("document.getElementById('output-name').value = 'out.drl'")
        self.station.answers = lambda order: self.station.say(with_job("done", outputs=["out.drl"], verdict=done()["job"]["verdict"]))
        self.press("write")
        self.arrived({"do": "write", "name": "out.drl"})
        self.until("document.querySelector('#verdict').innerText.includes('out.drl')")
        self.station.say(done(may_drill=False))
        self.until("document.querySelector('#verdict').innerText.includes('HOLD')")
        self.assertEqual(self.page.count("#output-name"), 0)
        # A hold is not told by colour alone.
        self.assertIn("\u2717", self.text("#verdict"))

    def test_a_night_is_started_and_watched(self):
        self.open()
        state = idle()
        state["calibration"] = {"kind": "night", "state": "running", "lines": ["warm-up: 3 min", "camera: 21 marks"], "has_page": False}
        self.station.answers = lambda order: self.station.say(state)
        # What machine.toml has everything for can be measured alone.
        self.until("document.getElementById('do-calibrate-camera')")
        self.press("calibrate-night")
        self.arrived({"do": "calibrate", "kind": "night"})
        self.until("document.querySelector('#calibration').innerText.includes('camera: 21 marks')")
        self.assertEqual(self.page.count("#do-calibrate-night, #history details"), 0)
        self.assertEqual(self.page.count("#do-calibrate-table"), 0)
        self.press("stop-calibration")
        self.arrived({"do": "calibrate", "kind": "night"}, {"do": "stop"})
        finished = copy.deepcopy(state)
        finished["calibration"].update(state="done", verdict="may drill", has_page=True)
        self.station.say(finished)
        self.until("document.querySelector('#calibration a')")

    def test_a_calibration_is_rolled_back_with_a_reason(self):
        self.open()
        self.until("document.querySelector('#history details')")
        self.script("document.querySelector('#history details').open = true; document.querySelector('#history form button').click()")
        time.sleep(0.2)
        self.assertEqual(self.station.orders, [], "it went without a reason")
        self.script("document.querySelector('#history textarea').value = 'lamp was dirty'; document.querySelector('#history form button').click()")
        self.arrived({"do": "roll_back", "kind": "camera", "to": "9", "reason": "lamp was dirty"})

    def test_200_hostile_names_run_nothing(self):
        keep = {"facts", "severity", "state", "status", "by", "when", "choices", "command"}
        for state in (idle(), with_job("checked", findings=[{"severity": "error", "code": "x", "line": 3, "what": "w", "expected": "e"}]), asking(), done()):
            state["programs"] = [{"name": f"{i}{browser.HOSTILE}", "size_bytes": i} for i in range(200)]
            self.station.held_by = browser.HOSTILE
            hostile = browser.hostile(state, keep)
            hostile["machine"] = "Posalux 5"
            self.open(hostile, take=False)
            self.page.settle()
            self.assertIsNone(self.script("return window.injected ?? null"))
            self.assertEqual(self.script("return [document.querySelectorAll('img, iframe, object').length, document.scripts.length]"), [0, 1])
            self.assertIn("<script>window.injected=1", self.text())
            self.assertNotIn("\u202e", self.text())
            self.assertEqual(self.page.cut_off(), [])

    def test_the_policy_refuses_a_script_of_the_page(self):
        self.open(take=False)
        self.script("const s = document.createElement('script'); s.textContent = 'window.injected = 1'; document.body.append(s);")
        self.assertIsNone(self.script("return window.injected ?? null"))
        self.page.driver.get_log("browser")

    def test_english_and_german_and_what_the_machine_says_is_marked_as_english(self):
        self.open(asking(why_not={"skip": "a fit needs 3 targets"}))
        self.until("document.getElementById('do-again')")
        self.assertIn("Look again", self.text())
        self.script("document.getElementById('language').click()")
        self.assertIn("Noch einmal suchen", self.text())
        self.assertNotIn("Look again", self.text())
        for said in ("simulated machine", "size 1.9 mm", "a fit needs 3 targets", "scale 10.002"):
            self.assertTrue(self.script("return [...document.querySelectorAll('[lang=en]')].some((one) => one.textContent.includes(arguments[0]))", said), said)

    def test_a_question_is_announced(self):
        self.open(measuring())
        self.station.say(asking())
        self.until("document.querySelector('#question [role=alert]')?.textContent.includes('size 1.9 mm')")

    def test_nothing_overflows_at_any_width_and_what_is_pressed_is_large(self):
        for width_px in browser.WIDTHS:
            for dark in (False, True):
                for state in (idle(), with_job("checked"), measuring(), asking(), done()):
                    with self.subTest(width_px=width_px, state=state["job"] and state["job"]["state"]):
                        self.start_anew()
                        self.open(state, width_px, dark=dark)
                        self.page.settle()
                        self.assertEqual(self.page.cut_off(), [])
                        self.assertLessEqual(self.script("return document.documentElement.scrollWidth"), width_px)
                        small = self.script("""return [...document.querySelectorAll("button, input, textarea, summary")].filter((one) => {
                          const box = one.getBoundingClientRect(); return box.width && (box.height < 44 || box.width < 44); })
                          .map((one) => one.outerHTML.slice(0, 80))""")
                        self.assertEqual(small, [])
                        self.assertEqual(self.page.driver.get_log("browser"), [])


if __name__ == "__main__":
    unittest.main()
