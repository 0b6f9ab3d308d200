#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A person sets up the demo's job with the real program: opens it, is asked about a target, reloads, has a colleague who
looks on, and writes the program that `run` writes as well. A screen without the token sees nothing.

    operated_job_test.py PANELCAL REPOSITORY
"""
import json
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import urllib.request
import zlib
from pathlib import Path

import browser

browser.skip_without_browser()
PANELCAL, REPOSITORY = (Path(word).resolve() for word in sys.argv[1:3])
COVERED = "0009.png"


def grey_png(size_px=480, level=60):
    """A picture in which there is nothing."""
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    rows = (b"\0" + bytes([level]) * size_px) * size_px
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size_px, size_px, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def blocks(program):
    """The lines that move the machine: comments say who made a program, and when."""
    return [line for line in program.splitlines() if not line.startswith(";")]


class Served(unittest.TestCase):
    """The real server on the demo's files, and a browser."""
    source = ("--images", "images")

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        demo = REPOSITORY / "datasets/demo"
        for name in ("machine.toml", "camera.cal.json", "panel.exc", "board.drl"):
            shutil.copy(demo / name, self.folder)
        shutil.copytree(demo / "images", self.folder / "images")
        programs = self.folder / "jobs/programs"
        programs.mkdir(parents=True)
        for name in ("panel.exc", "board.drl"):
            shutil.copy(demo / name, programs)
        self.page = browser.Browser()
        self.addCleanup(self.page.close)

    def serve(self, *words):
        self.server = subprocess.Popen(
            [PANELCAL, "serve", "-m", "machine.toml", *self.source, "--address", "127.0.0.1:0", *words],
            cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(self.server.stdout.close)
        self.addCleanup(self.server.wait)
        self.addCleanup(self.server.kill)
        said = ""
        while not (found := re.search(r"http://127\.0\.0\.1:\d+/", said)):
            line = self.server.stdout.readline()
            self.assertTrue(line, said)
            said += line
        return found.group()

    def until(self, expression):
        self.page.until(expression)

    def press(self, name):
        self.until(f"document.getElementById('{name}') && !document.body.classList.contains('busy')")
        self.page.run("document.getElementById(arguments[0]).click()", name)

    def take(self, name):
        self.until("document.getElementById('name')")
        self.page.run("document.getElementById('name').value = arguments[0]", name)
        self.press("do-take")
        self.until("document.getElementById('do-give')")

    def ask(self, address, name):
        with urllib.request.urlopen(address + name) as answer:
            return answer.read().decode()


class OperatedJob(Served):
    def test_a_job_is_set_up_with_a_target_that_is_not_seen_at_first(self):
        kept = (self.folder / "images" / COVERED).read_bytes()
        (self.folder / "images" / COVERED).write_bytes(grey_png())
        address = self.serve()
        self.page.open(address)
        self.take("Anna")
        self.press("do-open-panel.exc")
        self.press("do-start")
        self.until("document.getElementById('do-again')")
        for width_px in browser.WIDTHS:
            self.page.resize(width_px)
            self.assertEqual(self.page.cut_off(), [])
        self.page.driver.refresh()
        self.until("document.getElementById('do-again')")

        # A colleague looks on in a window of his own.
        first = self.page.driver.current_window_handle
        self.page.driver.switch_to.new_window("window")
        self.page.open(address)
        self.until("document.querySelector('#question')?.textContent.includes('nothing like the target')")
        self.assertEqual(self.page.count("#do-again, #do-stop"), 0)
        self.page.driver.close()
        self.page.driver.switch_to.window(first)

        self.press("do-again")
        self.until("document.getElementById('question').textContent.includes('nothing like the target')")
        (self.folder / "images" / COVERED).write_bytes(kept)
        self.press("do-again")
        self.press("do-write")
        self.until("[...document.querySelectorAll('a')].some((one) => one.textContent === 'panel.drl')")

        job = json.loads(self.ask(address, "api/state"))["job"]
        self.assertEqual((job["state"], job["n_holes"], job["verdict"]["may_drill"]), ("done", 990, True))
        written = self.ask(address, f"api/jobs/{job['id']}/output")
        subprocess.run([PANELCAL, "run", "panel.exc", "-m", "machine.toml", "--images", "images", "-o", "alone.drl"],
                       cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(blocks(written), blocks((self.folder / "alone.drl").read_text()))
        choices = (self.folder / "jobs" / job["id"] / "choices.jsonl").read_text()
        self.assertIn('"Anna"', choices)
        self.assertIn("looked at again", choices)

    def test_without_the_token_a_screen_sees_nothing(self):
        address = self.serve("--token-file", "token")
        self.page.open(address, quiet=False)
        self.until("document.getElementById('token')")
        self.page.run("document.getElementById('token').value = 'wrong'; document.querySelector('.notice button').click()")
        self.until("document.body.innerText.includes('token')")
        self.assertNotIn("panel.exc", self.page.run("return document.body.innerText"))
        with self.assertRaises(urllib.error.HTTPError) as refused:
            self.ask(address, "api/state")
        self.assertEqual(refused.exception.code, 401)
        refused.exception.close()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
