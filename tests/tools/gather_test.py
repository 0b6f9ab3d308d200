#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Batches and ledgers of many machines in one database: what stands there is what the results and ledgers have,
whatever ends the command, the connection or the server.

    gather_test.py PANELCAL REPOSITORY [NUMBER OF KILLS]
"""
import json
import random
import shutil
import sqlite3
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path

from batch_inputs import CLOCK, N_JOBS, TABLES, BatchCase, files, stored

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / folder) for folder in ("golden", "support")]
import golden_ledger  # noqa: E402
import postgresql_server  # noqa: E402
from facts import checked  # noqa: E402

SKIP = 77
N_KILLS = 6
OF_POSTGRESQL, OF_SQLITE = "postgresql", "sqlite"


def rows_of_store(folder):
    """The rows of a batch's own store, as dictionaries."""
    store = sqlite3.connect(f"file:{folder / 'store.sqlite'}?mode=ro", uri=True)
    store.row_factory = sqlite3.Row
    rows = {table: [dict(row) for row in store.execute(f"SELECT * FROM {table} ORDER BY 1, 2")] for table in TABLES}
    store.close()
    return rows


def asked_in_file(file):
    def ask(sql):
        database = sqlite3.connect(f"file:{file}?mode=ro", uri=True)
        database.row_factory = sqlite3.Row
        rows = [dict(row) for row in database.execute(sql.replace("panelcal.", ""))]
        database.close()
        return rows
    return ask


class ServerCase(BatchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = postgresql_server.Server()

    @classmethod
    def tearDownClass(cls):
        cls.server.close()
        super().tearDownClass()


class Gathered(ServerCase):
    def setUp(self):
        self.server.run("DROP SCHEMA IF EXISTS panelcal CASCADE")

    def stores(self):
        """Address and a function that asks, for each kind of database."""
        file = self.folder() / "all.sqlite"
        yield OF_POSTGRESQL, self.server.address, self.server.ask
        yield OF_SQLITE, str(file), asked_in_file(file)

    def assert_gathered(self, ask, folder):
        """The database has the rows of that folder's batch and of no other."""
        expected = rows_of_store(folder / "out")
        (batch,) = ask("SELECT * FROM panelcal.batch")
        for table in TABLES:
            got = ask(f"SELECT * FROM panelcal.{table} ORDER BY 2, 3")
            self.assertEqual({row.pop("batch") for row in got} - {batch["id"]}, set())
            if table == "job":
                self.assertEqual(len({row.pop("sha256") for row in got}), len(got))
            self.assertEqual(got, expected[table], table)
        factors = [(row["job"], row["name"], row["value"]) for row in ask("SELECT * FROM panelcal.factor ORDER BY job, name")]
        self.assertEqual(factors, [(row["number"], name, value) for row in expected["job"]
                                   for name, value in sorted(json.loads(row["factors"]).items())])

    def test_a_batch_is_there_as_its_results_have_it(self):
        for kind, address, ask in self.stores():
            with self.subTest(kind=kind):
                folder = self.folder()
                self.batch(folder, "--store", address)
                self.assert_gathered(ask, folder)
                # The results themselves are those of a batch without it.
                self.assertEqual(files(folder / "out"), files(self.whole()))
                self.assertEqual(stored(folder / "out"), stored(self.whole()))
                done = self.call_in(folder, "batch", "push", "out", "--store", address)
                self.assertTrue(done.stdout.startswith("0 jobs put into "), done.stdout)

    def test_views_answer_as_the_store_does(self):
        own = sqlite3.connect(f"file:{self.whole() / 'store.sqlite'}?mode=ro", uri=True)
        wanted = {
            "refusals": own.execute("SELECT state, code, n_jobs FROM refusals ORDER BY state").fetchall(),
            "error_by_condition": own.execute("SELECT value, n_targets, found_rate, error_rms_um FROM error_by_condition "
                                              "ORDER BY value").fetchall(),
            "drift": own.execute("SELECT machine, day, n_fits, shift_x_mm FROM drift").fetchall()}
        own.close()
        for kind, address, ask in self.stores():
            with self.subTest(kind=kind):
                self.batch(self.folder(), "--store", address)
                got = {"refusals": "SELECT state, code, n_jobs FROM panelcal.refusals ORDER BY state",
                       "error_by_condition": "SELECT value, n_targets, found_rate, error_rms_um FROM "
                                             "panelcal.error_by_condition ORDER BY value",
                       "drift": "SELECT machine, day, n_fits, shift_x_mm FROM panelcal.drift"}
                for view, sql in got.items():
                    rows = [tuple(row.values()) for row in ask(sql)]
                    self.assertEqual(len(rows), len(wanted[view]), view)
                    for row, other in zip(rows, wanted[view]):
                        for a, b in zip(row, other):
                            if isinstance(b, float):
                                self.assertAlmostEqual(a, b, delta=1e-9 * max(1, abs(b)))
                            else:
                                self.assertEqual(a, b)

    def test_two_batches_stand_side_by_side_and_a_job_that_is_done_again_takes_its_place(self):
        for kind, address, ask in self.stores():
            with self.subTest(kind=kind):
                first, second = self.folder(), self.folder()
                self.batch(first, "--store", address)
                self.call_in(second, "batch", "jobs.csv", "-o", "out", "--clock", "2026-11-28T12:00:00", "--store", address,
                             expect=2)
                self.assertEqual([row["n"] for row in ask("SELECT count(*) AS n FROM panelcal.job GROUP BY batch")],
                                 [N_JOBS, N_JOBS])
                shutil.copy(self.inputs / "panel.exc", second / "none.exc")
                self.call_in(second, "batch", "jobs.csv", "-o", "out", "--only", "failed", "--store", address, expect=1)
                states = ask("SELECT state FROM panelcal.job WHERE id = 'fails' ORDER BY clock")
                self.assertEqual([row["state"] for row in states], ["failed", "drilled"])

    def test_whatever_ends_it_the_next_command_finishes_it(self):
        draw = random.Random(262)
        folder = self.folder()
        started = time.monotonic()
        self.batch(folder, "--store", self.server.address)
        duration = time.monotonic() - started
        n_ended = {"command": 0, "connection": 0, "server": 0}
        for i in range(N_KILLS):
            kind = list(n_ended)[i % 3]
            shutil.rmtree(folder / "out")
            self.server.run("DROP SCHEMA panelcal CASCADE")
            words = ["batch", "jobs.csv", "-o", "out", "--clock", CLOCK, "--store", self.server.address]
            child = subprocess.Popen([self.panelcal, *words], cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                     text=True)
            said = []
            reader = threading.Thread(target=lambda out=child.stderr: said.append(out.read()))
            reader.start()
            time.sleep(draw.uniform(0.1, 1) * duration)
            if kind == "command":
                child.kill()
            elif kind == "connection":
                self.server.run("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'panelcal'")
            else:
                self.server.stop()
            child.wait()
            reader.join()
            child.stderr.close()
            n_ended[kind] += child.returncode in (3, -9)
            # It says so, and the results are whole all the same, unless it was killed or had not begun.
            if child.returncode == 3:
                self.assertIn("error[device-write]", said[0])
            if kind == "server":
                self.server.start()
            if (folder / "out/store.sqlite").exists():
                self.batch(folder, "--resume", "--store", self.server.address)
            else:
                shutil.rmtree(folder / "out", ignore_errors=True)
                self.batch(folder, "--store", self.server.address)
            self.assert_gathered(self.server.ask, folder)
            self.assertEqual(files(folder / "out"), files(self.whole()))
            self.assertEqual(stored(folder / "out"), stored(self.whole()))
        self.assertGreater(sum(n_ended.values()), N_KILLS // 3, n_ended)
        print(f"ended: {n_ended}")

    def test_a_database_that_is_away_or_of_something_else_is_refused_and_no_password_shown(self):
        folder = self.folder()
        (folder / "text.sqlite").write_text("no database\n" * 100)
        other = sqlite3.connect(folder / "other.sqlite")
        other.execute("CREATE TABLE mine(a)")
        other.commit()
        other.close()
        before = {name: (folder / name).read_bytes() for name in ("text.sqlite", "other.sqlite")}
        cases = (("postgresql://me:secret@127.0.0.1:1/drill", 3), ("postgresql:///drill?host=/none&password=secret", 3),
                 ("postgresql://me:secret@[bad/drill", 3), ("text.sqlite", 2), ("other.sqlite", 2), ("none/all.sqlite", 2),
                 ("out", 3))
        (folder / "out").mkdir()
        for address, code in cases:
            with self.subTest(address=address):
                done = self.call_in(folder, "history", "fleet", "--store", address, expect=code)
                self.assertNotIn("secret", done.stderr)
                self.assertIn("error[", done.stderr)
        self.assertEqual({name: (folder / name).read_bytes() for name in before}, before)
        shutil.rmtree(folder / "out")
        self.batch(folder, "--store", "postgresql://me:secret@127.0.0.1:1/drill", expect=3)
        self.assertFalse((folder / "out/jobs").exists() and any((folder / "out/jobs").iterdir()), "jobs were done first")

    def test_a_database_of_a_newer_panelcal_is_refused(self):
        for kind, address, _ in self.stores():
            with self.subTest(kind=kind):
                folder = self.folder()
                golden_ledger.two_nights(folder / "drill1.ledger").close()
                self.call_in(folder, "history", "push", "-l", "drill1.ledger", "--store", address)
                if kind == OF_SQLITE:
                    database = sqlite3.connect(address)
                    database.execute("UPDATE version SET number = 99")
                    database.commit()
                    database.close()
                else:
                    self.server.run("UPDATE panelcal.version SET number = 99")
                done = self.call_in(folder, "history", "fleet", "--store", address, expect=2)
                self.assertIn("version 99 of the database", done.stderr)


class Fleet(ServerCase):
    """Nights of a file of SQLite; that PostgreSQL takes the same statements the batches show, and one push."""

    def night(self, folder, ledger, machine="drill 1", entry=None, **more):
        """Facts of a night behind an entry of a ledger."""
        database = sqlite3.connect(ledger)
        number, digest = database.execute("SELECT id, hash FROM ledger_entry WHERE id = coalesce(?, id) ORDER BY id DESC",
                                          (entry,)).fetchone()
        database.close()
        facts = {"facts": "night", "version": 1, "machine": machine, "night": "2026-11-22", "started": "2026-11-22T02:00:00Z",
                 "finished": "2026-11-22T02:10:00Z", "may_drill": True, "drill_until": None, "outcome": "installed",
                 "exit_code": 0, "verdict": "drill, until the next night", "dry_run": False, "asked_by": "timer",
                 "software": "panelcal 0.1.0", "ledger_head": {"id": number, "hash": digest}, **more}
        folder.mkdir(exist_ok=True)
        (folder / f"{facts['started'][:10]}.json").write_text(json.dumps(facts))

    def fleet(self, folder, clock, expect, store="all.sqlite", *words):
        done = self.call_in(folder, "history", "fleet", "--store", store, "--clock", clock, "--json", "fleet.json",
                            "--report", "fleet.html", *words, expect=expect)
        facts = checked(json.loads((folder / "fleet.json").read_text()), self.root)
        for one in facts["machines"]:
            self.assertIn(f"{one['state']:<8} {one['machine']}", done.stdout)
        self.assertIn('"fleet"', (folder / "fleet.html").read_text())
        return {one["machine"]: one for one in facts["machines"]}

    def push(self, folder, *words, expect=0, store="all.sqlite"):
        return self.call_in(folder, "history", "push", "-l", "drill1.ledger", "--store", store, *words, expect=expect)

    def ledgers(self):
        folder = self.folder()
        golden_ledger.two_nights(folder / "drill1.ledger").close()
        return folder

    def test_a_machine_may_drill_until_its_forecast_ends_or_the_next_night(self):
        for store in ("all.sqlite", self.server.address):
            with self.subTest(store=store):
                folder = self.ledgers()
                self.night(folder / "reports", folder / "drill1.ledger")
                done = self.push(folder, "--reports", "reports", store=store)
                self.assertRegex(done.stdout, r"^5 new entries, 1 new night put into ")
                self.assertRegex(self.push(folder, "--reports", "reports", store=store).stdout, "^0 new entries, 0 new nights")
                one = self.fleet(folder, "2026-11-22T08:00:00Z", 0, store)["drill 1"]
                self.assertEqual((one["state"], one["until"]), ("drill", "2026-11-23T14:10:00Z"))
                one = self.fleet(folder, "2026-11-24T08:00:00Z", 1, store)["drill 1"]
                self.assertEqual((one["state"], one["why"]), ("unknown", "no night since 2026-11-22T02:10:00Z"))
                self.night(folder / "reports", folder / "drill1.ledger", drill_until="2026-12-01T00:00:00Z")
                self.push(folder, "--reports", "reports", store=store)
                # A later night may have held, and not have been pushed.
                self.assertEqual(self.fleet(folder, "2026-11-30T08:00:00Z", 1, store)["drill 1"]["state"], "unknown")
                old = ("--max-age-h", 1000)
                one = self.fleet(folder, "2026-11-30T08:00:00Z", 0, store, *old)["drill 1"]
                self.assertEqual((one["state"], one["until"]), ("drill", "2026-12-01T00:00:00Z"))
                self.assertEqual(self.fleet(folder, "2026-12-01T00:00:01Z", 1, store, *old)["drill 1"]["state"], "unknown")
                one = self.fleet(folder, "2026-11-21T08:00:00Z", 1, store)["drill 1"]
                self.assertIn("of the future", one["why"])

    def test_a_night_that_holds_and_a_later_one_that_does_not(self):
        folder = self.ledgers()
        self.night(folder / "reports", folder / "drill1.ledger", may_drill=False, outcome="refused", exit_code=1,
                   verdict="do not drill: the camera was displaced")
        self.push(folder, "--reports", "reports")
        one = self.fleet(folder, "2026-11-22T08:00:00Z", 1)["drill 1"]
        self.assertEqual((one["state"], one["why"]), ("hold", "do not drill: the camera was displaced"))
        self.night(folder / "reports", folder / "drill1.ledger", started="2026-11-23T02:00:00Z",
                   finished="2026-11-23T02:10:00Z")
        self.push(folder, "--reports", "reports")
        self.assertEqual(self.fleet(folder, "2026-11-23T08:00:00Z", 0)["drill 1"]["state"], "drill")

    def test_a_calibration_behind_the_night_makes_it_unknown(self):
        folder = self.ledgers()
        self.night(folder / "reports", folder / "drill1.ledger", entry=1)
        self.push(folder, "--reports", "reports")
        one = self.fleet(folder, "2026-11-22T08:00:00Z", 1)["drill 1"]
        self.assertEqual((one["state"], one["n_entries_since"]), ("unknown", 4))
        self.assertIn("no night has judged", one["why"])

    def test_a_database_that_is_not_there_has_no_machines_that_may_drill(self):
        folder = self.ledgers()
        done = self.call_in(folder, "history", "fleet", "--store", "mistyped.sqlite", expect=2)
        self.assertIn("mistyped.sqlite: error[file-unreadable]", done.stderr)
        self.assertFalse((folder / "mistyped.sqlite").exists())

    def test_two_machines_of_one_name_are_unknown_and_a_ledger_that_was_begun_anew_is_not(self):
        entries = [golden_ledger.offset(50, -3, "2026-11-19T02:00:00Z"), golden_ledger.offset(60, 7, "2026-11-19T03:00:00Z")]
        for started, state in (("2026-11-22T02:00:00Z", "unknown"), ("2026-11-23T02:00:00Z", "drill")):
            with self.subTest(started=started):
                folder = self.folder()
                for number, entry in enumerate(entries, 1):
                    (folder / "drill1.ledger").unlink(missing_ok=True)
                    golden_ledger.make(folder / "drill1.ledger", [entry]).close()
                    # Both timers begin at the same second.
                    begun = started if number == 2 else "2026-11-22T02:00:00Z"
                    self.night(folder / f"reports-{number}", folder / "drill1.ledger", started=begun,
                               finished=begun.replace("02:00:00", "02:10:00"))
                    self.push(folder, "--reports", f"reports-{number}")
                one = self.fleet(folder, started.replace("02:00", "08:00"), int(state == "unknown"))["drill 1"]
                self.assertEqual(one["state"], state)
                if state == "unknown":
                    self.assertIn("two machines have one name", one["why"])

    def test_a_machine_without_a_night_is_unknown_and_a_dry_run_is_none(self):
        folder = self.ledgers()
        self.night(folder / "reports", folder / "drill1.ledger", dry_run=True)
        self.push(folder, "--reports", "reports")
        self.assertEqual(self.fleet(folder, "2026-11-22T08:00:00Z", 1)["drill 1"]["state"], "unknown")

    def test_a_ledger_that_was_damaged_cut_or_rewritten_is_refused_and_nothing_changes(self):
        folder = self.folder()
        entries = [golden_ledger.offset(50 + 0.001 * i, -3, f"2026-11-{19 + i}T02:00:00Z") for i in range(4)]
        ledger = folder / "drill1.ledger"
        golden_ledger.make(ledger, entries).close()
        self.push(folder)
        ask = asked_in_file(folder / "all.sqlite")
        before = ask("SELECT * FROM ledger"), ask("SELECT * FROM entry"), ask("SELECT * FROM parameter")
        self.assertEqual(len(before[1]), 4)
        self.assertEqual([row["value"] for row in before[2]][::2], [50, 50.001, 50.002, 50.003])
        self.assertEqual([row["sigma"] for row in before[2]][:2], [0.001, 0.002])
        whole = ledger.read_bytes()
        rewritten = [*entries[:3], golden_ledger.offset(99, -3, "2026-11-22T02:00:00Z")]
        for name, others, code in (("damaged", None, "ledger-corrupt"), ("cut", entries[:3], "ledger-cut-off"),
                                   ("rewritten", rewritten, "ledger-cut-off")):
            with self.subTest(name):
                ledger.unlink()
                if others is None:
                    ledger.write_bytes(whole.replace(b"50.002", b"50.009"))
                else:
                    golden_ledger.make(ledger, others).close()
                self.assertIn(f"error[{code}]", self.push(folder, expect=3).stderr)
                self.assertEqual((ask("SELECT * FROM ledger"), ask("SELECT * FROM entry"), ask("SELECT * FROM parameter")), before)
        # It has grown: only what is new goes.
        ledger.unlink()
        golden_ledger.make(ledger, [*entries, golden_ledger.offset(50, -3, "2026-11-23T02:00:00Z")]).close()
        self.assertRegex(self.push(folder).stdout, "^1 new entry put into ")
        self.assertEqual(len(ask("SELECT * FROM entry")), 5)

    def test_facts_that_are_no_night_are_left_alone_and_broken_ones_refused(self):
        folder = self.ledgers()
        (folder / "reports").mkdir()
        (folder / "reports/notes.json").write_text('{"facts": "job"}')
        (folder / "reports/list.json").write_text("[1, 2")
        self.assertRegex(self.push(folder, "--reports", "reports").stdout, "0 new nights")
        (folder / "reports/2026-11-23.json").write_text('{"facts": "night", "version": 1}')
        done = self.push(folder, "--reports", "reports", expect=2)
        self.assertIn("2026-11-23.json", done.stderr)
        self.push(folder, "--reports", "none", expect=2)


if __name__ == "__main__":
    if not postgresql_server.programs_folder():
        print("PostgreSQL is not installed (tools/packages.txt, extra)")
        sys.exit(SKIP)
    if len(sys.argv) > 3:
        N_KILLS = int(sys.argv.pop())
    BatchCase.root = Path(sys.argv.pop()).resolve()
    BatchCase.panelcal = str(Path(sys.argv.pop()).resolve())
    unittest.main()
