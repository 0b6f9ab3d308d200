#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether the sigma of a surface holds on boards that panelcal's authors did not draw.

`panelcal surface fit` and `query` on the boards of tests/reference/boards.py: coverage within 1.96
sigma by kind of board and by number of probes, wild boards with the wild probe left out or not, the
worst distance of a map from a probe that it kept (by sigma of both), and the root mean square error
by that of the best of scipy's three interpolators (thin plate and cubic RBF, linear) on that board.

  /usr/bin/python3 tests/bench/surface_coverage.py build/release/tools/panelcal --seed 7 [--per-cell 15] [--jobs 2]

--estimates build/release/tests/reference/surface_estimates instead of panelcal: the surfaces themselves, without the lattice of a map, in a fraction of the time.

--check: exit 1 if a goal of tests/bench/README.md is missed.
"""

import argparse
import concurrent.futures
import importlib.util
import base64
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "reference"))
import boards as reference  # noqa: E402

WITHIN = 1.96
GOAL_COVERED = 0.92
GOAL_OFF = 4.5
SMOOTH = ("smooth", "twist")


def peers(board, known):
    from scipy import interpolate

    keep = np.setdiff1d(np.arange(board["n"]), board["wild"])
    xy, z = board["probes"][keep], board["heights_mm"][keep]
    out = []
    for kernel in ("thin_plate_spline", "cubic"):
        out.append(interpolate.RBFInterpolator(xy, z, kernel=kernel)(board["places"]))
    linear = interpolate.LinearNDInterpolator(xy, z)(board["places"])
    nearest = interpolate.NearestNDInterpolator(xy, z)(board["places"])
    out.append(np.where(np.isnan(linear), nearest, linear))
    return [rms((found - board["truth_mm"])[known]) for found in out]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def ask(panelcal, map_file, places):
    text = "".join(f"{x!r},{y!r}\n" for x, y in places.tolist())
    run = subprocess.run(
        [panelcal, "surface", "query", map_file, "-", "--json", "-"], input=text, capture_output=True, text=True, check=False
    )
    table = json.loads(run.stdout)["places"]
    # Long columns are packed, and a refused place has none of both.
    height_mm, sigma_um = (
        np.frombuffer(base64.b64decode(table[key]["base64"]), "<f4") if isinstance(table[key], dict) else np.array(table[key], float)
        for key in ("height_mm", "sigma_um")
    )
    return np.column_stack([height_mm, sigma_um / 1e3]).tolist()


def by_command(panelcal, board):
    """Answer of surface_estimates.cc, by `surface fit` and `query`."""
    with tempfile.TemporaryDirectory() as folder:
        probes, map_file = os.path.join(folder, "probes.jsonl"), os.path.join(folder, "map.json")
        with open(probes, "w", encoding="ascii") as file:
            file.write(reference.probe_lines(board))
        made = subprocess.run(
            [panelcal, "surface", "fit", probes, "-o", map_file, "--json", "-"], capture_output=True, text=True, check=False
        )
        if made.returncode != 0:
            return {"refused": made.stderr.strip()}
        facts = json.loads(made.stdout)["zones"][0]
        left_out = [one["line"] - 1 for one in facts["left_out"]]
        kept = np.setdiff1d(np.arange(board["n"]), left_out)
        found = ask(panelcal, map_file, np.vstack([board["places"], np.round(board["probes"][kept], 4)]))
    n_places = len(board["places"])
    answer = {key: facts[key] for key in ("model", "summary", "reason")}
    return answer | {"left_out": left_out, "places": found[:n_places], "probes": found[n_places:]}


def by_library(estimates, boards):
    """Answers of surface_estimates.cc."""
    text = []
    for board in boards:
        text.append(f"{board['n']} {len(board['places'])}")
        probes = np.round(board["probes"], 4).tolist()
        text += [f"{x!r} {y!r} {z!r} {float(board['sigma_mm'])!r}" for (x, y), z in zip(probes, board["heights_mm"].tolist())]
        text += [f"{x!r} {y!r}" for x, y in board["places"].tolist()]
    run = subprocess.run([estimates], input="\n".join(text) + "\n", capture_output=True, text=True, check=True)
    return [json.loads(line) for line in run.stdout.splitlines()]


def judged(cell, board, answer, has_peers):
    kind, n, index = cell
    out = {"kind": kind, "n": n, "index": index, "grid": board["grid"], "refused": answer.get("refused", "")}
    if out["refused"]:
        return out
    out.update((key, answer[key]) for key in ("model", "summary", "reason"))
    left_out = set(answer["left_out"])
    out["found"] = len(left_out & set(board["wild"])), len(board["wild"]), len(left_out - set(board["wild"]))
    height, sigma = np.array(answer["places"], float).T
    kept = [i for i in range(n) if i not in left_out]
    at_probe, sigma_there = np.array(answer["probes"], float).T
    # A place outside of the hull of what is left without a wild corner may be refused.
    known = np.isfinite(height)
    sigma, error = sigma[known], (height - board["truth_mm"])[known]
    out["places"] = len(error)
    out["covered"] = int(np.sum(np.abs(error) <= WITHIN * sigma))
    off = (board["heights_mm"][kept] - at_probe) / np.hypot(sigma_there, board["sigma_mm"])
    out["off"] = float(np.max(np.abs(off)))
    out["rms_um"] = 1e3 * rms(error)
    out["sigma_um"] = 1e3 * rms(sigma)
    out["best_um"] = 1e3 * min(peers(board, known)) if has_peers else float("nan")
    return out


def row(name, boards):
    made = [b for b in boards if not b["refused"]]
    covered = sum(b["covered"] for b in made) / max(1, sum(b["places"] for b in made))
    ratio = np.exp(np.mean([np.log(b["rms_um"] / b["best_um"]) for b in made])) if made else np.nan
    pooled = rms([b["rms_um"] for b in made]) / rms([b["best_um"] for b in made]) if made else np.nan
    worst = max((b["off"] for b in made), default=np.nan)
    over = sum(b["rms_um"] > 2 * b["sigma_um"] for b in made)
    by_sigma = np.median([b["sigma_um"] / b["rms_um"] for b in made]) if made else np.nan
    print(
        f"| {name} | {len(boards)} | {len(boards) - len(made)} | {100 * covered:.1f} | {worst:.2f} | {over} | "
        f"{ratio:.2f} | {pooled:.2f} | {by_sigma:.2f} |"
    )
    return covered, worst


def table(results):
    print("| boards | number | refused | % within 1.96 sigma | worst off a kept probe, sigma | rms over 2 sigma | rms / best of scipy | pooled | sigma / rms, median |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    rows = {}
    for kind in reference.KINDS:
        rows[kind] = row(kind, [b for b in results if b["kind"] == kind])
    for n in reference.COUNTS:
        rows[n] = row(f"{n} probes", [b for b in results if b["n"] == n])
    for kind in reference.KINDS:
        for n in reference.COUNTS:
            row(f"{kind}, {n}", [b for b in results if b["kind"] == kind and b["n"] == n])
    row("grids", [b for b in results if b["grid"]])
    row("scattered", [b for b in results if not b["grid"]])
    row("smooth and twist", [b for b in results if b["kind"] in SMOOTH])
    row("all", results)
    wild = [b for b in results if b["kind"] == "wild" and not b["refused"]]
    print(f"\nwild probes: {sum(b['found'][0] for b in wild)} of {sum(b['found'][1] for b in wild)} named")
    made = [b for b in results if not b["refused"]]
    print(f"good probes called wild: {sum(b['found'][2] for b in made)} on {sum(b['found'][2] > 0 for b in made)} of {len(made)} boards")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("panelcal", nargs="?")
    parser.add_argument("--estimates", help="the program surface_estimates")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--per-cell", type=int, default=15)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--no-peers", action="store_true", help="without scipy's columns")
    parser.add_argument("--output", help="one line of JSON a board")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    if bool(arguments.panelcal) == bool(arguments.estimates):
        parser.error("either panelcal or --estimates")
    has_peers = not arguments.no_peers and importlib.util.find_spec("scipy") is not None
    cells = [(kind, n, i) for kind in reference.KINDS for n in reference.COUNTS for i in range(arguments.per_cell)]
    boards = [reference.make(*cell, arguments.seed) for cell in cells]
    if arguments.estimates:
        answers = by_library(arguments.estimates, boards)
    else:
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            answers = list(pool.map(lambda board: by_command(arguments.panelcal, board), boards))
    results = [judged(*one, has_peers) for one in zip(cells, boards, answers, strict=True)]
    if arguments.output:
        with open(arguments.output, "w", encoding="utf-8") as file:
            file.writelines(json.dumps(result) + "\n" for result in results)
    rows = table(results)
    refused = sum(bool(b["refused"]) for b in results)
    bad = [name for name, (covered, worst) in rows.items() if covered < GOAL_COVERED or worst > GOAL_OFF]
    if bad:
        print(f"missed: {', '.join(map(str, bad))}; {refused} refused")
    sys.exit(1 if arguments.check and bad else 0)


if __name__ == "__main__":
    main()
