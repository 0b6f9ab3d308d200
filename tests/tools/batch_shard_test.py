#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Shards of a batch, started by hand, and their merge: the results are those of one process.

    batch_shard_test.py PANELCAL REPOSITORY
"""
import fcntl
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import unittest
from pathlib import Path

from batch_inputs import CLOCK, N_JOBS, BatchCase, files, stored

N_SHARDS = 4
N_KILLS = 6


class Shards(BatchCase):
    def shard(self, folder, number, *words, expect=0, n_shards=N_SHARDS):
        return self.batch(folder, "--threads", 1, "--shard", f"{number}/{n_shards}", *words, expect=expect)

    def merge(self, folder, *words, expect=2):
        return self.call_in(folder, "batch", "merge", "out", *words, expect=expect)

    def assert_whole(self, folder):
        self.assertEqual(files(folder / "out"), files(self.whole()))
        self.assertEqual(stored(folder / "out"), stored(self.whole()))
        self.assertEqual({path.name for path in (folder / "out").iterdir()} - {"slurm"},
                         {"jobs", "lock", "parts", "store.sqlite"})

    def test_merged_they_are_the_batch_of_one_process(self):
        folder = self.folder()
        for number in (3, 1, 4, 2):
            done = self.shard(folder, number)
            self.assertRegex(done.stderr, rf"shard {number} of 4: [78] of [78] jobs done")
        done = self.merge(folder)
        self.assertIn(f"{N_JOBS} jobs: {N_JOBS - 2} drilled, 1 held, 1 failed; {N_JOBS} now", done.stderr)
        self.assert_whole(folder)
        with sqlite3.connect(folder / "out/store.sqlite") as store:
            sessions = store.execute("SELECT n_jobs FROM session ORDER BY number").fetchall()
        store.close()
        self.assertEqual(sum(n for n, in sessions), N_JOBS)
        # A second merge finds nothing more, and removes what a killed one has left.
        (folder / "out/shards").mkdir()
        self.assertIn("; 0 now", self.merge(folder).stderr)
        self.assert_whole(folder)

    def test_a_merge_leaves_what_is_no_shard_alone(self):
        folder = self.folder()
        self.shard(folder, 1)
        for name in ("precious", "1-of-many", "0-of-4"):
            (folder / "out/shards" / name).mkdir()
            (folder / "out/shards" / name / "notes.txt").write_text("mine")
        self.merge(folder, expect=1)
        self.assertEqual({path.name for path in (folder / "out/shards").iterdir()}, {"precious", "1-of-many", "0-of-4"})

    def test_one_that_is_started_again_does_nothing_twice(self):
        folder = self.folder()
        self.shard(folder, 2)
        store = folder / f"out/shards/2-of-{N_SHARDS}/store.sqlite"
        (folder / "out/jobs/job-01/corrected.drl").write_text("left alone")
        self.shard(folder, 2)
        self.assertEqual((folder / "out/jobs/job-01/corrected.drl").read_text(), "left alone")
        with sqlite3.connect(store) as connection:
            self.assertEqual(connection.execute("SELECT sum(n_jobs) FROM session").fetchone(), (8,))
        connection.close()

    def test_jobs_that_no_shard_has_done_are_done_by_resume(self):
        folder = self.folder()
        self.shard(folder, 2)
        self.shard(folder, 3)
        # It takes in what the shards have done, and does the others.
        done = self.batch(folder, "--resume")
        self.assertIn(f"{N_JOBS} jobs: ", done.stderr)
        self.assert_whole(folder)

    def test_they_leave_out_what_the_batch_has_done(self):
        folder = self.folder()
        self.batch(folder, "--sample", 10, expect=0)
        n_left = 0
        for number in range(1, N_SHARDS + 1):
            done = self.shard(folder, number)
            n_left += int(done.stderr.split(" jobs done")[0].split()[-1])
        self.assertEqual(n_left, N_JOBS - 10)
        self.merge(folder)
        self.assert_whole(folder)

    def test_failed_jobs_are_done_again(self):
        folder = self.folder()
        self.batch(folder)
        shutil.copy(self.inputs / "panel.exc", folder / "none.exc")
        for number in (1, 2):
            self.shard(folder, number, "--only", "failed", n_shards=2)
        done = self.merge(folder, expect=1)
        self.assertIn("0 failed; 1 now", done.stderr)
        self.assertTrue((folder / "out/jobs/fails/corrected.drl").exists())

    def test_kills_lose_nothing(self):
        folder = self.folder()
        draw = random.Random(263)
        n_killed = 0
        while n_killed < N_KILLS:
            shutil.rmtree(folder / "out", ignore_errors=True)
            started = time.monotonic()
            self.shard(folder, 1, n_shards=2)
            duration = time.monotonic() - started
            commands = {"shard": ["jobs.csv", "-o", "out", "--clock", CLOCK, "--threads", "1", "--shard", "2/2"],
                        "merge": ["merge", "out"]}
            for kind, words in commands.items():
                while True:
                    child = subprocess.Popen([self.panelcal, "batch", *words], cwd=folder, stderr=subprocess.DEVNULL)
                    try:
                        child.wait(draw.uniform(0, 1.3) * duration)
                    except subprocess.TimeoutExpired:
                        child.kill()
                    if child.wait() != -signal.SIGKILL:
                        break
                    n_killed += 1
                self.assertEqual(child.returncode, 0 if kind == "shard" else 2)
            self.assert_whole(folder)

    def test_a_shard_at_work_is_not_merged(self):
        folder = self.folder()
        self.shard(folder, 1)
        with open(folder / f"out/shards/1-of-{N_SHARDS}/lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.assertIn("error[output-in-use]", self.merge(folder).stderr)
            self.assertIn("error[output-in-use]", self.shard(folder, 1, expect=2).stderr)
        self.merge(folder, expect=1)

    def test_other_batches_are_refused(self):
        folder = self.folder()
        self.shard(folder, 1)
        words = ("batch", "jobs.csv", "-o", "out", "--shard", "2/4")
        self.assertIn("--clock, the same one for all shards", self.call_in(folder, *words, expect=2).stderr)
        self.call_in(folder, *words, "--clock", "2026-11-28T00:00:00")
        self.assertIn("the batch was begun with --clock", self.merge(folder).stderr)
        # Nothing is lost.
        self.assertTrue((folder / f"out/shards/2-of-{N_SHARDS}/store.sqlite").exists())
        self.assertIn("no results of a batch", self.call_in(folder, "batch", "merge", "images", expect=2).stderr)
        self.assertFalse((folder / "images/lock").exists())

    def test_what_is_no_shard_is_refused(self):
        folder = self.folder()
        for text in ("0/4", "5/4", "2", "a/4", "2/4/8", "1/0", "1/5001", "-1/4", ""):
            with self.subTest(text=text):
                done = self.call_in(folder, "batch", "jobs.csv", "-o", "out", "--clock", CLOCK, f"--shard={text}", expect=2)
                self.assertIn("error[usage]", done.stderr)
                self.assertFalse((folder / "out").exists())
        for more in (("--engine", "slurm"), ("--json", "a.json")):
            self.batch(folder, "--shard", "1/4", *more, expect=2)

    def test_the_command_of_parallel_is_printed_and_nothing_else_done(self):
        folder = self.folder()
        done = self.call_in(folder, "batch", "jobs.csv", "-o", "out of it", "--engine", "parallel", "--clock", CLOCK,
                            "--shards", 3, "--json", "facts.json")
        self.assertIn(f"batch jobs.csv -o 'out of it' --clock {CLOCK} --threads 1 --shard {{}}/3 ::: $(seq 3) && \\\n",
                      done.stdout)
        self.assertTrue(done.stdout.endswith("batch merge 'out of it' --json facts.json\n"), done.stdout)
        self.assertFalse((folder / "out of it").exists())
        self.assertIn("a manifest that all of them can read",
                      self.call_in(folder, "batch", "-", "-o", "out", "--engine", "parallel", expect=2,
                                   stdin=subprocess.DEVNULL).stderr)


def main():
    Shards.panelcal, Shards.root = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=[*sys.argv[:1], *sys.argv[3:]])


if __name__ == "__main__":
    main()
