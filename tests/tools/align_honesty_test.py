#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Over 60 random panels the 95 % ellipses that `run --align` predicts hold 92 to 98 % of the true places, none
is beyond 5 sigma, and sigma stays below 5 um at 10 um per pixel.

    align_honesty_test.py PANELCAL
"""
import math
import sys
import tempfile
from pathlib import Path

from aligned_panel import PADS, SIGMA_LIMIT_UM, Panel, prepare
from demo_job import drilled, run

PANELS = 60
ELLIPSE_95 = 5.991  # chi square of two degrees of freedom


def squares_of(panelcal, folder, panel):
    """Of each hole's error, in sigmas of its ellipse, which is nearly upright here; and the largest sigma."""
    prepare(folder, panel)
    run(panelcal, "align", ";".join(f"{x},{y}" for x, y in PADS), "-m", "machine.toml", "--machine-driver", "sim",
        "-o", "board.align.json", cwd=folder)
    squares, largest = [], 0
    for program in ("pth.drl", "npth.drl"):
        run(panelcal, "run", program, "-m", "machine.toml", "--align", "board.align.json", "-o", "out.jsonl",
            cwd=folder)
        for hole in drilled(folder / "out.jsonl"):
            true = panel.actual(hole["nominal"])
            squares.append(sum(((a - t) / s) ** 2 for a, t, s in zip(hole["actual"], true, hole["sigma"])))
            largest = max(largest, *hole["sigma"])
    return squares, largest


def main():
    panelcal = str(Path(sys.argv[1]).resolve())
    squares, largest = [], 0
    for seed in range(PANELS):
        with tempfile.TemporaryDirectory() as folder:
            of_panel, sigma = squares_of(panelcal, Path(folder), Panel(seed))
            squares += of_panel
            largest = max(largest, sigma)
    share = sum(square < ELLIPSE_95 for square in squares) / len(squares)
    print(f"{len(squares)} holes of {PANELS} panels: {share:.1%} within the 95 % ellipse, the worst "
          f"{math.sqrt(max(squares)):.2f} sigma off, chi square {sum(squares) / 2 / len(squares):.2f}, sigma at most "
          f"{largest * 1e3:.3f} um")
    assert 0.92 <= share <= 0.98, share
    assert max(squares) < 25
    assert largest * 1e3 < SIGMA_LIMIT_UM


if __name__ == "__main__":
    main()
