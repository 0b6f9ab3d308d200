#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Files that earlier versions wrote are read, and those of newer versions refused by their number (docs/upgrade.md).

    kept_versions_test.py PANELCAL REPOSITORY [UNITTEST OPTIONS]
"""
import json
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

CLOCK = "2026-11-22T02:00:00"
NEWER = 99
RUN = ("run", "job.exc", "-m", "machine.toml", "--measurements", "measurements.jsonl", "--surface", "map.json", "--truth",
       "truth.json", "--clock", CLOCK, "-o", "written.jsonl")
# Each kind of file that states a version, with a command that reads it.
READERS = {
    "board.align.json": ("align", "show", "board.align.json", "-m", "machine.toml"),
    "camera.cal.json": RUN,
    "coupon.json": ("nightly", "-m", "machine.toml", "--dry-run", "--clock", CLOCK + "Z"),
    "drill1.ledger": ("history", "list", "-l", "drill1.ledger"),
    "map.json": ("surface", "query", "map.json", "10,10"),
    "results/store.sqlite": ("batch", "show", "results"),
    "spindle.cal.json": RUN,
    "truth.json": RUN,
}
# What a version wrote that has no number: docs/upgrade.md says why.
UNNUMBERED = {"images/0000.png", "images/images.csv", "job.exc", "machine.toml", "measurements.jsonl", "out.jsonl", "patt.exc",
              "probes.jsonl", "temperature.txt"}


def drilled(path):
    """Where holes are drilled."""
    operations = [json.loads(line) for line in path.read_text().splitlines()]
    return [operation["actual"] for operation in operations if operation["op"] == "drill"]


def set_version(path, version):
    if path.suffix == ".json":
        text, n = re.subn(r'("version"\s*:\s*)\d+', rf"\g<1>{version}", path.read_text(), count=1)
        assert n == 1, path
        path.write_text(text)
        return
    database = sqlite3.connect(path)
    database.execute(f"PRAGMA user_version = {version}")
    database.close()


class KeptVersions(unittest.TestCase):
    panelcal = root = None

    def setUp(self):
        self.versions = sorted(path for path in (self.root / "tests/golden/versions").iterdir() if path.is_dir())
        self.assertGreater(len(self.versions), 0)

    def folder_of(self, version):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        return Path(shutil.copytree(version, Path(temporary.name) / "files"))

    def call(self, folder, words):
        return subprocess.run([self.panelcal, *words], cwd=folder, capture_output=True, text=True, check=False)

    def test_every_kept_file_has_a_reader_or_a_reason(self):
        for version in self.versions:
            names = {str(path.relative_to(version)) for path in version.rglob("*") if path.is_file()}
            self.assertEqual(names, set(READERS) | UNNUMBERED)

    def test_files_of_earlier_versions_are_read(self):
        for version in self.versions:
            folder = self.folder_of(version)
            answers = {}
            for name, words in READERS.items():
                done = self.call(folder, words)
                # An alignment ages: whether it is in force is no matter here, but what it says.
                if name != "board.align.json":
                    self.assertEqual(done.returncode, 0, (version, name, done.stderr))
                answers[name] = done.stdout
            self.assertIn("installed: all gates passed", answers["drill1.ledger"])
            self.assertIn("pads: 1 pad", answers["board.align.json"])
            self.assertIn("1 drilled, 0 held, 0 failed", answers["results/store.sqlite"])
            kept, now = drilled(folder / "out.jsonl"), drilled(folder / "written.jsonl")
            self.assertGreater(len(kept), 0)
            self.assertEqual(len(now), len(kept))
            for one, other in zip(kept, now):
                # A thousandth of a micrometre: no reading of a file may move a hole.
                self.assertLess(max(abs(one[0] - other[0]), abs(one[1] - other[1])), 1e-6)

    def test_files_of_newer_versions_are_refused_by_both_numbers(self):
        for version in self.versions:
            for name, words in READERS.items():
                folder = self.folder_of(version)
                set_version(folder / name, NEWER)
                before = (folder / name).read_bytes()
                done = self.call(folder, words)
                self.assertEqual(done.returncode, 2, (name, done.stdout, done.stderr))
                self.assertEqual(done.stdout, "", name)
                self.assertRegex(done.stderr, rf"{NEWER}\b.*expected .*\b[12]\b", name)
                if name.endswith(".json"):
                    # Whatever else a newer version may have in it.
                    text = (folder / name).read_text()
                    (folder / name).write_text(text.replace("{", '{"unheard_of": 1, ', 1))
                    again = self.call(folder, words)
                    self.assertEqual((again.returncode, again.stderr), (2, done.stderr))
                    (folder / name).write_text(text)
                self.assertIn("ersion", done.stderr, name)
                self.assertEqual((folder / name).read_bytes(), before, name)


if __name__ == "__main__":
    KeptVersions.panelcal, KeptVersions.root = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
