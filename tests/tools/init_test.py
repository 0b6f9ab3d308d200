#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`panelcal init`: files that every command takes, and that replace none.

    init_test.py PANELCAL ROOT
"""
import os
import pty
import select
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

KINDS = ("usb-camera-linuxcnc", "usb-camera-grbl", "gige-cnc7", "folder")


class Init(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def run_it(self, *words, code=0):
        done = subprocess.run([PANELCAL, *map(str, words)], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True,
                              text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def files(self):
        return sorted(path.name for path in self.folder.iterdir())

    def test_every_kind_is_sound_at_once(self):
        for kind in KINDS:
            with self.subTest(kind=kind):
                self.run_it("init", "--template", kind, "--name", kind)
                self.assertEqual(self.files(), ["camera.cal.json", "machine.toml"])
                self.assertIn("machine.toml: no errors", self.run_it("check", "-m", "machine.toml"))
                self.assertIn("assumed", (self.folder / "machine.toml").read_text())
                for name in self.files():
                    (self.folder / name).unlink()

    def test_the_demo_is_drilled_with_its_own_camera_and_held_with_an_assumed_one(self):
        demo = ROOT / "datasets/demo"
        job = ("run", demo / "panel.exc", "-m", "machine.toml", "--images", demo / "images", "-o", "out.drl")
        words = ("--template", "folder", "--fiducial-mm", "2,1")
        shutil.copy(demo / "camera.cal.json", self.folder / "demo.cal.json")
        self.run_it("init", *words, "demo.cal.json")
        self.assertIn("990 holes", self.run_it(*job))
        (self.folder / "out.drl").unlink()
        (self.folder / "machine.toml").unlink()
        self.run_it("init", *words, "--picture-px", "480,480", "--um-per-px", 10)
        said = self.run_it(*job, code=1)
        self.assertIn("tolerance-hold", said)
        self.assertNotIn("out.drl", self.files())

    def test_nothing_is_replaced_and_nothing_half_written(self):
        for name in ("machine.toml", "camera.cal.json"):
            (self.folder / name).write_text("mine")
            self.assertIn("output-in-use", self.run_it("init", "--template", "folder", code=2))
            self.assertEqual(self.files(), [name])
            self.assertEqual((self.folder / name).read_text(), "mine")
            (self.folder / name).unlink()
        self.assertIn("none.cal.json", self.run_it("init", "--template", "folder", "none.cal.json", code=2))
        self.assertIn("travel", self.run_it("init", "--template", "folder", "--travel-mm", "10,0,0,10", code=2))
        self.run_it("init", "--template", "folder", "-o", "machine.txt", code=2)
        self.run_it("init", "--template", "folder", "-o", "no/machine.toml", code=3)
        self.assertEqual(self.files(), [])

    def test_without_a_person_the_kind_has_to_be_said(self):
        said = self.run_it("init", code=2)
        for kind in KINDS:
            self.assertIn(kind, said)
        self.assertEqual(self.files(), [])

    def test_a_person_is_asked(self):
        mine, terminal = pty.openpty()
        process = subprocess.Popen([PANELCAL, "init"], cwd=self.folder, stdin=terminal, stdout=terminal, stderr=terminal)
        os.close(terminal)
        said = ""
        for question, answer in (("Kind of machine", "folder"), ("Name of the machine", "bench 7")):
            while question not in said:
                self.assertTrue(select.select([mine], [], [], 120)[0], said)
                said += os.read(mine, 4096).decode()
            os.write(mine, answer.encode() + b"\n")
        self.assertEqual(process.wait(timeout=120), 0, said)
        os.close(mine)
        self.assertIn('name = "bench 7"', (self.folder / "machine.toml").read_text())


if __name__ == "__main__":
    ROOT = Path(sys.argv.pop()).resolve()
    PANELCAL = str(Path(sys.argv.pop()).resolve())
    unittest.main()
