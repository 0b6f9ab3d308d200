# SPDX-License-Identifier: Apache-2.0
"""In bulk: locate a target in thousands of pictures on all cores, and hold the errors against truth.

    PYTHONPATH=build/release/python /usr/bin/python3 examples/python/bulk.py --count 5000
"""
import argparse
import os
import pathlib
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import panelcal

DEMO = pathlib.Path(__file__).resolve().parents[2] / "datasets" / "demo"

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--machine", type=pathlib.Path, default=DEMO / "machine.toml")
arguments.add_argument("--tool", type=int, default=1, help="vision tool to look for")
arguments.add_argument("--count", type=int, default=1000)
arguments.add_argument("--small", action="store_true", help="as the tests run it")
options = arguments.parse_args()
count = 40 if options.small else options.count

machine = panelcal.read_machine(options.machine)
samples = panelcal.Samples(machine, options.tool)  # camera, light and dirt as [sim] has them


def one(i: int):
    """Renders picture i and locates the target in it: both without the GIL."""
    image, truth = samples(i)
    found = panelcal.locate(image, options.tool, machine)
    if not found.found:
        return None, found.reason
    error_px = found.center_px - truth["center_px"]
    return (error_px, error_px @ np.linalg.solve(found.cov_px2, error_px)), ""


start = time.perf_counter()
with ThreadPoolExecutor(os.cpu_count()) as pool:
    results = list(pool.map(one, range(count)))
seconds = time.perf_counter() - start

good = [result for result, _ in results if result is not None]
errors_px = np.array([error for error, _ in good])
chi_square = np.array([value for _, value in good])
print(f"{count} pictures in {seconds:.1f} s, {count / seconds:.0f} a second on {os.cpu_count()} cores")
print(f"found: {len(good)} ({100 * len(good) / count:.1f} %)")
print(f"error: {1e3 * np.sqrt((errors_px**2).mean()):.2f} thousandths of a pixel rms in each axis")
# The mean of chi square is 2, the number of coordinates, or less: covariances also cover what the
# colours of a lens may hide.
print(f"chi square: {chi_square.mean():.2f} on average, at most 2 expected")
for reason in sorted({reason for _, reason in results if reason}):
    print("not found:", reason)
assert len(good) > 0.9 * count
assert chi_square.mean() < 2 + 5 * 2 / np.sqrt(len(good))  # five sigma
