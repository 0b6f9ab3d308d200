#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each command block of the manual's tutorials runs, prints what the page shows, and gives the page its pictures.

The holes of the KiCad tutorial lie where the virtual board has them, by the equations of docs/formulation.md.

    tutorials_test.py PANELCAL ROOT PAGE
"""
import math
import shutil
import sys
import tempfile
from pathlib import Path

PANELCAL, ROOT = (Path(word).resolve() for word in sys.argv[1:3])
PAGE = ROOT / "docs" / sys.argv[3]
sys.path[:0] = [str(ROOT / folder) for folder in ("tools/site", "tests/tools")]
sys.dont_write_bytecode = True
from gcode_test import cuts, walk  # noqa: E402
from tutorials import PICTURE, Wrong, pages_of, run_page  # noqa: E402

SKIP = 77
LONGEST_ERROR_MM = 0.005  # of the fit, at 20 um per pixel
# What the page writes into [sim].
OFFSET_MM, ROTATION_RAD, STRETCH = (0.31, -0.22), 3e-3, (250e-6, -150e-6)


def actual(nominal):
    """R(rotation) diag(scale) nominal + offset."""
    x, y = nominal[0] * (1 + STRETCH[0]), nominal[1] * (1 + STRETCH[1])
    cos, sin = math.cos(ROTATION_RAD), math.sin(ROTATION_RAD)
    return cos * x - sin * y + OFFSET_MM[0], sin * x + cos * y + OFFSET_MM[1]


def holes_of(drill_file):
    for line in drill_file.read_text().splitlines():
        if line.startswith("X"):
            yield tuple(float(word) for word in line[1:].split("Y"))


def check_kicad(folder):
    for drill_file, program, n in (("board-PTH.drl", "plated.ngc", 60), ("board-NPTH.drl", "unplated.ngc", 4)):
        wanted = sorted(actual(hole) for hole in holes_of(folder / drill_file))
        drilled = sorted(place[:2] for word, place in cuts(walk(folder / program, "grbl")) if word == "down")
        assert len(drilled) == n, (program, len(drilled))
        for a in drilled:
            error_mm = min(math.dist(a, b) for b in wanted)
            assert error_mm < LONGEST_ERROR_MM, (program, a, error_mm)


def refuses(page_text, words):
    """The test itself: a page that is wrong is noticed."""
    with tempfile.TemporaryDirectory() as name:
        page = Path(name) / "page.md"
        page.write_text(page_text)
        try:
            run_page(PANELCAL, ROOT, page, Path(name))
        except Wrong as problem:
            assert words in str(problem), problem
            return
    raise AssertionError(f"not noticed: {page_text}")


def main():
    if sys.argv[3] == "wrong":
        refuses("```sh\nfalse\n```\n", "exit code 1")
        refuses("```sh\necho 1.00\n```\n```text\n2.00\n```\n", "do not print")
        refuses("```sh\necho 1\n```\n```text\n2\n```\n", "do not print")
        refuses("```\npanelcal\n```\n", "expected sh or text")
        refuses("<!-- picture: seen.png -->\n![A disc](pictures/seen.png)\n", "no command wrote")
        refuses("![A disc](pictures/seen.png)\n", "are missing")
        return 0
    assert PAGE in pages_of(ROOT), PAGE
    if PICTURE.search(PAGE.read_text()) and not shutil.which("chromium"):
        print("SKIP: chromium is not installed (tools/packages.txt, test)")
        return SKIP
    with tempfile.TemporaryDirectory() as pictures:
        print(run_page(PANELCAL, ROOT, PAGE, Path(pictures), check_kicad if PAGE.stem == "kicad" else lambda _: None))
    return 0


if __name__ == "__main__":
    sys.exit(main())
