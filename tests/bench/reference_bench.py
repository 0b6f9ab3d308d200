#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Locates targets in pictures of the reference simulator and holds the answers against their truth.

  /usr/bin/python3 tests/bench/reference_bench.py PANELCAL CELL[,CELL...] [-n N] [--seed S] [--jobs J]

A cell is one of tests/reference/render.py, "grain" or "grain:hole"; "effects" are all of them for a
disc, "empty" all those without a target. A row tells, of N pictures: how many were found; the
normalised squared error per degree of freedom (nse: 1 is an honest covariance) and its band of 99 %
by chance; how many errors lie in their 95 % ellipse; the root mean square error of a coordinate; the
largest error in sigmas, and how many exceed 5; finds without a target; the commonest refusal.
"""

import argparse
import collections
import concurrent.futures
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np

RENDER = os.path.join(os.path.dirname(__file__), "..", "reference", "render.py")
SEARCH_RADIUS_PX = 15
FAR_SIGMAS = 5


def cell_names():
    """Cells of discs, and those without a target."""
    lines = subprocess.run([sys.executable, RENDER, "cells"], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    names = [line.split()[0] for line in lines if line and not line[0].isspace()]
    return ([n for n in names if not n.startswith("empty")],
            [n for n in names if n.startswith("empty")])


def expanded(cells):
    effects, empty = cell_names()
    names = []
    for cell in cells.split(","):
        names += {"effects": effects, "empty": empty}.get(cell, [cell])
    return names


def locate(panelcal, folder, truth):
    x, y = truth["at_px"]
    picture = os.path.join(folder, truth["file"])
    machine = os.path.join(os.path.dirname(picture), "machine.toml")
    done = subprocess.run(
        [panelcal, "locate", picture, "--tool", str(truth["tool"]), "-m", machine,
         "--at", f"{x},{y}", "--radius", str(SEARCH_RADIUS_PX)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"panelcal failed on {picture}: {done.stderr}")
    return json.loads(done.stdout.splitlines()[0])


def squared_distance(answer, truth):
    """Squared error in px^2, and over its covariance."""
    error = np.subtract(answer["center_px"], truth["centre_px"])
    xx, xy, yy = answer["cov_px"]
    return error @ error, error @ np.linalg.solve([[xx, xy], [xy, yy]], error)


def shape_of(reason):
    return "".join("#" if c.isdigit() else c for c in reason)[:60]


def row_of(name, truths, answers):
    errors2, chi2, n_false = [], [], 0
    refusals = collections.Counter()
    for truth, answer in zip(truths, answers):
        if answer["status"] != "found":
            refusals[shape_of(answer.get("reason", answer["status"]))] += 1
        elif not truth["has_target"]:
            n_false += 1
        else:
            e2, c2 = squared_distance(answer, truth)
            errors2.append(e2)
            chi2.append(c2)
    n, n_found = len(truths), len(chi2)
    return {"cell": name, "n": n, "found": n_found, "false": n_false, "errors2": errors2,
            "chi2": chi2, "refusal": refusals.most_common(1)[0] if refusals else ("", 0)}


def print_row(row):
    n_found = row["found"]
    text = f"{row['cell']:<24}{row['n']:>6}{100 * n_found / row['n']:>8.1f}"
    if n_found:
        chi2 = np.array(row["chi2"])
        band = 2.576 * math.sqrt(1 / n_found)  # a chi square of two degrees, halved
        held = np.mean(chi2 < -2 * math.log(0.05))
        text += (f"{chi2.mean() / 2:>8.2f} +-{band:<5.2f}{100 * held:>7.1f}"
                 f"{math.sqrt(np.mean(row['errors2']) / 2):>9.4f}{math.sqrt(chi2.max()):>8.1f}"
                 f"{np.sum(chi2 > FAR_SIGMAS**2):>5}")
    else:
        text += " " * 46
    reason, count = row["refusal"]
    print(text + f"{row['false']:>6}  {f'{count} x {reason}' if count else ''}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("panelcal")
    parser.add_argument("cells")
    parser.add_argument("-n", type=int, default=300)
    parser.add_argument("--seed", type=int, default=20261123)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", help="folder for the pictures; those that are there are used again")
    args = parser.parse_args()
    print(f"{'cell':<24}{'n':>6}{'found%':>8}{'nse':>8}{'':>8}{'in 95%':>7}{'rms px':>9}"
          f"{'worst':>8}{'>5':>5}{'false':>6}  refused", flush=True)
    rows = []
    with tempfile.TemporaryDirectory() as scratch, \
            concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for name in expanded(args.cells):
            folder = os.path.join(args.keep or scratch,
                                  f"{name.replace(':', '-')}-{args.seed}-{args.n}")
            if not os.path.exists(os.path.join(folder, "truth.jsonl")):
                subprocess.run([sys.executable, RENDER, "set", "--cell", name, "-n", str(args.n),
                                "--seed", str(args.seed), "--jobs", str(args.jobs), "-o", folder],
                               check=True, capture_output=True)
            with open(os.path.join(folder, "truth.jsonl"), encoding="utf-8") as file:
                truths = [json.loads(line) for line in file]
            answers = list(pool.map(lambda t: locate(args.panelcal, folder, t), truths))
            rows.append(row_of(name, truths, answers))
            print_row(rows[-1])
    if len(rows) > 1:
        print_row({"cell": "all", "n": sum(r["n"] for r in rows),
                   "found": sum(r["found"] for r in rows), "false": sum(r["false"] for r in rows),
                   "errors2": sum((r["errors2"] for r in rows), []),
                   "chi2": sum((r["chi2"] for r in rows), []), "refusal": ("", 0)})


if __name__ == "__main__":
    main()
