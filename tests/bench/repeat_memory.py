#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Memory and time of step and repeat against the number of holes.

Writes programs of 1e5, 1e6 and 1e7 holes as three nested levels of one pattern, runs each to CSV and
prints peak memory and time per hole. Peak memory must not grow with the holes; time per hole must
stay flat. The peer of the same run is Python's csv module writing the same number of rows.

  repeat_memory.py PANELCAL [--largest 7]
"""

import argparse
import csv
import os
import subprocess
import tempfile
import time

PATTERN_HOLES = 100


def program(n_holes):
    copies = n_holes // PATTERN_HOLES
    levels = []
    while copies > 1:
        n = min(copies, 100)
        levels.append(n)
        copies //= n
    text = "M48\nMETRIC,TZ\nT1C0.8\n%\nT1\nM25\nX1.0Y1.0\n"
    text += f"R{PATTERN_HOLES - 1}X0.5\nM01\n"
    text += "M01\n".join(f"R{n - 1}M02X0.01Y1.5\n" for n in levels)
    return text + "M08\nM30\n"


def run(panelcal, folder, n_holes):
    path = os.path.join(folder, "job.exc")
    machine = os.path.join(folder, "machine.toml")
    with open(path, "w") as file:
        file.write(program(n_holes))
    with open(machine, "w") as file:
        file.write('[machine]\nname = "bench"\n')
    output = os.path.join(folder, "out.csv")
    start = time.monotonic()
    child = subprocess.Popen([panelcal, "run", path, "-m", machine, "-o", output, "-q"])
    _, status, usage = os.wait4(child.pid, 0)
    seconds = time.monotonic() - start
    if status != 0:
        raise SystemExit(f"panelcal failed with {status}")
    with open(output) as file:
        rows = sum(1 for line in file if line.startswith("drill"))
    if rows != n_holes:
        raise SystemExit(f"expected {n_holes} holes, found {rows}")
    return usage.ru_maxrss / 1024, seconds, os.path.getsize(output) / 1e6


def peer_seconds(folder, n_rows):
    start = time.monotonic()
    with open(os.path.join(folder, "peer.csv"), "w", newline="") as file:
        writer = csv.writer(file)
        for i in range(n_rows):
            x = 1.0 + 0.5 * (i % PATTERN_HOLES)
            writer.writerow(["drill", 7, "0.0", 1, x, 1.0, x, 1.0, 0, 0, "", "", "", ""])
    return time.monotonic() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("panelcal")
    parser.add_argument("--largest", type=int, default=7, help="largest power of ten")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        peer = peer_seconds(folder, 10**5) / 10**5
        print(f"{'holes':>9} {'peak MiB':>9} {'s':>7} {'ns/hole':>8} {'MB out':>8} {'peer/ours':>9}")
        for power in range(5, args.largest + 1):
            n = 10**power
            peak, seconds, size = run(args.panelcal, folder, n)
            print(f"{n:>9} {peak:>9.1f} {seconds:>7.2f} {seconds / n * 1e9:>8.0f} {size:>8.1f} "
                  f"{peer / (seconds / n):>9.1f}")


if __name__ == "__main__":
    main()
