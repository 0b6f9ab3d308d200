#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`panelcal surface` against least squares by hand, and against itself where that is all there is.

    surface_test.py PANELCAL ROOT
"""
import json
import math
import sys
import tempfile
from pathlib import Path
from xml.etree import ElementTree

from demo_job import run

SVG = "{http://www.w3.org/2000/svg}"


def solve(a, b):
    """Gaussian elimination with pivots."""
    n = len(a)
    rows = [list(row) + [value] for row, value in zip(a, b)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(n):
            if k == i:
                continue
            factor = rows[k][i] / rows[i][i]
            rows[k] = [x - factor * y for x, y in zip(rows[k], rows[i])]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def plane_of(probes):
    """Height and sigma at a place, of z = a + b x + c y by weighted least squares; the probes' stated sigma is believed."""
    normal = [[0.0] * 3 for _ in range(3)]
    right = [0.0] * 3
    for x, y, z, sigma in probes:
        row = (1, x, y)
        for i in range(3):
            right[i] += row[i] * z / sigma**2
            for j in range(3):
                normal[i][j] += row[i] * row[j] / sigma**2
    a = solve(normal, right)

    def at(x, y):
        t = (1, x, y)
        variance = sum(u * v for u, v in zip(t, solve(normal, t)))
        return a[0] + a[1] * x + a[2] * y, math.sqrt(variance)

    return at


def read(file):
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    return [(*line["nominal"], line["height"], line["sigma"]) for line in lines]


def pictures(panelcal, probes, folder):
    """Every probe is in the picture: as one that makes the map, as left out, or as missing."""
    svg, page = folder / "map.svg", folder / "map.html"
    said = run(panelcal, "surface", "fit", probes, "-o", folder / "wild.json", "--plot", svg,
               "--report", page).stdout
    assert f"{probes}:17: " in said and " 0.41" in said, said
    assert f"{probes}:25: " in said and "(40.000, 36.000)" in said, said
    for file in (svg, page):
        root = ElementTree.parse(file).getroot()
        drawn = [element.get("class") for element in root.iter()]
        # In both pictures, heights and sigmas.
        assert drawn.count("probe") == 2 * 40, drawn.count("probe")
        assert drawn.count("missing") == 2
        crosses = [element for element in root.iter(SVG + "path")
                   if element.get("class") == "wrong"]
        assert len(crosses) == 2
        assert drawn.count("figure") > 10
    return folder / "wild.json"


def exports(panelcal, map_file, folder):
    """What is written for others has the map's heights, counted from --zero, when read again:
    within rounding (1 um in heightmap.csv) and the lattice's tenth of sigma."""
    at_zero = json.loads(run(panelcal, "surface", "query", map_file, "10,10", "--json").stdout)
    answers = run(panelcal, "surface", "query", map_file, "--grid", "7x6", "--json").stdout
    wanted = {tuple(answer["place"]): answer["height"] - at_zero["height"]
              for answer in map(json.loads, answers.splitlines())}
    for name in ("x.csv", "x.probe", "x.hmap"):
        run(panelcal, "surface", "export", map_file, "--grid", "7x6", "--zero", "10,10", "-o",
            folder / name)
        run(panelcal, "surface", "fit", folder / name, "--model", "bilinear", "-o",
            folder / "again.json")
        found = run(panelcal, "surface", "query", folder / "again.json", "--grid", "7x6",
                    "--json").stdout
        for answer in map(json.loads, found.splitlines()):
            height = wanted[tuple(answer["place"])]
            assert abs(answer["height"] - height) < 1e-3, (name, answer, height)


def format_files(panelcal, root, probes, folder):
    """A file beside programs that has decided their number format is one source of a picture, named once."""
    (folder / "nc_param.txt").write_text("OUTPUT-UNITS METRIC\nINTEGER-PLACES 3\nDECIMAL-PLACES 3\n"
                                         "SUPPRESS-LEAD-ZEROES YES\n")
    for name in ("a.drl", "b.drl"):
        (folder / name).write_text("T1C0.8F100\nX3000Y3000\nX13000Y23000\nM30\n")
    machine = Path(root) / "tests/golden/fixtures/drill-1/machine.toml"
    plot = folder / "formats.svg"

    def beside():
        return [line.split(":")[0] for line in plot.read_text().splitlines() if "nc_param.txt: " in line]

    wanted = [f"sha256 {folder / 'nc_param.txt'}"]
    run(panelcal, "surface", "fit", probes, "--voids-of", folder / "a.drl", "--voids-of",
        folder / "b.drl", "-m", machine, "-o", folder / "formats.json", "--plot", plot)
    assert beside() == wanted, beside()
    run(panelcal, "surface", "plan", folder / "formats.json", "--program", folder / "a.drl", "-m",
        machine, "--tolerance-um", 20, "-o", folder / "formats.csv", "--plot", plot)
    assert beside() == wanted, beside()


def main():
    panelcal, root = sys.argv[1:]
    data = Path(root) / "tests/tools/surface"
    probes = data / "plane.jsonl"
    with tempfile.TemporaryDirectory() as folder:
        map_file = Path(folder) / "map.json"
        said = json.loads(run(panelcal, "surface", "fit", probes, "-o", map_file, "--model", "plane",
                              "--json").stdout)
        answers = run(panelcal, "surface", "query", map_file, "--grid", "9x7", "--json").stdout
        plane = plane_of(read(probes))
        answers = [json.loads(line) for line in answers.splitlines()]
        assert len(answers) == 63
        for answer in answers:
            height, sigma = plane(*answer["place"])
            assert abs(answer["height"] - height) < said["lattice_error"] + 1e-9, answer
            # Between the lattice's nodes sigma is a little more than it must be.
            assert 0 <= answer["sigma"] / sigma - 1 + 1e-6 < 0.01, (answer, sigma)
        corner = plane(0, 0)
        assert abs(said["worst_sigma"]["value"] / corner[1] - 1) < 0.01

        # A program's places, standard input and arguments are one way to ask.
        grid = [line["place"] for line in answers]
        asked = "".join(f"{x},{y}\n" for x, y in grid)
        again = run(panelcal, "surface", "query", map_file, "-", "--json", input=asked).stdout
        assert [json.loads(line) for line in again.splitlines()] == answers

        # A log of LinuxCNC, which states no sigma, makes the same map.
        log = Path(folder) / "probes.txt"
        log.write_text("".join(f"{x} {y} {z}\n" for x, y, z, _ in read(probes)))
        of_log = Path(folder) / "log.json"
        run(panelcal, "surface", "fit", log, "--format", "linuxcnc", "--sigma-um", 3, "--model",
            "plane", "-o", of_log)
        again = run(panelcal, "surface", "query", of_log, "--grid", "9x7", "--json").stdout
        assert [json.loads(line) for line in again.splitlines()] == answers

        wild = pictures(panelcal, data / "wild.jsonl", Path(folder))
        plot = Path(folder) / "plot.svg"
        run(panelcal, "surface", "diff", map_file, wild, "--plot", plot)
        ElementTree.parse(plot)
        listed = Path(folder) / "plan.csv"
        plan = json.loads(run(panelcal, "surface", "plan", wild, "--afresh", "--tolerance-um", 6, "-o",
                              listed, "--plot", plot, "--json").stdout)
        ElementTree.parse(plot)
        assert plan["reached"] and plan["worst"]["sigma_um"] <= 6
        assert len(plan["probes"]) <= plan["grid"]["columns"] * plan["grid"]["rows"]
        rows = [[float(value) for value in row.split(",")]
                for row in listed.read_text().splitlines()[1:]]
        assert rows == plan["probes"], rows

        exports(panelcal, map_file, Path(folder))
        format_files(panelcal, root, probes, Path(folder))

        # A map against itself has not changed.
        same = run(panelcal, "surface", "diff", map_file, map_file, "--json").stdout
        same = json.loads(same)
        assert not same["changed"] and same["greatest_um"] == 0, same


if __name__ == "__main__":
    main()
