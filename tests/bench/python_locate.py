#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Cost of locating from Python over the same from C++, in CPU time.

    ninja -C build/release panelcal_python locate_loop
    PYTHONPATH=build/release/python /usr/bin/python3 tests/bench/python_locate.py \\
        build/release/tests/bench/locate_loop

The two take turns, many short ones each, so that another load on the machine meets both. Of an
`image` nothing is copied; of an `array` of 8 bit both make a picture each time.
"""
import pathlib
import statistics
import subprocess
import sys
import time

import numpy as np

import panelcal

DEMO = pathlib.Path(__file__).resolve().parents[2] / "datasets" / "demo"
N_TURNS = 60
SECONDS_PER_TURN = 0.15


def main():
    machine_file = DEMO / "machine.toml"
    machine = panelcal.read_machine(machine_file)
    picture = DEMO / "images" / "0000.png"
    image = panelcal.read_image(picture)
    pixels = np.asarray(image).astype(np.uint8)
    with subprocess.Popen([sys.argv[1], machine_file, "1", picture], text=True,
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE) as peer:

        def by_cpp(n, what):
            peer.stdin.write(f"{n} {what}\n")
            peer.stdin.flush()
            return float(peer.stdout.readline())

        def by_python(n, what):
            looked_at = image if what == "image" else pixels
            start = time.process_time()
            for _ in range(n):
                assert panelcal.locate(looked_at, 1, machine).found
            return time.process_time() - start

        for what in ("image", "array"):
            n = max(1, round(SECONDS_PER_TURN / (by_cpp(20, what) / 20)))
            by_python(n, what)
            turns = [(by_python(n, what), by_cpp(n, what)) for _ in range(N_TURNS)]
            ratios = sorted(python / cpp for python, cpp in turns)
            ms = 1e3 * statistics.median(cpp for _, cpp in turns) / n
            print(f"{what}: C++ {ms:.3f} ms, Python over C++ {statistics.median(ratios):.4f} "
                  f"(quartiles {ratios[N_TURNS // 4]:.4f}, {ratios[3 * N_TURNS // 4]:.4f}), "
                  f"{N_TURNS} turns of {n}")
        peer.stdin.close()


if __name__ == "__main__":
    main()
