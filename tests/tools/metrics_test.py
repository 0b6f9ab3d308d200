#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`--metrics` of `batch` and `nightly`: numbers that Prometheus reads, and that are right.

    metrics_test.py PANELCAL REPOSITORY

Without promtool it is skipped (exit code 77).
"""
import calendar
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import real_files

CLOCK = "2026-11-23T02:00:00Z"


def numbers_of(file):
    """The values by name and labels; `promtool` has read the same file, and finds fault with nothing."""
    done = subprocess.run(["promtool", "check", "metrics"], stdin=open(file), capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, (done, file.read_text())
    lines = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    found = {name: float(value) for name, value in (line.rsplit(" ", 1) for line in lines)}
    assert len(found) == len(lines), lines
    return found


def call(panelcal, folder, *words, expect):
    done = subprocess.run([panelcal, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == expect, (words, done)
    return done


def batch(panelcal, folder):
    name = 'many \\ "jobs".csv'
    (folder / name).write_text("program,machine,images\n" + "job.exc,machine.toml,images\n" * 2 + "none.exc,machine.toml,images\n")
    before = time.time()
    call(panelcal, folder, "batch", name, "-o", "many", "--metrics", "batch.prom", expect=2)
    found = numbers_of(folder / "batch.prom")
    label = 'batch="many \\\\ \\"jobs\\".csv"'
    for state, n in {"drilled": 2, "held": 0, "failed": 1, "missing": 0}.items():
        assert found[f'panelcal_batch_jobs{{{label},state="{state}"}}'] == n, found
    assert found[f"panelcal_batch_exit_code{{{label}}}"] == 2, found
    assert found[f"panelcal_batch_pictures{{{label}}}"] > 0, found
    assert int(before) <= found[f"panelcal_batch_finished_timestamp_seconds{{{label}}}"] <= time.time(), found
    # A shard is not the batch; its merge is.
    shard = ("batch", name, "-o", "shards", "--clock", "2026-11-23T02:00:00", "--shard", "2/3")
    call(panelcal, folder, *shard, "--metrics", "shard.prom", expect=2)
    call(panelcal, folder, *shard, expect=0)
    call(panelcal, folder, "batch", "merge", "shards", "--metrics", "shards.prom", expect=0)
    found = numbers_of(folder / "shards.prom")
    assert found[f'panelcal_batch_jobs{{{label},state="missing"}}'] == 2, found
    # The exit code is that of a file that cannot be written.
    call(panelcal, folder, "batch", "merge", "shards", "--metrics", "none/shards.prom", expect=3)
    call(panelcal, folder, "batch", name, "-o", "other", "--metrics", "batch.txt", expect=2)
    assert not (folder / "other").exists()


def nightly(panelcal, folder):
    done = call(panelcal, folder, "nightly", "-m", "machine.toml", "--clock", CLOCK, "--metrics", "night.prom", expect=0)
    found = numbers_of(folder / "night.prom")
    label = 'machine="drill 1"'
    assert found[f"panelcal_night_may_drill{{{label}}}"] == 1, (found, done.stdout)
    assert found[f"panelcal_night_exit_code{{{label}}}"] == 0, found
    now = calendar.timegm(time.strptime(CLOCK, "%Y-%m-%dT%H:%M:%SZ"))
    assert found[f"panelcal_night_finished_timestamp_seconds{{{label}}}"] >= now, found
    installed = [name for name in found if name.startswith("panelcal_night_calibration_installed{")]
    assert any('kind="spindle-camera"' in name and 'state="installed"' in name for name in installed), found
    call(panelcal, folder, "nightly", "-m", "machine.toml", "--metrics", "dry.prom", "--dry-run", expect=2)
    # A night that could not begin is told, too: a number of the night before would still say that it may drill.
    for broken, code in (("camera.cal.json", 2), ("drill1.ledger", 2)):
        whole = (folder / broken).read_bytes()
        (folder / broken).write_text("{}")
        (folder / "night.prom").unlink()
        call(panelcal, folder, "nightly", "-m", "machine.toml", "--clock", CLOCK, "--metrics", "night.prom", expect=code)
        found = numbers_of(folder / "night.prom")
        assert found[f"panelcal_night_may_drill{{{label}}}"] == 0, found
        assert found[f"panelcal_night_exit_code{{{label}}}"] == code, found
        (folder / broken).write_bytes(whole)


def main():
    if not shutil.which("promtool"):
        print("skipped, as promtool is missing")
        return 77
    panelcal, repository = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        real_files.make(panelcal, repository, folder)
        batch(panelcal, folder)
        nightly(panelcal, folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
