#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Heights of clamped, warped circuit boards and their probes, with the truth.

Written from the mechanics of plates and tables, not from panelcal's model of a surface: no Gaussian
process, no covariance and no constant is shared. numpy only; a seed gives the same boards always.

  boards.py set -o FOLDER --seed 1 [--per-cell 15] [--places 400]

writes for each board FOLDER/KIND_N_I.jsonl (probe readings, docs/formats/probes.md) and
FOLDER/KIND_N_I.json (kind, places in the probes' hull with true heights, wild probes).

Heights are mm above the table, places mm, probes' scatter is normal and stated as it is.
"""

import argparse
import json
import os
import zlib

import numpy as np

KINDS = ("smooth", "twist", "step", "valley", "ripple", "rough", "wild")
COUNTS = (9, 25, 60, 120)
THICKNESS_MM = 1.6
GRIDS = {9: (3, 3), 25: (5, 5), 60: (10, 6), 120: (12, 10)}


def between(rng, low, high):
    """Log-uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def direction(rng):
    angle = rng.uniform(0, 2 * np.pi)
    return np.array([np.cos(angle), np.sin(angle)])


class Board:
    """A board of a size (mm) and the parts its height adds up from, functions of places (n, 2)."""

    def __init__(self, kind, rng):
        self.kind = kind
        self.size_mm = np.array([rng.uniform(100, 400), rng.uniform(80, 300)])
        self.parts = [tilt(self, rng)]
        if kind in ("smooth", "wild"):
            self.parts += [bow(self, rng, between(rng, 0.02, 0.2)), dome(self, rng, between(rng, 0.01, 0.12))]
        elif kind == "twist":
            self.parts += [twist(self, rng), bow(self, rng, between(rng, 0.01, 0.06)), blister(self, rng)]
        elif kind == "step":
            self.parts += [bow(self, rng, between(rng, 0.01, 0.05)), step(self, rng)]
        elif kind == "valley":
            self.parts += [bow(self, rng, between(rng, 0.01, 0.05)), valley(self, rng)]
        elif kind == "ripple":
            self.parts += [bow(self, rng, between(rng, 0.01, 0.05)), ripple(self, rng)]
        elif kind == "rough":
            self.parts += [bow(self, rng, between(rng, 0.01, 0.05)), rough(self, rng)]
        else:
            raise ValueError(f"unknown kind {kind}")

    def height_mm(self, places_mm):
        return THICKNESS_MM + sum(part(np.asarray(places_mm, float)) for part in self.parts)


def tilt(board, rng):
    """A table out of level by up to 0.5 mm a metre."""
    slope = direction(rng) * rng.uniform(0, 5e-4)
    return lambda p: p @ slope


def bow(board, rng, sag_mm):
    """Copper on one side shrinks: a circular cylinder about any axis, its sag over the diagonal."""
    across, sign = direction(rng), rng.choice([-1, 1])
    half = 0.5 * np.linalg.norm(board.size_mm)
    radius_mm = (half**2 + sag_mm**2) / (2 * sag_mm)
    middle = 0.5 * board.size_mm @ across
    return lambda p: sign * (radius_mm - np.sqrt(radius_mm**2 - (p @ across - middle) ** 2))


def dome(board, rng, height_mm):
    """A plate held along its edges and pushed up by pressure below: a product of cosines, and with its
    first harmonics off the middle (Navier's solution of the plate equation)."""
    sign = rng.choice([-1, 1])
    terms = [(1, 1, 1.0), (2, 1, rng.normal() * 0.25), (1, 2, rng.normal() * 0.25), (3, 1, rng.normal() * 0.05)]

    def part(p):
        u = np.pi * p / board.size_mm
        return sign * height_mm * sum(a * np.sin(m * u[:, 0]) * np.sin(k * u[:, 1]) for m, k, a in terms)

    return part


def twist(board, rng):
    """Fibres that do not lie square: opposite corners up."""
    rise_mm = between(rng, 0.05, 0.4) * rng.choice([-1, 1])
    return lambda p: rise_mm * np.prod(2 * p / board.size_mm - 1, axis=1)


def blister(board, rng):
    """A chip or a blister under a limp board: w = A (1 + (r / a)^2)^-3/2."""
    at = board.size_mm * rng.uniform(0.2, 0.8, 2)
    radius_mm = rng.uniform(0.15, 0.4) * board.size_mm.max()
    height_mm = between(rng, 0.005, 0.05)
    return lambda p: height_mm * (1 + ((p - at) ** 2).sum(axis=1) / radius_mm**2) ** -1.5


def step(board, rng):
    """A clamp, or a second plate below, holds one side lower: a drop along a line over 0.5 to 8 mm."""
    across = direction(rng) if rng.random() < 0.3 else np.eye(2)[rng.integers(2)]
    at = board.size_mm * rng.uniform(0.25, 0.75, 2) @ across
    drop_mm, width_mm = between(rng, 0.03, 0.15), between(rng, 0.5, 8)

    def part(p):
        t = np.clip((p @ across - at) / width_mm + 0.5, 0, 1)
        return -drop_mm * t * t * (3 - 2 * t)

    return part


def valley(board, rng):
    """The board sags between two rails: a beam that is held at both sides, w = -A (1 - t^2)^2."""
    across = direction(rng) if rng.random() < 0.3 else np.eye(2)[rng.integers(2)]
    at = board.size_mm * rng.uniform(0.3, 0.7, 2) @ across
    depth_mm = between(rng, 0.03, 0.15)
    half_mm = rng.uniform(0.15, 0.45) * np.abs(board.size_mm @ np.abs(across))
    return lambda p: -depth_mm * np.clip(1 - ((p @ across - at) / half_mm) ** 2, 0, None) ** 2


def ripple(board, rng):
    """Slats or grooves of a backing board: a wave of 0.3 to 1 of the board's longer side."""
    across = direction(rng)
    wave_mm = rng.uniform(0.3, 1) * board.size_mm.max()
    height_mm, phase = between(rng, 0.005, 0.04), rng.uniform(0, 2 * np.pi)
    sharp = rng.uniform(0, 0.4)

    def part(p):
        t = 2 * np.pi * (p @ across) / wave_mm + phase
        return height_mm * (np.cos(t) + sharp * np.cos(2 * t))

    return part


def rough(board, rng):
    """Milled spoil board or cast plate: 300 plane waves whose heights fall as a power of the frequency."""
    hurst = rng.uniform(0.2, 0.9)
    cycles = np.exp(rng.uniform(np.log(0.7), np.log(40), 300)) / board.size_mm.max()
    heights = cycles**-hurst * rng.normal(size=300)
    heights *= between(rng, 0.01, 0.04) / np.sqrt(0.5 * np.sum(heights**2))
    angles, phases = rng.uniform(0, 2 * np.pi, (2, 300))
    waves = 2 * np.pi * cycles * np.array([np.cos(angles), np.sin(angles)])
    return lambda p: np.cos(p @ waves + phases) @ heights


def probe_places(board, n, is_grid, rng):
    margin = 0.03 * board.size_mm
    low, high = margin, board.size_mm - margin
    if is_grid:
        columns, rows = GRIDS[n] if board.size_mm[0] >= board.size_mm[1] else GRIDS[n][::-1]
        x, y = np.meshgrid(np.linspace(low[0], high[0], columns), np.linspace(low[1], high[1], rows))
        return np.column_stack([x.ravel(), y.ravel()])
    # An operator's choice: near the corners, then each the farthest of a handful from all so far.
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [low[0], high[1]], [high[0], high[1]]])
    places = list(corners + rng.uniform(-0.02, 0.02, (4, 2)) * board.size_mm)
    while len(places) < n:
        tries = rng.uniform(low, high, (4, 2))
        apart = np.linalg.norm(tries[:, None] - np.array(places)[None], axis=2).min(axis=1)
        places.append(tries[apart.argmax()])
    return np.array(places)


def hull(points):
    """Corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    rows = sorted(map(tuple, points))

    def half(rows):
        out = []
        for p in rows:
            while len(out) > 1 and (out[-1][0] - out[-2][0]) * (p[1] - out[-2][1]) <= (out[-1][1] - out[-2][1]) * (
                p[0] - out[-2][0]
            ):
                out.pop()
            out.append(p)
        return out[:-1]

    return np.array(half(rows) + half(rows[::-1]))


def inside(corners, p):
    side = np.roll(corners, -1, axis=0) - corners
    return np.all(
        side[:, 0] * (p[:, None, 1] - corners[:, 1]) - side[:, 1] * (p[:, None, 0] - corners[:, 0]) >= 0, axis=1
    )


def places_within(points, n, rng):
    corners, out = hull(points), np.empty((0, 2))
    while len(out) < n:
        tries = rng.uniform(points.min(axis=0), points.max(axis=0), (2 * n, 2))
        out = np.vstack([out, tries[inside(corners, tries)]])
    return out[:n]


def make(kind, n, index, seed, n_places=400):
    """A probed board: a dict of probes (n, 2), heights_mm, sigma_mm, wild, places (m, 2), truth_mm."""
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode()), n, index])
    board = Board(kind, rng)
    is_grid = index % 2 == 0
    probes = probe_places(board, n, is_grid, rng)
    sigma_mm = between(rng, 0.0015, 0.006)
    heights_mm = board.height_mm(probes) + sigma_mm * rng.normal(size=n)
    wild = []
    if kind == "wild":
        # A chip or a burr lifts the tip, a hole or a soft spot lets it down.
        wild = rng.choice(n, size=max(1, n // 30), replace=False).tolist()
        for i in wild:
            heights_mm[i] += between(rng, 0.1, 0.6) * rng.choice([-1, 1])
    places = places_within(probes, n_places, rng)
    return {
        "kind": kind,
        "n": n,
        "index": index,
        "grid": is_grid,
        "probes": probes,
        "heights_mm": heights_mm,
        "sigma_mm": sigma_mm,
        "wild": sorted(wild),
        "places": places,
        "truth_mm": board.height_mm(places),
    }


def all_boards(seed, per_cell=15, n_places=400):
    for kind in KINDS:
        for n in COUNTS:
            for index in range(per_cell):
                yield make(kind, n, index, seed, n_places)


def probe_lines(board):
    """Readings as docs/formats/probes.md has them."""
    out = []
    for i, ((x, y), z) in enumerate(zip(board["probes"], board["heights_mm"])):
        place = [round(float(x), 4), round(float(y), 4)]
        record = {"probe": i, "line": i + 1, "command": "G73", "tool": 1, "nominal": place, "expected": place, "path": []}
        record.update(reference=THICKNESS_MM, zaxis=0, height=float(z), sigma=board["sigma_mm"], status="found")
        out.append(json.dumps(record) + "\n")
    return "".join(out)


def name_of(board):
    return f"{board['kind']}_{board['n']}_{board['index']:02}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("set", help="write boards")
    command.add_argument("-o", "--output", required=True)
    command.add_argument("--seed", type=int, default=1)
    command.add_argument("--per-cell", type=int, default=15)
    command.add_argument("--places", type=int, default=400)
    arguments = parser.parse_args()
    os.makedirs(arguments.output, exist_ok=True)
    for board in all_boards(arguments.seed, arguments.per_cell, arguments.places):
        path = os.path.join(arguments.output, name_of(board))
        with open(path + ".jsonl", "w", encoding="ascii") as file:
            file.write(probe_lines(board))
        truth = {key: board[key] for key in ("kind", "n", "index", "grid", "wild", "sigma_mm")}
        truth["places"] = board["places"].tolist()
        truth["truth_mm"] = board["truth_mm"].tolist()
        with open(path + ".json", "w", encoding="ascii") as file:
            json.dump(truth, file)


if __name__ == "__main__":
    main()
