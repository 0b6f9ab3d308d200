#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`panelcal batch`: its results are those of `run`, whatever the number of threads and however often it is killed.

    batch_test.py PANELCAL REPOSITORY KILLS [UNITTEST OPTIONS]
"""
import fcntl
import json
import os
import random
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from batch_inputs import CLOCK, HEAD, N_JOBS, BatchCase, files, stored  # noqa: E402
from facts import checked, in_page  # noqa: E402
from json_schema import is_closed  # noqa: E402

def small_files_only():
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 16, 1 << 16))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


class Batch(BatchCase):
    n_kills = 0

    def test_threads_change_no_byte(self):
        folder = self.folder()
        done = self.batch(folder, "--threads", 4)
        self.assertIn(f"{N_JOBS} jobs: {N_JOBS - 2} drilled, 1 held, 1 failed", done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(files(folder / "out"), files(self.whole()))
        self.assertEqual(stored(folder / "out"), stored(self.whole()))
        self.assertEqual(list((folder / "out/parts").iterdir()), [])

    def test_a_job_is_what_run_makes(self):
        folder = self.folder()
        self.batch(folder, "--places")
        for name in ("pictures", "job-05"):
            of_batch = files(folder / "out")
            document = json.loads((folder / f"out/jobs/{name}/facts.json").read_text())
            words = next(row["value"] for row in document["provenance"] if row["key"] == "command line").split()
            self.assertEqual(words[:2], ["panelcal", "run"])
            shutil.rmtree(folder / f"out/jobs/{name}")
            (folder / f"out/jobs/{name}").mkdir()
            self.call_in(folder, *words[1:])
            of_run = files(folder / "out")
            drilled, facts = f"jobs/{name}/corrected.drl", f"jobs/{name}/facts.json"
            self.assertEqual(of_run[drilled], of_batch[drilled])
            # Pieces of pictures are for pages.
            for one in (of_run, of_batch):
                one[facts] = json.loads(one[facts])
                for target in one[facts]["targets"]:
                    for picture in target["pictures"]:
                        picture["crop"] = None
            self.assertEqual(of_run[facts], of_batch[facts])

    def test_what_failed_and_what_was_held_is_told(self):
        rows = {row[1]: row for row in stored(self.whole())["job"]}
        self.assertEqual(rows["held"][2:4], ("held", 1))
        self.assertEqual(rows["fails"][2:4], ("failed", 2))
        self.assertEqual(rows["fails"][-3], "file-unreadable")
        self.assertNotIn("jobs/held/corrected.drl", files(self.whole()))
        self.assertIn("jobs/held/facts.json", files(self.whole()))
        self.assertFalse((self.whole() / "jobs/fails").exists())

    def test_kills_lose_nothing_and_do_nothing_twice(self):
        whole_files, whole_rows = files(self.whole()), stored(self.whole())
        folder = self.folder()
        draw = random.Random(26)
        command = [self.panelcal, "batch", "jobs.csv", "-o", "out", "--clock", CLOCK, "--threads", "2", "--resume"]
        n_killed = n_rounds = 0
        started = time.monotonic()
        self.assertEqual(subprocess.run(command, cwd=folder, stderr=subprocess.DEVNULL, check=False).returncode, 2)
        duration = time.monotonic() - started
        while n_killed < self.n_kills:
            shutil.rmtree(folder / "out", ignore_errors=True)
            while True:
                child = subprocess.Popen(command, cwd=folder, stderr=subprocess.DEVNULL)
                try:
                    child.wait(draw.uniform(0, 1.3) * duration)
                except subprocess.TimeoutExpired:
                    child.kill()
                if child.wait() != -signal.SIGKILL:
                    break
                n_killed += 1
            self.assertEqual(child.returncode, 2)
            self.assertEqual(files(folder / "out"), whole_files)
            self.assertEqual(stored(folder / "out"), whole_rows)
            n_rounds += 1
        print(f"{n_killed} kills in {n_rounds} batches lost nothing")

    def test_failed_jobs_are_done_again(self):
        folder = self.folder()
        self.batch(folder)
        shutil.copy(self.inputs / "panel.exc", folder / "none.exc")
        done = self.batch(folder, "--only", "failed", expect=1)
        self.assertIn("; 1 now in", done.stderr)
        self.assertIn("0 failed", done.stderr)
        self.assertTrue((folder / "out/jobs/fails/corrected.drl").exists())
        rows = {row[1]: row for row in stored(folder / "out")["job"]}
        self.assertEqual(rows["fails"][2:4], ("drilled", 0))
        self.assertIn("; 0 now in", self.batch(folder, "--only", "failed", expect=1).stderr)

    def test_samples_are_the_same_and_grow(self):
        folder = self.folder()
        self.batch(folder, "--sample", 5, expect=0)
        first = {row[1] for row in stored(folder / "out")["job"]}
        self.assertEqual(len(first), 5)
        done = self.batch(folder, "--sample", 8, "--resume", expect=0)
        self.assertIn("; 3 now in", done.stderr)
        self.assertLess(first, {row[1] for row in stored(folder / "out")["job"]})
        self.batch(folder, "--resume")
        self.assertEqual(stored(folder / "out"), stored(self.whole()))

    def test_another_batch_is_refused(self):
        folder = self.folder()
        self.batch(folder, "--sample", 1, expect=0)
        self.assertIn("error[output-in-use]", self.batch(folder).stderr)
        (folder / "jobs.csv").unlink()
        (folder / "jobs.csv").write_text((self.inputs / "jobs.csv").read_text() + "more,panel.exc,machine.toml,,good.jsonl,,\n")
        self.assertIn("the manifest has changed", self.batch(folder, "--resume").stderr)

    def test_two_batches_at_once_are_refused(self):
        folder = self.folder()
        (folder / "out").mkdir()
        lock = open(folder / "out/lock", "w")
        fcntl.flock(lock, fcntl.LOCK_EX)
        self.assertIn("another batch writes to it", self.batch(folder).stderr)
        lock.close()

    def test_manifests_in_other_forms(self):
        folder = self.folder()
        lines = (self.inputs / "jobs.csv").read_text().splitlines()
        keys = lines[0].split(",")
        objects = [json.dumps({key: value for key, value in zip(keys, line.split(",")) if value}) for line in lines[1:]]
        (folder / "jobs.jsonl").write_text("\n".join(objects) + "\n")
        self.call_in(folder, "batch", "jobs.jsonl", "-o", "out", "--clock", CLOCK, expect=2)
        self.assertEqual(files(folder / "out"), files(self.whole()))
        for name in ("one", "two"):
            (folder / "many" / name).mkdir(parents=True)
            shutil.copy(self.inputs / "panel.exc", folder / "many" / name)
            shutil.copy(self.inputs / "good.jsonl", folder / "many" / name / "measurements.jsonl")
        done = self.call_in(folder, "batch", "--pattern", "many/*", "-m", "machine.toml", "-o", "found")
        self.assertIn("2 jobs: 2 drilled", done.stderr)

    def test_manifest_errors_name_their_place(self):
        folder = self.folder()
        job = "a,panel.exc,machine.toml,,good.jsonl,,"
        for text, place in {
            "id,progam\na,b\n": "1:4: error[usage]",
            f"{HEAD}\n{job}\n{job}\n": "3:1: error[usage]",
            f"{HEAD}\na,panel.exc\n": "2:1: error[usage]",
            f"{HEAD}\na,panel.exc,machine.toml,images,good.jsonl,,\n": "2:33: error[usage]",
            f"{HEAD}\n../a,panel.exc,machine.toml,,good.jsonl,,\n": "2:1: error[usage]",
            f"{HEAD}\n\"a,panel.exc,machine.toml,,good.jsonl,,\n": "2:1: error[usage]",
            '{"program":"panel.exc","machine":7}\n': "1:24: error[usage]",
            '{"program":"panel.exc",}\n': "1:24: error[json-syntax]",
            "": "1:1: error[usage]",
        }.items():
            with self.subTest(text=text):
                (folder / "bad.csv").write_text(text)
                done = self.call_in(folder, "batch", "bad.csv", "-o", "bad", expect=2)
                self.assertIn(f"bad.csv:{place}", done.stderr)
                self.assertFalse((folder / "bad").exists())

    def test_no_output_replaces_an_input(self):
        folder = self.folder()
        rows = "id,program,machine,measurements,output\n"
        for output in ("panel.exc", "machine.toml", "camera.cal.json", "good.jsonl", "bad.csv", "out/jobs/x.drl",
                       "b.drl\nb,panel.exc,machine.toml,good.jsonl,./b.drl"):
            with self.subTest(output=output):
                (folder / "bad.csv").write_text(f"{rows}a,panel.exc,machine.toml,good.jsonl,{output}\n")
                done = self.call_in(folder, "batch", "bad.csv", "-o", "out", "--to", "excellon", expect=2)
                self.assertRegex(done.stderr, r"error\[(output-in-use|usage)\]")
                self.assertFalse((folder / "out").exists())
        (folder / "good.csv").write_text(f"{rows}a,panel.exc,machine.toml,good.jsonl,elsewhere/a.csv\n")
        self.call_in(folder, "batch", "good.csv", "-o", "out")
        self.assertTrue((folder / "elsewhere/a.csv").read_text().startswith("op,"))

    def test_an_output_that_cannot_be_is_its_own_jobs_failure(self):
        folder = self.folder()
        (folder / "notes.txt").write_text("a file")
        (folder / "taken.drl").mkdir()
        outputs = {"beneath": "notes.txt/new/a.drl", "taken": "taken.drl", "long": "x" * 300 + ".drl",
                   "good": "new/a.drl"}
        if os.geteuid() != 0:
            (folder / "closed").mkdir(mode=0o500)
            outputs["closed"] = "closed/a.drl"
        rows = [f"{name},panel.exc,machine.toml,good.jsonl,{output}\n" for name, output in outputs.items()]
        (folder / "places.csv").write_text("id,program,machine,measurements,output\n" + "".join(rows))
        self.call_in(folder, "batch", "places.csv", "-o", "out", expect=3)
        for row in stored(folder / "out")["job"]:
            expected = ("drilled", 0, None) if row[1] == "good" else ("failed", 3, "device-write")
            self.assertEqual((row[2], row[3], row[-3]), expected, row)
        self.assertTrue((folder / "new/a.drl").exists())
        self.assertEqual((folder / "notes.txt").read_text(), "a file")
        done = self.call_in(folder, "batch", "places.csv", "-o", "out", "--resume", expect=3)
        self.assertIn("; 0 now in", done.stderr)

    def test_a_job_that_fails_when_done_again_leaves_no_earlier_results(self):
        folder = self.folder()
        (folder / "one.csv").write_text("id,program,machine,measurements\na,panel.exc,machine.toml,good.jsonl\n")
        self.call_in(folder, "batch", "one.csv", "-o", "out")
        results = folder / "out/jobs/a"
        self.assertEqual({path.name for path in results.iterdir()}, {"corrected.drl", "facts.json"})
        # As a program in the other language, and a kill between files and rows, would have left it.
        (results / "corrected.s5").write_text("old")
        (results / "notes.txt").write_text("a person's")
        with sqlite3.connect(folder / "out/store.sqlite") as store:
            store.execute("DELETE FROM job")
        store.close()
        (folder / "machine.toml").unlink()
        (folder / "machine.toml").write_text("no machine")
        self.call_in(folder, "batch", "one.csv", "-o", "out", "--resume", expect=2)
        rows = stored(folder / "out")
        self.assertEqual((rows["job"][0][2], rows["target"], rows["fit"], rows["hole_summary"]), ("failed", [], [], []))
        self.assertEqual([path.name for path in results.iterdir()], ["notes.txt"])

    def test_a_full_disk_ends_the_batch_and_it_goes_on(self):
        folder = self.folder()
        done = self.batch(folder, expect=3, preexec_fn=small_files_only)
        self.assertIn("error[device-write]", done.stderr)
        self.batch(folder, "--resume")
        self.assertEqual(files(folder / "out"), files(self.whole()))
        self.assertEqual(stored(folder / "out"), stored(self.whole()))

    def test_a_signal_keeps_what_was_done(self):
        folder = self.folder()
        child = subprocess.Popen([self.panelcal, "batch", "jobs.csv", "-o", "out", "--clock", CLOCK, "--threads", "1"],
                                 cwd=folder, stderr=subprocess.PIPE, text=True)
        while not (folder / "out/store.sqlite").exists() and child.poll() is None:
            time.sleep(0.001)
        child.send_signal(signal.SIGTERM)
        error = child.communicate()[1]
        # It may have been over by then.
        self.assertIn(child.returncode, (2, 128 + signal.SIGTERM), error)
        self.batch(folder, "--resume")
        self.assertEqual(stored(folder / "out"), stored(self.whole()))

    def test_report_and_show_state_the_same_facts(self):
        schema = json.loads((self.root / "share/schema/batch.schema.json").read_text())
        self.assertTrue(is_closed(schema))
        folder = self.folder()
        self.batch(folder, "--json", "batch.json")
        text = self.call_in(folder, "batch", "show", "out", "--json", "show.json").stdout
        self.call_in(folder, "batch", "report", "out", "-o", "page.html", "--json", "report.json")
        documents = [checked(json.loads((folder / name).read_text()), self.root)
                     for name in ("batch.json", "show.json", "report.json")]
        self.assertEqual(in_page(folder / "page.html"), documents[2])
        crops = [one["crop"] for one in documents[2]["worst"] if one["id"] == "pictures"]
        self.assertTrue(crops and all(crops), crops)
        for one in documents[2]["worst"]:
            one["crop"] = None
        self.assertEqual(documents[0], documents[1])
        self.assertEqual(documents[2], documents[1])
        facts = documents[0]
        self.assertEqual(facts["jobs"], {"drilled": N_JOBS - 2, "held": 1, "failed": 1, "exit_code": 2, "done": N_JOBS,
                                         "pictures": 21, "missing": 0})
        self.assertEqual(facts["targets"]["n"], 21 * (N_JOBS - 1))
        self.assertEqual(sum(facts["error"]["counts"]), facts["error"]["n"])
        self.assertAlmostEqual(sum(facts["error"]["predicted"]), facts["error"]["n"], delta=0.5)
        self.assertEqual(sum(facts["fits"]["exceedance_counts"]), facts["fits"]["n"])
        self.assertEqual([row["value"] for row in facts["conditions"]], ["0", "1", "2"])
        self.assertIn(f"{N_JOBS - 2} drilled, 1 held, 1 failed, 0 missing", text)
        self.assertIn("noise=2", text)
        self.call_in(folder, "batch", "show", "images", expect=2)

    def test_views_answer_questions(self):
        with sqlite3.connect(self.whole() / "store.sqlite") as store:
            for view in ("worst_targets", "refusals", "drift", "error_by_condition"):
                self.assertTrue(store.execute(f"SELECT * FROM {view}").fetchall(), view)
            held = store.execute("SELECT count(*) FROM refusals WHERE state = 'held'").fetchone()
        store.close()
        self.assertEqual(held, (1,))


def main():
    Batch.panelcal, Batch.root, Batch.n_kills = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
    unittest.main(argv=[*sys.argv[:1], *sys.argv[4:]])


if __name__ == "__main__":
    main()
