#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`panelcal doctor`: the same findings as text and as facts, and nothing written.

    doctor_test.py PANELCAL ROOT
"""
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import real_files

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from facts import checked  # noqa: E402
from json_schema import is_closed  # noqa: E402


class Doctor(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def examine(self, *words, code):
        done = subprocess.run([PANELCAL, "doctor", *map(str, words)], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout if code < 2 else done.stderr

    def test_text_and_facts_are_the_same(self):
        self.assertTrue(is_closed(json.loads((ROOT / "share/schema/doctor.schema.json").read_text())))
        said = self.examine("-m", ROOT / "datasets/demo/machine.toml", "--json", "doctor.json", code=0)
        document = checked(json.loads((self.folder / "doctor.json").read_text()), ROOT)
        self.assertTrue(document["is_ready"])
        *lines, last = said.splitlines()
        for line, finding in zip(lines, document["findings"], strict=True):
            for value in finding.values():
                self.assertIn(value, line)
        self.assertEqual(last, f"ready: 0 failing, {document['n_warnings']} warning"
                         + ("" if document["n_warnings"] == 1 else "s"))
        alone = json.loads(self.examine("-m", ROOT / "datasets/demo/machine.toml", "--json", "-", code=0))
        self.assertEqual(alone["findings"], document["findings"])

    def test_a_new_machine_is_told_what_to_measure(self):
        subprocess.run([PANELCAL, "init", "--template", "usb-camera-grbl", "--device", "/dev/no-tty"], cwd=self.folder,
                       check=True, capture_output=True)
        said = self.examine("-m", "machine.toml", "--camera", "v4l2:/dev/no-camera", code=1)
        text = (self.folder / "machine.toml").read_text()
        assumed = [line for line in text.splitlines() if "# assumed; " in line]
        self.assertGreater(len(assumed), 5)
        self.assertEqual(said.count(" is assumed, not measured; "), len(assumed))
        for word in ("every job is held", "/dev/no-tty", "/dev/no-camera", "not ready: "):
            self.assertIn(word, said)

    def test_a_machine_file_that_is_wrong_is_a_finding_and_one_that_is_missing_is_not(self):
        self.assertIn("file-unreadable", self.examine("-m", "machine.toml", code=2))
        (self.folder / "machine.toml").write_text("[machine]\nnam = 1\n")
        said = self.examine("-m", "machine.toml", code=1)
        self.assertIn("machine.toml:2:", said)
        self.assertIn("not ready: 1 failing, 0 warnings", said)

    def test_the_night_is_foreseen_and_nothing_written(self):
        real_files.make(PANELCAL, ROOT, self.folder)
        toml = self.folder / "machine.toml"
        toml.write_text(toml.read_text().replace("rows = 300", "rows = 150"))
        before = {path: path.stat().st_mtime_ns for path in self.folder.rglob("*")}
        said = self.examine("-m", "machine.toml", "--clock", "2026-11-22T02:00:00Z", code=0)
        self.assertIn("tonight spindle-camera spindle 1 station 1: would be measured", said)
        self.assertRegex(said, r"ledger: .*drill1.ledger: \d+ entries, all hashes right")
        self.assertEqual({path: path.stat().st_mtime_ns for path in self.folder.rglob("*")}, before)
        # Old calibrations warn, a clock that is behind the ledger's entries holds the night.
        self.assertIn("calibration-old", self.examine("-m", "machine.toml", "--clock", "2027-03-01T02:00:00Z", code=0))
        self.assertIn("fails     tonight", self.examine("-m", "machine.toml", "--clock", "2026-11-20T12:30:00Z", code=1))
        ledger = self.folder / "drill1.ledger"
        whole = ledger.read_bytes()
        ledger.write_bytes(whole[:-5000] + bytes(5000))
        self.assertIn("fails     ledger: ", self.examine("-m", "machine.toml", "--clock", "2026-11-22T02:00:00Z", code=1))


if __name__ == "__main__":
    ROOT = Path(sys.argv.pop()).resolve()
    PANELCAL = str(Path(sys.argv.pop()).resolve())
    unittest.main()
