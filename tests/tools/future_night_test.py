#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A night of a clock that was wrong holds the next one, which names the entry and the way on.

    future_night_test.py PANELCAL REPOSITORY
"""
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from datetime import datetime, timedelta, timezone
from pathlib import Path

PANELCAL = str(Path(sys.argv[1]).resolve())
FIXTURES = Path(sys.argv[2]).resolve() / "tests" / "golden" / "fixtures"


def panelcal(*words, code=0):
    done = subprocess.run([PANELCAL, *words], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done


# `history fresh-start` has the time of the clock on the wall.
NOW = datetime.now(timezone.utc)


def clock(days, minutes=0):
    return (NOW + timedelta(days=days, minutes=minutes)).strftime("%Y-%m-%dT%H:%M:%SZ")


def night(when, code=0):
    return panelcal("nightly", "-m", "machine.toml", "--clock", when, code=code).stdout


def check(future):
    """After a night at that time: one of today is held, and goes on as it says."""
    night(future)
    said = night(clock(0), 1)
    found = re.search(r"entry (\d+) of the ledger is [\d.]+ hours ahead of the clock", said)
    assert found, said
    entry = panelcal("history", "show", found[1], "-l", "drill1.ledger").stdout
    assert future[:10] in entry, entry
    command = re.search(r"`panelcal (history fresh-start [^`]*)`", said)
    assert command, said
    panelcal(*shlex.split(command[1]))
    night(clock(0, 30))
    night(clock(1))


def main():
    # As the first night of all, and after one whose time was right.
    check(clock(26000))
    Path("drill1.ledger").unlink()
    shutil.rmtree("reports")
    Path("spindle.cal.json").unlink()
    night(clock(-2))
    check(clock(196))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in ("night/machine.toml", "camera-320-px/camera.cal.json"):
            shutil.copy(FIXTURES / name, ".")
        main()
