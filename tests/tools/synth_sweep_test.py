#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`panelcal synth --sweep`: a test set as a designed experiment, the same whatever the threads and the kills, for `batch`.

    synth_sweep_test.py PANELCAL REPOSITORY [UNITTEST OPTIONS]
"""
import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

RACE = 66
SEED = 20261128
N_POINTS = 16
PROGRAM = """M48
METRIC,TZ
VER,1
T1C0.700
%
G90
G34,1
G36X6.000Y6.000
G36X224.000Y6.000
G36X6.000Y269.000
T1
X26.970Y17.080
M30
"""
SWEEP = f"""machine = "machine.toml"
program = "panel.exc"
design = "sobol"
points = {N_POINTS}
seed = {SEED}

[[factor]]
key = "noise"
values = [1, 15]

[[factor]]
key = "panel_offset_mm.x"
from = -0.5
to = 0.5
"""


def files(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


class Sweep(unittest.TestCase):
    panelcal = root = None

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        demo = self.root / "datasets/demo"
        shutil.copy(demo / "camera.cal.json", self.folder)
        shutil.copy(demo / "machine.toml", self.folder)
        (self.folder / "panel.exc").write_text(PROGRAM)
        (self.folder / "sweep.toml").write_text(SWEEP)

    def words(self, *words):
        return [self.panelcal, *map(str, words)]

    def call(self, *words, expect=0):
        environment = dict(os.environ, TSAN_OPTIONS=f"exitcode={RACE} ignore_noninstrumented_modules=1")
        done = subprocess.run(self.words(*words), cwd=self.folder, env=environment, capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, expect, (words, done.stderr))
        return done

    def rows(self, name):
        with open(self.folder / name / "manifest.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_batch_takes_the_set_and_compares_it_with_truth(self):
        done = self.call("synth", "--sweep", "sweep.toml", "-o", "set")
        self.assertIn(f"{N_POINTS} points of 2 factors", done.stderr)
        rows = self.rows("set")
        self.assertEqual(len(rows), N_POINTS)
        self.assertEqual({row["noise"] for row in rows}, {"1", "15"})
        for row in rows:
            # The panel lies where the manifest says.
            truth = json.loads((self.folder / "set" / row["truth"]).read_text())
            self.assertEqual(truth["panel"]["translation_mm"][0], float(row["panel_offset_mm_x"]))
        self.call("batch", "set/manifest.csv", "-o", "results", "--json", "facts.json")
        facts = json.loads((self.folder / "facts.json").read_text())
        self.assertEqual(facts["jobs"]["drilled"], N_POINTS)
        conditions = [one for one in facts["conditions"] if one["factor"] == "noise"]
        self.assertEqual([one["value"] for one in conditions], ["1", "15"])
        for one in conditions:
            self.assertEqual(one["n_targets"], 3 * one["n_jobs"])
            self.assertGreater(one["error_rms_um"], 0)
        # 15 times the noise; three targets in 8 jobs each make the ratio uncertain by a fifth.
        self.assertGreater(conditions[1]["error_rms_um"], 4 * conditions[0]["error_rms_um"])
        # 16 different numbers are eight ranges of two, in their order.
        ranges = [one for one in facts["conditions"] if one["factor"] == "panel_offset_mm_x"]
        self.assertEqual([one["n_jobs"] for one in ranges], [2] * 8)
        offsets = sorted(float(row["panel_offset_mm_x"]) for row in rows)
        ends = [float(end) for one in ranges for end in one["value"].split(" to ")]
        self.assertEqual(ends, offsets)
        self.call("batch", "report", "results", "-o", "page.html")

    def test_neither_threads_nor_kills_change_a_byte(self):
        self.call("synth", "--sweep", "sweep.toml", "-o", "whole", "--threads", 1)
        whole = files(self.folder / "whole")
        self.call("synth", "--sweep", "sweep.toml", "-o", "threads", "--threads", 4)
        self.assertEqual(files(self.folder / "threads"), whole)
        n_midway = 0
        for i in range(20):
            target = self.folder / f"killed{i}"
            with subprocess.Popen(self.words("synth", "--sweep", "sweep.toml", "-o", target.name), cwd=self.folder,
                                  stderr=subprocess.DEVNULL) as process:
                while process.poll() is None and len(list(target.glob("points/*"))) <= i:
                    time.sleep(0.001)
                process.send_signal(signal.SIGKILL)
            n_midway += (target / "sweep.json").exists() and not (target / "manifest.csv").exists()
            self.call("synth", "--sweep", "sweep.toml", "-o", target.name, "--resume")
            self.assertEqual(files(target), whole)
            self.assertEqual(list(target.glob("parts/*")), [])
            if n_midway == 2:
                return
        self.fail("too few kills fell into the rendering")

    def test_a_longer_sobol_set_has_the_shorter_one(self):
        self.call("synth", "--sweep", "sweep.toml", "-o", "long")
        (self.folder / "short.toml").write_text(SWEEP.replace(f"points = {N_POINTS}", "points = 5"))
        self.call("synth", "--sweep", "short.toml", "-o", "short")
        shorter, longer = files(self.folder / "short/points"), files(self.folder / "long/points")
        self.assertEqual(shorter, {name: longer[name] for name in shorter})

    def test_single_targets_of_a_tool(self):
        (self.folder / "tool.toml").write_text("""machine = "machine.toml"
tool = 1
pictures = 2
design = "grid"

[[factor]]
key = "blur_px"
from = 0.8
to = 3.2
levels = 3
scale = "log"
""")
        self.call("synth", "--sweep", "tool.toml", "-o", "set")
        rows = self.rows("set")
        self.assertEqual([row["blur_px"] for row in rows], ["0.8", "1.6", "3.2"])
        for row in rows:
            truth = json.loads((self.folder / "set" / row["truth"]).read_text())
            self.assertEqual(truth["blur_px"], float(row["blur_px"]))
            self.assertEqual(len(truth["pictures"]), 2)
            for picture in truth["pictures"]:
                self.assertTrue((self.folder / "set" / row["images"] / picture["file"]).is_file())

    def test_the_public_benchmark_is_a_valid_experiment(self):
        source = self.root / "datasets/fiducials"
        text = (source / "sweep.toml").read_text()
        self.assertEqual(text.count("points = 512"), 1)
        folder = self.folder / "benchmark"
        folder.mkdir()
        shutil.copy(source / "machine.toml", folder)
        (folder / "sweep.toml").write_text(text.replace("points = 512", "points = 2"))
        self.call("synth", "--sweep", "benchmark/sweep.toml", "-o", "set")
        self.assertEqual(len(list((self.folder / "set").glob("points/*/*.png"))), 8)

    def test_refusals_leave_everything_as_it_is(self):
        (self.folder / "kept").mkdir()
        (self.folder / "kept/mine.txt").write_text("mine")
        done = self.call("synth", "--sweep", "sweep.toml", "-o", "kept", expect=2)
        self.assertIn("no empty folder", done.stderr)
        self.assertEqual(files(self.folder / "kept"), {"mine.txt": b"mine"})
        self.call("synth", "--sweep", "sweep.toml", "-o", "set")
        before = files(self.folder / "set")
        done = self.call("synth", "--sweep", "sweep.toml", "-o", "set", expect=2)
        self.assertIn("--resume", done.stderr)
        with open(self.folder / "machine.toml", "a", encoding="utf-8") as machine:
            machine.write("# another one\n")
        done = self.call("synth", "--sweep", "sweep.toml", "-o", "set", "--resume", expect=2)
        self.assertIn("other inputs", done.stderr)
        self.assertEqual(files(self.folder / "set"), before)
        (self.folder / "bad.toml").write_text(SWEEP.replace('"noise"', '"noize"'))
        done = self.call("synth", "--sweep", "bad.toml", "-o", "none", expect=2)
        self.assertRegex(done.stderr, r'^bad\.toml:8:\d+: error\[config-value\].*did you mean "noise"\?')
        self.assertFalse((self.folder / "none").exists())

    def test_values_that_do_not_go_together_are_found_first(self):
        (self.folder / "dark.toml").write_text(SWEEP.replace('"noise"', '"debris.darkest"').replace("[1, 15]", "[0, 1]") + """
[[factor]]
key = "debris.brightest"
values = [0.5]
""")
        done = self.call("synth", "--sweep", "dark.toml", "-o", "none", expect=2)
        self.assertIn("debris.darkest = 1", done.stderr)
        self.assertFalse((self.folder / "none").exists())


if __name__ == "__main__":
    Sweep.panelcal, Sweep.root = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
