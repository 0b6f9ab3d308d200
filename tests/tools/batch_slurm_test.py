#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`panelcal batch --engine slurm` on a real Slurm of one node, and the command of GNU parallel.

    batch_slurm_test.py PANELCAL REPOSITORY

Without the programs it is skipped (exit code 77).
"""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from batch_inputs import CLOCK, HEAD, BatchCase, files, stored
from slurm_cluster import Cluster, enter_named_host, missing_programs, wait_until

N_SHARDS = 4
N_GATED_JOBS = 12


class Gates:
    """Measurements of the first job of each shard, which come from a pipe: the shard waits for them in the middle."""

    def __init__(self, folder, original):
        self.paths = {number: folder / f"gate-{number}.jsonl" for number in range(1, N_SHARDS + 1)}
        self.original = original
        for path in self.paths.values():
            path.unlink()
            os.mkfifo(path)

    def open(self):
        for path in self.paths.values():
            # The reader waits for this.
            pipe = os.open(path, os.O_WRONLY)
            beside = path.with_suffix(".new")
            shutil.copy(self.original, beside)
            beside.rename(path)
            os.write(pipe, self.original.read_bytes())
            os.close(pipe)


class Slurm(BatchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        rows = [HEAD]
        for number in range(1, N_GATED_JOBS + 1):
            gated = number <= N_SHARDS
            if gated:
                shutil.copy(cls.inputs / "good.jsonl", cls.inputs / f"gate-{number}.jsonl")
            name = f"gate-{number}" if gated else "moved" if number == 7 else "good"
            rows.append(f"job-{number},panel.exc,machine.toml,,{name}.jsonl,,{number}")
        (cls.inputs / "gated.csv").write_text("\n".join(rows) + "\n")
        folder = cls("run").folder()
        cls.call_in(folder, "batch", "gated.csv", "-o", "out", "--clock", CLOCK, expect=1)
        cls.of_gated = folder / "out"
        cls.server_folder = tempfile.TemporaryDirectory()
        cls.cluster = Cluster(Path(cls.server_folder.name), cpus=N_SHARDS)
        cls.addClassCleanup(cls.server_folder.cleanup)
        cls.addClassCleanup(cls.cluster.stop)

    def words(self, manifest, *more):
        return ["batch", manifest, "-o", "out", "--engine", "slurm", *more]

    def start(self, folder, *more):
        """The process that submits, with its words in a file."""
        with open(folder / "words", "a") as words:
            child = subprocess.Popen([self.panelcal, *self.words("gated.csv", *more)], cwd=folder, stderr=words,
                                     stdout=words)
        self.addCleanup(child.wait)
        self.addCleanup(child.kill)
        return child

    def shards(self, folder):
        """The processes of the shards that are at work there, by their numbers."""
        found = {}
        for process in Path("/proc").iterdir():
            try:
                if process.name.isdigit() and (process / "cwd").readlink() == folder:
                    words = (process / "cmdline").read_bytes().decode().split("\0")
                    if "--shard" in words:
                        found[int(words[words.index("--shard") + 1].split("/")[0])] = int(process.name)
            except OSError:
                pass
        return found

    def all_at_work(self, folder):
        return wait_until(lambda: len(self.shards(folder)) == N_SHARDS and self.shards(folder), "four shards at once")

    def assert_whole(self, folder, whole):
        self.assertEqual(files(folder / "out"), files(whole))
        self.assertEqual(stored(folder / "out"), stored(whole))
        self.assertFalse((folder / "out/shards").exists())
        self.assertFalse((folder / "out/slurm/array.json").exists())

    def submitted(self, folder):
        return {path.name.split("_")[0] for path in (folder / "out/slurm").glob("*_*.log")}

    def begin(self):
        folder = self.folder()
        return folder, Gates(folder, self.inputs / "good.jsonl")

    def test_results_are_those_of_one_process(self):
        folder = self.folder()
        done = self.call_in(folder, *self.words("jobs.csv", "--clock", CLOCK, "--shards", "4", "--json", "facts.json"),
                            expect=2)
        self.assertRegex(done.stderr, r"submitted array \d+ \(panelcal-\w+\) of 4 shards")
        self.assert_whole(folder, self.whole())
        self.assertEqual(json.loads((folder / "facts.json").read_text())["jobs"]["done"], 30)
        done = self.call_in(folder, *self.words("jobs.csv", "--resume"), expect=2)
        self.assertIn("; 0 now in", done.stderr)
        self.assertEqual(len(self.submitted(folder)), 1)

    def test_a_task_that_is_killed_is_submitted_again(self):
        folder, gates = self.begin()
        child = self.start(folder, "--clock", CLOCK, "--shards", "4")
        first = self.all_at_work(folder)
        self.assertEqual(wait_until(lambda: self.cluster.queue() == ["R"] * N_SHARDS and self.cluster.queue(),
                                    "four tasks run"), ["R"] * N_SHARDS)
        os.kill(first[2], signal.SIGKILL)
        again = wait_until(lambda: self.shards(folder).get(2) not in (None, first[2]) and self.shards(folder),
                           "the second shard at work again")
        self.assertEqual({n: pid for n, pid in again.items() if n != 2}, {n: pid for n, pid in first.items() if n != 2})
        gates.open()
        self.assertEqual(child.wait(), 1)
        self.assertIn("shard 2 of 4 ended before it was done: submitted again", (folder / "words").read_text())
        self.assert_whole(folder, self.of_gated)

    def test_a_task_that_slurm_requeues_goes_on(self):
        folder, gates = self.begin()
        child = self.start(folder, "--clock", CLOCK, "--shards", "4")
        first = self.all_at_work(folder)
        job, = self.submitted(folder)
        self.cluster.call("scontrol", "requeue", f"{job}_3")
        wait_until(lambda: self.shards(folder).get(3) not in (None, first[3]), "the third shard at work again")
        gates.open()
        self.assertEqual(child.wait(), 1)
        self.assertNotIn("submitted again", (folder / "words").read_text())
        self.assert_whole(folder, self.of_gated)

    def test_after_a_kill_of_the_submitter_nothing_is_submitted_twice(self):
        folder, gates = self.begin()
        child = self.start(folder, "--clock", CLOCK, "--shards", "4")
        first = self.all_at_work(folder)
        child.kill()
        child.wait()
        state = folder / "out/slurm/array.json"
        # As if it had been killed before sbatch answered.
        document = json.loads(state.read_text())
        state.write_text(json.dumps({**document, "jobs": [], "starts": [0] * N_SHARDS}))
        for more, message in ((("--shards", "3"), "an array of 4 shards is under way"),
                              (("--sample", "2"), "an array with other options is under way")):
            done = self.call_in(folder, *self.words("gated.csv", "--resume", *more), expect=2)
            self.assertIn(message, done.stderr)
        child = self.start(folder, "--resume")
        wait_until(lambda: "following array" in (folder / "words").read_text(), "the array is followed")
        gates.open()
        self.assertEqual(child.wait(), 1)
        self.assertEqual(len(self.submitted(folder)), 1, first)
        self.assert_whole(folder, self.of_gated)

    def test_a_signal_lets_the_array_go_on(self):
        folder, gates = self.begin()
        child = self.start(folder, "--clock", CLOCK, "--shards", "4")
        first = self.all_at_work(folder)
        child.send_signal(signal.SIGTERM)
        self.assertEqual(child.wait(), 128 + signal.SIGTERM)
        self.assertIn("goes on: --resume follows it again", (folder / "words").read_text())
        self.assertEqual(self.shards(folder), first)
        gates.open()
        self.call_in(folder, *self.words("gated.csv", "--resume"), expect=1)
        self.assertEqual(len(self.submitted(folder)), 1)
        self.assert_whole(folder, self.of_gated)

    def test_a_drained_node_holds_the_array_until_it_is_resumed(self):
        folder = self.folder()
        self.cluster.call("scontrol", "update", "NodeName=localhost", "State=DRAIN", "Reason=test")
        child = self.start(folder, "--clock", CLOCK, "--shards", "4")
        wait_until(lambda: self.cluster.queue() == ["PD"] * N_SHARDS, "four tasks wait")
        self.assertEqual(self.shards(folder), {})
        self.cluster.call("scontrol", "update", "NodeName=localhost", "State=RESUME")
        self.assertEqual(child.wait(), 1)
        self.assert_whole(folder, self.of_gated)

    def test_a_shard_that_never_ends_well_is_given_up_and_the_others_kept(self):
        folder, gates = self.begin()
        child = self.start(folder, "--clock", CLOCK, "--shards", "4", "--retries", "0")
        os.kill(self.all_at_work(folder)[4], signal.SIGKILL)
        wait_until(lambda: 4 not in self.shards(folder), "the fourth shard is gone")
        gates.paths.pop(4).unlink()
        shutil.copy(self.inputs / "good.jsonl", folder / "gate-4.jsonl")
        gates.open()
        self.assertEqual(child.wait(), 3)
        self.assertIn("shards 4 ended before they were done", (folder / "words").read_text())
        self.assertEqual(len(stored(folder / "out")["job"]), N_GATED_JOBS - N_GATED_JOBS // N_SHARDS)
        self.call_in(folder, *self.words("gated.csv", "--resume"), expect=1)
        self.assert_whole(folder, self.of_gated)

    def test_what_slurm_refuses_is_told_and_leaves_no_array(self):
        folder = self.folder()
        os.environ["SBATCH_PARTITION"] = "none"
        self.addCleanup(os.environ.pop, "SBATCH_PARTITION")
        done = self.call_in(folder, *self.words("gated.csv", "--clock", CLOCK), expect=3)
        self.assertIn("invalid partition", done.stderr.lower())
        self.assertFalse((folder / "out/slurm/array.json").exists())

    def test_gnu_parallel_does_the_same(self):
        folder = self.folder()
        line = self.call_in(folder, "batch", "jobs.csv", "-o", "out", "--clock", CLOCK, "--engine", "parallel",
                            "--shards", 5).stdout
        done = subprocess.run(["sh"], input=line, cwd=folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(files(folder / "out"), files(self.whole()))
        self.assertEqual(stored(folder / "out"), stored(self.whole()))


def main():
    missing = missing_programs() + [name for name in ("parallel",) if not shutil.which(name)]
    if missing:
        print("skipped, as these are missing:", *missing)
        sys.exit(77)
    enter_named_host()
    Slurm.panelcal, Slurm.root = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[*sys.argv[:1], *sys.argv[3:]])


if __name__ == "__main__":
    main()
