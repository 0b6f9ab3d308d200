#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Heights of a probed surface against scipy: accuracy and speed.

Speed: scipy's map_coordinates and RegularGridInterpolator on a lattice of 200 x 200 nodes, turn by
turn with surface_bench (which is given a round of its own each time), ns a query and our time by
theirs. Accuracy: 50 warps, 12 x 10 probes each; root mean square error at 2000 places inside of the
probes' hull, of ours and of the best of scipy's interpolators for that very warp, which no user
could know without the truth. Exits with 1 if ours is more than 1.3 times the best one, all in all.

  /usr/bin/python3 tests/bench/surface_peers.py build/release/tests/bench/surface_bench [--queries 1000000]
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
import warnings

import numpy as np
from scipy import interpolate, ndimage

MOST = 1.3
NODES = 200
ROUNDS = 5


def ours_ns(bench, queries):
    text = subprocess.run([bench, "speed", str(queries)], check=True, capture_output=True, text=True).stdout
    return {name: float(ns) for name, ns in re.findall(rf"\| (bilinear|bicubic), {queries} at once, at random \| ([0-9.]+) ", text)}


def peers(heights, places):
    axis = np.arange(NODES, dtype=float)
    grids = {kind: interpolate.RegularGridInterpolator((axis, axis), heights, method=kind) for kind in ("linear",)}
    spline = ndimage.spline_filter(heights, order=3)
    return {
        "map_coordinates order 1": ("bilinear", lambda: ndimage.map_coordinates(heights, places, order=1)),
        "map_coordinates order 3": ("bicubic", lambda: ndimage.map_coordinates(spline, places, order=3, prefilter=False)),
        "RegularGridInterpolator linear": ("bilinear", lambda: grids["linear"](places.T)),
    }


def speed(bench, queries):
    random = np.random.default_rng(20261122)
    heights = random.normal(size=(NODES, NODES))
    places = random.uniform(1, NODES - 2, size=(2, queries))
    ratios, times = {}, {}
    for _ in range(ROUNDS):
        ours = ours_ns(bench, queries)
        for name, (kind, run) in peers(heights, places).items():
            begin = time.thread_time()
            run()
            ns = (time.thread_time() - begin) / queries * 1e9
            times.setdefault(name, []).append(ns)
            ratios.setdefault(name, []).append(ours[kind] / ns)
    print("| peer | ns | ours / peer |\n| --- | --- | --- |")
    for name in times:
        print(f"| {name} | {min(times[name]):.1f} | {np.median(ratios[name]):.3f} |")


def interpolators(probes):
    xy, z, sigma = probes[:, :2], probes[:, 2], probes[0, 3]
    x, y = np.unique(xy[:, 0]), np.unique(xy[:, 1])
    grid = z.reshape(len(y), len(x)).T
    noise = len(z) * sigma**2
    for kernel in ("thin_plate_spline", "cubic", "quintic", "linear"):
        yield f"RBFInterpolator {kernel}", interpolate.RBFInterpolator(xy, z, kernel=kernel)
    for kernel in ("gaussian", "multiquadric", "inverse_multiquadric"):
        yield f"RBFInterpolator {kernel}", interpolate.RBFInterpolator(xy, z, kernel=kernel, epsilon=1 / 40)
    for smoothing in (1, 100, 1000, 10_000, 100_000):
        yield f"RBFInterpolator thin_plate_spline, smoothing {smoothing}", interpolate.RBFInterpolator(
            xy, z, kernel="thin_plate_spline", smoothing=smoothing
        )
    yield "RectBivariateSpline", interpolate.RectBivariateSpline(x, y, grid).ev
    yield "RectBivariateSpline, smoothing", interpolate.RectBivariateSpline(x, y, grid, s=noise).ev
    yield "SmoothBivariateSpline", interpolate.SmoothBivariateSpline(xy[:, 0], xy[:, 1], z, w=np.full(len(z), 1 / sigma)).ev
    yield "griddata cubic, CloughTocher", interpolate.CloughTocher2DInterpolator(xy, z)
    yield "griddata linear", interpolate.LinearNDInterpolator(xy, z)


def rms(errors):
    return float(np.sqrt(np.mean(np.square(errors))))


def accuracy(bench):
    ours, best, by_name = [], [], {}
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([bench, "accuracy", folder], check=True)
        for file in sorted(os.listdir(folder)):
            with open(os.path.join(folder, file)) as text:
                parts = text.read().split("\n\n")
            probes, places = (np.array([line.split() for line in part.split("\n") if line], float) for part in parts)
            truth = places[:, 2]
            ours.append(rms(places[:, 3] - truth))
            found = {}
            for name, at in interpolators(probes):
                heights = at(places[:, 0], places[:, 1]) if "Spline" in name else at(places[:, :2])
                found[name] = rms(heights - truth)
                by_name.setdefault(name, []).append(found[name])
            best.append(min(found.values()))
    ratios = np.array(ours) / np.array(best)
    print("| | rms um |\n| --- | --- |")
    print(f"| ours | {rms(ours) * 1e3:.2f} |")
    for name, errors in sorted(by_name.items(), key=lambda row: rms(row[1])):
        print(f"| {name} | {rms(errors) * 1e3:.2f} |")
    print(f"| the best for each warp | {rms(best) * 1e3:.2f} |")
    whole = rms(ours) / min(rms(errors) for errors in by_name.values())
    print(
        f"ours by the best interpolator of all warps: {whole:.2f}; by the best for each warp: median "
        f"{np.median(ratios):.2f}, worst {ratios.max():.2f}, over {MOST} in {int((ratios > MOST).sum())} of {len(ratios)}"
    )
    return whole <= MOST


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("bench")
    parser.add_argument("--queries", type=int, default=1_000_000)
    arguments = parser.parse_args()
    warnings.filterwarnings("ignore")  # of splines that could smooth more
    is_good = accuracy(arguments.bench)
    speed(arguments.bench, arguments.queries)
    sys.exit(0 if is_good else 1)


if __name__ == "__main__":
    main()
