#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether the sigma of a surface of few probes holds, be it bent or one of its probes wild.

Grids of 3 x 3 to 5 x 5 probes on boards of 100 to 300 mm, level to 0.5 mm a metre: domes clamped
along all their edges and saddles of 0.02 to 0.3 mm, and flat boards with one wild probe, 0.1 to 1
mm off. Nine probes show the middle of such a dome just as a wild probe: sigma has to hold for both.

  /usr/bin/python3 tests/bench/few_probes_coverage.py build/release/tests/reference/surface_estimates --seed 1 [--per-cell 200]

--check: exit 1 if a kind covers less than 92 %, or a map is more than 4.5 sigma off a kept probe.
"""

import argparse
import json
import subprocess
import sys

import numpy as np

KINDS = ("dome", "saddle", "wild")
GRIDS = ((3, 3), (3, 4), (4, 4), (5, 5))
WITHIN = 1.96
GOAL_COVERED = 0.92
GOAL_OFF = 4.5


def between(rng, low, high):
    """Log-uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def lattice(size_mm, columns, rows):
    x, y = np.meshgrid(np.linspace(0, size_mm[0], columns), np.linspace(0, size_mm[1], rows))
    return np.column_stack([x.ravel(), y.ravel()])


def draw(rng, kind, grid):
    size_mm, slope = rng.uniform(100, 300, 2), rng.uniform(-5e-4, 5e-4, 2)
    bend_mm = between(rng, 0.02, 0.3) * rng.choice([-1, 1])

    def height_mm(places_mm):
        u, v = (places_mm / size_mm).T
        flat = 1.6 + places_mm @ slope
        if kind == "dome":
            return flat + bend_mm * np.sin(np.pi * u) * np.sin(np.pi * v)
        return flat + bend_mm * ((2 * u - 1) ** 2 - (2 * v - 1) ** 2) if kind == "saddle" else flat

    sigma_mm = float(rng.uniform(0.0015, 0.006))
    probes_mm = np.round(lattice(size_mm, *grid), 4)
    heights_mm = height_mm(probes_mm) + rng.normal(0, sigma_mm, len(probes_mm))
    wild = None
    if kind == "wild":
        wild = int(rng.integers(len(probes_mm)))
        heights_mm[wild] += between(rng, 0.1, 1) * rng.choice([-1, 1])
    places_mm = lattice(size_mm, 13, 13)
    return {"probes": probes_mm, "heights": heights_mm, "sigma": sigma_mm, "wild": wild, "places": places_mm, "truth": height_mm(places_mm)}


def answers(estimates, boards):
    text = []
    for board in boards:
        text.append(f"{len(board['probes'])} {len(board['places'])}")
        text += [f"{x!r} {y!r} {z!r} {board['sigma']!r}" for (x, y), z in zip(board["probes"].tolist(), board["heights"].tolist())]
        text += [f"{x!r} {y!r}" for x, y in board["places"].tolist()]
    run = subprocess.run([estimates], input="\n".join(text) + "\n", capture_output=True, text=True, check=True)
    return [json.loads(line) for line in run.stdout.splitlines()]


def judged(board, answer):
    if "refused" in answer:
        return None
    height, sigma = np.array(answer["places"]).T
    at_probe, sigma_there = np.array(answer["probes"]).T
    left_out = set(answer["left_out"])
    kept = [i for i in range(len(board["probes"])) if i not in left_out]
    z = np.abs(height - board["truth"]) / sigma
    off = np.abs(board["heights"][kept] - at_probe) / np.hypot(sigma_there, board["sigma"])
    return {
        "covered": float(np.mean(z <= WITHIN)),
        "z": float(np.max(z)),
        "off": float(np.max(off)),
        "sigma_um": 1e3 * float(np.median(sigma)),
        "denied": bool(left_out - {board["wild"]}),
        "named": board["wild"] in left_out,
        "doubt": "cannot tell a wild" in answer["reason"],
    }


def row(name, cell):
    made = [one for one in cell if one]
    covered = float(np.mean([one["covered"] for one in made]))
    off = max(one["off"] for one in made)
    print(
        f"| {name} | {len(cell) - len(made)} | {100 * covered:.1f} | {max(one['z'] for one in made):.1f} | {off:.2f} | "
        f"{sum(one['denied'] for one in made)} | {sum(one['named'] for one in made)} | {sum(one['doubt'] for one in made)} | "
        f"{np.median([one['sigma_um'] for one in made]):.0f} |"
    )
    return covered, off


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("estimates", help="the program surface_estimates")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--per-cell", type=int, default=200)
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    print("| boards | refused | % within 1.96 sigma | worst z | worst off a kept probe | good probe denied | wild one named | doubt said | median sigma, um |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    is_good, pooled = True, []
    for kind in KINDS:
        of_kind = []
        for grid in GRIDS:
            rng = np.random.default_rng([arguments.seed, KINDS.index(kind), *grid])
            boards = [draw(rng, kind, grid) for _ in range(arguments.per_cell)]
            cell = [judged(*one) for one in zip(boards, answers(arguments.estimates, boards), strict=True)]
            row(f"{kind}, {grid[0]} x {grid[1]}", cell)
            of_kind += cell
        covered, off = row(f"all of {kind}", of_kind)
        is_good = is_good and covered >= GOAL_COVERED and off <= GOAL_OFF
        pooled += of_kind
    row("all", pooled)
    sys.exit(1 if arguments.check and not is_good else 0)


if __name__ == "__main__":
    main()
