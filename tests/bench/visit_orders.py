#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Orders of visits that `panelcal plan` proposes, held against another search.

    visit_orders.py PANELCAL

Targets lie at random in 490 x 390 mm, one series. Up to 12 targets the peer is exact (Held and Karp 1962), beyond that
the best of many local searches (2-opt, and pieces of up to three targets moved or turned; Lin 1965, Or 1976), restarted
by exchanging two pieces of the best way.
"""
import json
import math
import random
import subprocess
import sys
import tempfile
from pathlib import Path


def visits(panelcal, folder, places):
    """What plan says of the orders of visits."""
    marks = "".join(f"G36X{x:.3f}Y{y:.3f}\n" for x, y in places)
    (folder / "p.exc").write_text(f"M48\nMETRIC,LZ\nFMAT,2\nT1C1.0\n%\nG90\nG34,1\n{marks}T1\nX10.0Y10.0\nM30\n")
    (folder / "m.toml").write_text(
        f'[vision]\nrotate = {len(places)}\nmodel = "stretch"\n'
        '[[vision.tool]]\nnumber = 1\nshape = "disc"\nsize_px = 40\npolarity = "bright"\n')
    done = subprocess.run([panelcal, "plan", "p.exc", "-m", "m.toml", "--json", "-"], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return json.loads(done.stdout)["visits"]


def shortest_mm(places):
    """Length of the shortest way through all places, wherever it begins."""
    n = len(places)
    best = [[math.inf] * n for _ in range(1 << n)]
    for i in range(n):
        best[1 << i][i] = 0
    for seen in range(1 << n):
        for last in range(n):
            so_far = best[seen][last]
            if so_far == math.inf:
                continue
            for to in range(n):
                if not seen >> to & 1:
                    at = best[seen | 1 << to]
                    at[to] = min(at[to], so_far + math.dist(places[last], places[to]))
    return min(best[-1])


def length_mm(places, way):
    return sum(math.dist(places[a], places[b]) for a, b in zip(way, way[1:]))


def neighbours(way):
    """Ways that one change makes: a piece turned, or a piece of up to three moved."""
    n = len(way)
    for i in range(n - 1):
        for j in range(i + 2, n + 1):
            yield way[:i] + way[i:j][::-1] + way[j:]
    for size in (1, 2, 3):
        for i in range(n - size + 1):
            piece, rest = way[i:i + size], way[:i] + way[i + size:]
            for k in range(len(rest) + 1):
                yield rest[:k] + piece + rest[k:]
                yield rest[:k] + piece[::-1] + rest[k:]


def improved(places, way):
    """The local optimum that the first better neighbour leads to, again and again."""
    best_mm = length_mm(places, way)
    while True:
        better = next((w for w in neighbours(way) if length_mm(places, w) < best_mm - 1e-9), None)
        if better is None:
            return way
        way, best_mm = better, length_mm(places, better)


def searched_mm(places, rng, n_starts):
    n = len(places)
    best = improved(places, rng.sample(range(n), n))
    for _ in range(n_starts):
        i, j, k = sorted(rng.sample(range(1, n), 3))
        way = improved(places, best[:i] + best[j:k] + best[i:j] + best[k:])
        best = min(best, way, key=lambda w: length_mm(places, w))
    return length_mm(places, best)


def main():
    panelcal = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        for n, n_layouts in ((6, 6), (9, 6), (10, 4), (12, 2), (21, 3), (50, 2)):
            rng = random.Random(n)
            for _ in range(n_layouts):
                places = [(round(rng.uniform(5, 495), 3), round(rng.uniform(5, 395), 3)) for _ in range(n)]
                plan = visits(panelcal, Path(folder), places)
                peer_mm = shortest_mm(places) if n <= 12 else searched_mm(places, rng, 40 if n == 21 else 10)
                print(f"{n} targets: within the series {plan['within_series_mm'] / peer_mm:.6f}, free "
                      f"{plan['free_mm'] / peer_mm:.6f} times the peer's way; as programmed "
                      f"{plan['programmed_mm'] / peer_mm:.2f}; said to be the shortest: {plan['exact']}", flush=True)


if __name__ == "__main__":
    main()
