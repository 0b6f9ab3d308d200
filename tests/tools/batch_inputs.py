# SPDX-License-Identifier: Apache-2.0
"""Inputs of `panelcal batch`, its results, and the results of a batch that nothing disturbed."""
import json
import os
import shutil
import sqlite3
import subprocess
import tempfile
import unittest
from pathlib import Path

# ThreadSanitizer ends with this; it is told not to watch libraries that were built without it.
RACE = 66
CLOCK = "2026-11-27T12:00:00"
HEAD = "id,program,machine,images,measurements,truth,noise"
TABLES = ("job", "target", "fit", "hole_summary", "diagnostic", "picture_quality")
N_JOBS = 30


def stored(folder):
    """All rows that do not say when or how fast."""
    with sqlite3.connect(f"file:{folder / 'store.sqlite'}?mode=ro", uri=True) as store:
        rows = {table: store.execute(f"SELECT * FROM {table} ORDER BY 1, 2").fetchall() for table in TABLES}
        rows["batch"] = store.execute("SELECT * FROM batch").fetchall()
    store.close()
    return rows


def files(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted((folder / "jobs").rglob("*"))
            if path.is_file()}


class BatchCase(unittest.TestCase):
    panelcal = root = None

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.inputs = Path(cls.temporary.name) / "inputs"
        cls.inputs.mkdir()
        demo = cls.root / "datasets/demo"
        for name in ("panel.exc", "machine.toml", "camera.cal.json"):
            shutil.copy(demo / name, cls.inputs / name)
        cls.call_in(cls.inputs, "synth", "panel.exc", "-m", "machine.toml", "-o", "images", "--seed", 7)
        cls.call_in(cls.inputs, "run", "panel.exc", "-m", "machine.toml", "--images", "images", "-o", "run.drl",
                    "--save-measurements", "good.jsonl", "--clock", CLOCK)
        lines = (cls.inputs / "good.jsonl").read_text().splitlines(keepends=True)
        # One target lies elsewhere by 0.1 mm.
        moved = json.loads(lines[4])
        moved["measured"][0] += 0.1
        (cls.inputs / "moved.jsonl").write_text("".join([*lines[:4], json.dumps(moved) + "\n", *lines[5:]]))
        rows = [HEAD, "pictures,panel.exc,machine.toml,images,,images/truth.json,0"]
        for i in range(1, N_JOBS - 2):
            rows.append(f"job-{i:02},panel.exc,machine.toml,,good.jsonl,images/truth.json,{i % 3}")
        rows += ["held,panel.exc,machine.toml,,moved.jsonl,,1", "fails,none.exc,machine.toml,,good.jsonl,,1"]
        (cls.inputs / "jobs.csv").write_text("\n".join(rows) + "\n")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def call_in(cls, folder, *words, expect=0, **more):
        environment = dict(os.environ, TSAN_OPTIONS=f"exitcode={RACE} ignore_noninstrumented_modules=1")
        done = subprocess.run([cls.panelcal, *map(str, words)], cwd=folder, env=environment, capture_output=True,
                              text=True, check=False, **more)
        assert done.returncode == expect, (words, done.returncode, done.stderr)
        return done

    def folder(self):
        """A folder with all inputs, whose names are then the same in every one."""
        folder = Path(tempfile.mkdtemp(dir=self.temporary.name))
        for path in self.inputs.iterdir():
            (folder / path.name).symlink_to(path)
        return folder

    def batch(self, folder, *words, expect=2, **more):
        return self.call_in(folder, "batch", "jobs.csv", "-o", "out", "--clock", CLOCK, *words, expect=expect, **more)

    def whole(self):
        """The results of a batch that nothing disturbed."""
        if not hasattr(BatchCase, "undisturbed"):
            folder = self.folder()
            self.batch(folder, "--threads", 1)
            BatchCase.undisturbed = folder / "out"
        return BatchCase.undisturbed
