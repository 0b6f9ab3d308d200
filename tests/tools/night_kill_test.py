#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""kill -9 at random moments of a night: history reads the ledger at once, the files hold what they note
of it, no row of the coupon is drilled twice, and the same night can be finished.

    night_kill_test.py PANELCAL REPOSITORY KILLS
"""
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import real_files

PANELCAL = str(Path(sys.argv[1]).resolve())
N_ROWS = 3  # of a calibration


def panelcal(*words):
    return subprocess.run([PANELCAL, *words], capture_output=True, text=True, timeout=300)


def night(day):
    return ["nightly", "-m", "machine.toml", "--clock",
            f"{2027 + day // 300}-{1 + day % 300 // 25:02}-{1 + day % 25:02}T02:00:00Z"]


def read_ledger():
    verified = panelcal("history", "verify", "-l", "drill1.ledger", "-m", "machine.toml")
    assert verified.returncode == 0, verified
    listed = panelcal("history", "list", "-l", "drill1.ledger", "--json", "-")
    assert listed.returncode == 0, listed
    return json.loads(listed.stdout)["entries"]


def rows_taken(entries):
    return [parameter["value"] for entry in entries if entry["kind"] == "coupon"
            for parameter in entry["parameters"]]


def main():
    kills = int(sys.argv[3])
    draw = random.Random(20261126)
    real_files.make(PANELCAL, sys.argv[2], ".")
    Path("machine.toml").write_text(real_files.MACHINE.replace("rows = 300", "rows = 1000").replace(
        'temperature_file =', 'reports = "reports"\ntemperature_file ='))
    begin = time.monotonic()
    assert panelcal(*night(0)).returncode == 0
    whole = time.monotonic() - begin
    n_killed = day = 0
    while n_killed < kills:
        day += 1
        assert day < 4 * kills + 10, "no night was killed"
        before = read_ledger()
        child = subprocess.Popen([PANELCAL, *night(day)], stdout=subprocess.DEVNULL,
                                 stderr=subprocess.DEVNULL)
        time.sleep(draw.uniform(0, 1.2 * whole))
        child.kill()
        n_killed += child.wait() < 0
        after = read_ledger()
        assert [e["hash"] for e in after[:len(before)]] == [e["hash"] for e in before], day
        again = panelcal(*night(day))
        assert again.returncode in (0, 1), again
        if draw.random() < 0.3:
            Path("coupon.json").unlink(missing_ok=True)  # a finished night takes none
    taken = rows_taken(read_ledger())
    assert taken == [N_ROWS * (i + 1) for i in range(len(taken))], taken
    assert not list(Path().glob("*.part-panelcal-*")), os.listdir(".")
    print(f"{n_killed} of {day} nights killed, {len(taken)} runs on the coupon")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        main()
