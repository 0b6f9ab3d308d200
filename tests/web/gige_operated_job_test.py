#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A person sets up the demo's job at a machine: a GigE Vision camera over the real protocol, and a stage that is driven
by commands. A wrong token, a target that is covered, a reload, a second screen, a wrong place by hand, a board left out.

    gige_operated_job_test.py PANELCAL REPOSITORY FAKE_PANEL_CAMERA
"""
import json
import subprocess
import sys
import unittest
from pathlib import Path

import operated_job_test as operated

sys.path.insert(0, str(operated.REPOSITORY / "tests/machine"))
import gige_job_test as gige  # noqa: E402

FAKE = Path(sys.argv[3]).resolve()
COVERED_SEQ = 9  # the first target of the third board
EXPOSURE_US = 2000


class OperatedCamera(operated.Served):
    source = ("--camera", f"gige://{gige.ADDRESS}?exposure_us={EXPOSURE_US}")

    def setUp(self):
        super().setUp()
        machine = (self.folder / "machine.toml").read_text()
        (self.folder / "machine.toml").write_text(machine.replace("[machine]\n", "[machine]\n" + gige.STAGE, 1))
        (self.folder / "images" / f"{COVERED_SEQ:04}.png").write_bytes(operated.grey_png())

    def question(self):
        return self.page.run("return document.getElementById('question').textContent")

    def told(self, path):
        """What the server says to this browser."""
        return self.page.driver.execute_async_script(
            "const done = arguments[1]; fetch(arguments[0]).then((one) => one.text()).then(done)", path)

    def log_in(self):
        self.until("document.getElementById('token')")
        for token in ("wrong", self.server.stdout.readline().split()[1]):
            self.assertNotIn("panel.exc", self.page.run("return document.body.innerText"))
            self.page.run("document.getElementById('token').value = arguments[0];"
                          "document.querySelector('.notice button').click()", token)
            self.until("document.body.innerText.includes('wrong token') || document.getElementById('name')")
        self.until("document.getElementById('name')")

    def look_on(self, address):
        """A colleague, who may press nothing."""
        first = self.page.driver.current_window_handle
        self.page.driver.switch_to.new_window("window")
        self.page.open(address, quiet=False)
        self.until("document.querySelector('#question')?.textContent.includes('#')")
        self.assertEqual(self.page.count("#do-again, #do-stop, #do-leave_board_out"), 0)
        self.until("document.getElementById('picture').width > 100")
        self.page.driver.close()
        self.page.driver.switch_to.window(first)

    def test_a_board_whose_fiducial_is_covered_is_left_out(self):
        with gige.camera(FAKE, self.folder / "images", self.folder):
            address = self.serve("--token-file", "token")
            self.page.open(address, quiet=False)
            self.log_in()
            self.take("Anna")
            self.press("do-open-panel.exc")
            self.press("do-start")
            self.until("document.getElementById('do-again')")
            self.page.driver.refresh()
            self.until("document.getElementById('do-again')")
            self.assertIn(f"#{COVERED_SEQ}", self.question())
            self.look_on(address)

            # The camera's exposure is in force, and another one is for one look.
            self.assertEqual(self.page.run("return document.getElementById('light-exposure').value"), str(EXPOSURE_US))
            self.page.run("document.getElementById('light-exposure').value = 4000")
            self.press("do-again")
            self.until("document.getElementById('do-jog-up') && !document.body.classList.contains('busy')")
            frame = int(self.page.run("return document.getElementById('picture').dataset.frame"))
            self.press("do-jog-up")
            # A place in a picture from before the movement is refused.
            self.until(f"document.getElementById('picture').dataset.frame > {frame + 3}")

            # In the middle of the picture it is not: the two others of its board contradict it.
            self.press("aim-hand")
            self.press("do-place")
            self.until("document.getElementById('do-keep')")
            self.press("do-leave_board_out")
            self.press("do-write")
            self.until("[...document.querySelectorAll('a')].some((one) => one.textContent === 'panel.drl')")
            job = json.loads(self.told("api/state"))["job"]
            self.assertEqual((job["state"], job["n_holes"]), ("done", 990 * 5 // 6), job["verdict"])
            self.assertIn("panel.drl", job["verdict"]["words"])
            written = self.told(f"api/jobs/{job['id']}/output")
            self.assertIn("exposure 4000 us", written)
            self.assertIn("its board left out", written)
            (self.folder / "measured.jsonl").write_text(self.told(f"api/jobs/{job['id']}/measurements.jsonl"))
            self.press("do-log-out")
            self.until("document.getElementById('token')")
        subprocess.run([operated.PANELCAL, "run", "panel.exc", "-m", "machine.toml", "--measurements", "measured.jsonl",
                        "-o", "alone.drl"], cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(operated.blocks(written), operated.blocks((self.folder / "alone.drl").read_text()))


if __name__ == "__main__":
    gige.enter_own_network()
    if gige.os.environ.get("PANELCAL_OWN_NETWORK"):
        gige.bring_up_loopback()
    unittest.main(argv=sys.argv[:1])
