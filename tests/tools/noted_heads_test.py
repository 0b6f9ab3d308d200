#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Deleting the ledger's newest entries is found by the files that note its head.

    noted_heads_test.py PANELCAL REPOSITORY
"""
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path

import real_files

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from facts import in_page  # noqa: E402

PANELCAL = str(Path(sys.argv[1]).resolve())


def panelcal(*words, code=0):
    done = subprocess.run([PANELCAL, *words], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done


def verify(*words, code=0):
    return panelcal("history", "verify", "-l", "drill1.ledger", *words, code=code)


def head():
    found = json.loads(verify("--json", "-").stdout)["verification"]
    return found["entries"], found["head"]


def delete_after(entry):
    """As one who knows SQLite does it: the chain of what is left is sound."""
    ledger = sqlite3.connect("drill1.ledger")
    triggers = ledger.execute("SELECT name, sql FROM sqlite_master WHERE name IN "
                              "('ledger_entry_delete', 'ledger_entry_insert') "
                              "ORDER BY rowid").fetchall()
    # Both: the ledger's schema has them in this order, and a new one stands behind all others.
    for name, _ in triggers:
        ledger.execute(f"DROP TRIGGER {name}")
    ledger.execute("DELETE FROM ledger_entry WHERE id > ?", (entry,))
    for _, sql in triggers:
        ledger.execute(sql)
    ledger.commit()
    ledger.close()
    assert verify().stdout.startswith(f"{entry} entries, undamaged")


def found_by(entry, *words):
    """Whether the deletion of everything after an entry is found; the ledger is whole again."""
    shutil.copy("drill1.ledger", "whole")
    delete_after(entry)
    done = subprocess.run([PANELCAL, "history", "verify", "-l", "drill1.ledger", *words],
                          capture_output=True, text=True, timeout=120)
    os.replace("whole", "drill1.ledger")
    assert done.returncode in (0, 3), done
    assert (done.returncode == 3) == ("error[ledger-cut-off]" in done.stderr), done.stderr
    return done.returncode == 3


def main():
    real_files.make(PANELCAL, sys.argv[2], ".")
    Path("machine.toml").write_text(
        real_files.MACHINE.replace('temperature_file =', 'reports = "reports"\ntemperature_file ='))
    panelcal("nightly", "-m", "machine.toml", "--clock", "2026-11-22T02:00:00Z")
    newest, digest = head()
    page, facts = (Path("reports", "2026-11-21" + ending) for ending in (".html", ".json"))
    assert in_page(page) == json.loads(facts.read_text())
    assert in_page(page)["ledger_head"] == {"id": newest, "hash": digest}

    # The calibration in force: its bytes are its entry's result, and note the entry before.
    listed = panelcal("history", "list", "-l", "drill1.ledger", "--json", "-").stdout
    entries = json.loads(listed)["entries"]
    own = [entry for entry in entries if entry["in_force"]][-1]
    shown = panelcal("history", "show", str(own["id"]), "--result", "-l", "drill1.ledger").stdout
    assert Path("spindle.cal.json").read_text() == shown
    note = json.loads(shown)["ledger"]
    assert note == {"recorded_after": own["id"] - 1, "hash": entries[own["id"] - 2]["hash"]}

    said = verify("-m", "machine.toml").stdout
    assert re.search(r"held against 3 files with a noted head; the newest is \S+, of entry "
                     f"{newest}\n1 file without a head\n", said), said  # the camera's is by hand
    # Each of them finds what it can: a report all, a calibration its own entry.
    for entry in range(1, newest):
        assert found_by(entry, "-m", "machine.toml"), entry
        assert found_by(entry, "--against", "reports"), entry
        assert found_by(entry, "--against", str(page)) and found_by(entry, "--against", str(facts))
        assert found_by(entry, "--against", "spindle.cal.json") == (entry < own["id"]), entry
        assert not found_by(entry)

    # Reports of jobs, and calibrations that are in no ledger, note it too.
    panelcal("run", "job.exc", "-m", "machine.toml", "--images", "images", "--report", "job.html",
             "-o", "job.jsonl", "--clock", "2026-11-23T02:00:00")
    panelcal("calibrate", "spindle-camera", "-m", "machine.toml", "--machine-driver", "sim",
             "--clock", "2026-11-23T02:00:00Z", "-o", "other.cal.json")
    assert found_by(newest - 1, "--against", "job.html")
    rows, digest = head()
    assert rows == newest + 1  # of the coupon
    assert json.loads(Path("other.cal.json").read_text())["ledger"] == {"head": rows, "hash": digest}
    assert found_by(newest, "--against", "other.cal.json")
    assert not found_by(newest, "--against", "job.html")
    panelcal("run", "job.exc", "-m", "machine.toml", "--images", "images", "-o", "again.jsonl",
             "--clock", "2026-11-23T02:00:00")

    # What is read is not written over, and what is asked for has to be there.
    assert "output-in-use" in verify("--against", "job.html", "-o", "job.html", code=2).stderr
    assert "file-unreadable" in verify("--against", "none.json", code=2).stderr


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        main()
