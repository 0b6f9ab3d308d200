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

from demo_job import run

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from facts import checked, in_page  # noqa: E402


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


def answers_of(panelcal, root, map_file, *places, **more):
    """What `surface query` says of each place."""
    said = run(panelcal, "surface", "query", map_file, *places, "--json", "-", **more).stdout
    table = checked(json.loads(said), root)["places"]
    rows = zip(*(table[key] for key in ("x_mm", "y_mm", "height_mm", "sigma_um")))
    return [{"place": [x, y], "height": height, "sigma": None if sigma is None else sigma / 1e3} for x, y, height, sigma in rows]


def facts_of_a_map(panelcal, root, probes, folder):
    """Every probe is in the facts: as one that makes the map, as left out, or as missing."""
    said = run(panelcal, "surface", "fit", probes, "-o", folder / "wild.json", "--report", folder / "map.html",
               "--json", folder / "facts.json").stdout
    assert f"{probes}:17: " in said and " 0.41" in said, said
    assert f"{probes}:25: " in said and "(40.000, 36.000)" in said, said
    document = checked(json.loads((folder / "facts.json").read_text()), root)
    assert in_page(folder / "map.html") == document
    zone, = document["zones"]
    assert len(zone["kept"]["x_mm"]) == 40
    assert [(one["line"], one["file"]) for one in zone["left_out"]] == [(17, str(probes))]
    assert [(one["line"], one["place_mm"]) for one in document["missing"]] == [(25, [40, 36])]
    # Residuals are those of the surface, heights of the field those of a query.
    rms = math.sqrt(sum(value**2 for value in zone["kept"]["residual_um"]) / 40)
    assert abs(rms / zone["residual_rms_um"] - 1) < 1e-9
    field, n = zone["field"], zone["field"]["columns"]
    assert len(field["height_mm"]) == len(field["sigma_um"]) == len(field["source"]) == n * field["rows"]
    picked = range(0, len(field["source"]), 97)
    places = [[field["first_mm"][k] + step * field["step_mm"][k] for k, step in enumerate((i % n, i // n))] for i in picked]
    asked = "".join(f"{x!r},{y!r}\n" for x, y in places)
    code = 1 if any(field["source"][i] == "-" for i in picked) else 0
    found = answers_of(panelcal, root, folder / "wild.json", "-", input=asked, expect=code)
    for i, answer in zip(picked, found):
        if field["source"][i] == "-":
            assert answer["height"] is None and field["height_mm"][i] is None, (i, answer)
        else:
            assert abs(answer["height"] - field["height_mm"][i]) < 1e-5, (i, answer)
    return folder / "wild.json"


def exports(panelcal, root, map_file, folder):
    """What is written for others has the map's heights, counted from --zero, when read again:
    within rounding (1 um in heightmap.csv) and the lattice's tenth of sigma."""
    at_zero, = answers_of(panelcal, root, map_file, "10,10")
    wanted = {tuple(answer["place"]): answer["height"] - at_zero["height"]
              for answer in answers_of(panelcal, root, map_file, "--grid", "7x6")}
    for name in ("x.csv", "x.probe", "x.hmap"):
        said = run(panelcal, "surface", "export", map_file, "--grid", "7x6", "--zero", "10,10", "-o",
                   folder / name, "--json", "-").stdout
        assert checked(json.loads(said), root)["heights"] == 42, said
        run(panelcal, "surface", "fit", folder / name, "--model", "bilinear", "-o",
            folder / "again.json")
        for answer in answers_of(panelcal, root, folder / "again.json", "--grid", "7x6"):
            height = wanted[tuple(answer["place"])]
            assert abs(answer["height"] - height) < 1e-3, (name, answer, height)


def format_files(panelcal, root, probes, folder):
    """A file beside programs that has decided their number format is one source of the facts, named once."""
    (folder / "nc_param.txt").write_text("OUTPUT-UNITS METRIC\nINTEGER-PLACES 3\nDECIMAL-PLACES 3\n"
                                         "SUPPRESS-LEAD-ZEROES YES\n")
    for name in ("a.drl", "b.drl"):
        (folder / name).write_text("T1C0.8F100\nX3000Y3000\nX13000Y23000\nM30\n")
    machine = Path(root) / "tests/golden/fixtures/drill-1/machine.toml"
    facts = folder / "formats.facts"

    def beside():
        return [what for what, _ in json.loads(facts.read_text())["provenance"] if "nc_param.txt" in what]

    wanted = [f"sha256 {folder / 'nc_param.txt'}"]
    run(panelcal, "surface", "fit", probes, "--voids-of", folder / "a.drl", "--voids-of",
        folder / "b.drl", "-m", machine, "-o", folder / "formats.json", "--json", facts)
    assert beside() == wanted, beside()
    run(panelcal, "surface", "plan", folder / "formats.json", "--program", folder / "a.drl", "-m",
        machine, "--tolerance-um", 20, "-o", folder / "formats.csv", "--json", facts)
    assert beside() == wanted, beside()


def main():
    panelcal, root = sys.argv[1:]
    data = Path(root) / "tests/tools/surface"
    probes = data / "plane.jsonl"
    with tempfile.TemporaryDirectory() as folder:
        map_file = Path(folder) / "map.json"
        said = json.loads(run(panelcal, "surface", "fit", probes, "-o", map_file, "--model", "plane",
                              "--json", "-").stdout)["zones"][0]
        answers = answers_of(panelcal, root, map_file, "--grid", "9x7")
        plane = plane_of(read(probes))
        assert len(answers) == 63
        for answer in answers:
            height, sigma = plane(*answer["place"])
            assert abs(answer["height"] - height) < said["lattice_error_um"] / 1e3 + 1e-9, answer
            # Between the lattice's nodes sigma is a little more than it must be.
            assert 0 <= answer["sigma"] / sigma - 1 + 1e-6 < 0.01, (answer, sigma)
        corner = plane(0, 0)
        assert abs(said["worst_sigma"]["sigma_um"] / 1e3 / corner[1] - 1) < 0.01

        # A program's places, standard input and arguments are one way to ask.
        grid = [line["place"] for line in answers]
        asked = "".join(f"{x},{y}\n" for x, y in grid)
        assert answers_of(panelcal, root, map_file, "-", input=asked) == answers

        # A log of LinuxCNC, which states no sigma, makes the same map.
        log = Path(folder) / "probes.txt"
        log.write_text("".join(f"{x} {y} {z}\n" for x, y, z, _ in read(probes)))
        of_log = Path(folder) / "log.json"
        run(panelcal, "surface", "fit", log, "--format", "linuxcnc", "--sigma-um", 3, "--model",
            "plane", "-o", of_log)
        assert answers_of(panelcal, root, of_log, "--grid", "9x7") == answers

        wild = facts_of_a_map(panelcal, root, data / "wild.jsonl", Path(folder))
        change = json.loads(run(panelcal, "surface", "diff", map_file, wild, "--json", "-").stdout)
        assert checked(change, root)["changed"], change
        field = change["field"]
        assert abs(max(field["difference_um"], key=abs)) <= abs(change["greatest_um"]) * 1.001
        listed = Path(folder) / "plan.csv"
        plan = json.loads(run(panelcal, "surface", "plan", wild, "--afresh", "--tolerance-um", 6, "-o",
                              listed, "--json", "-").stdout)
        assert checked(plan, root)["reached"] and plan["worst"]["sigma_um"] <= 6
        # What is drawn is what was planned: about the tolerance at worst, and below it near the probes.
        assert 0 < min(plan["field"]["sigma_um"]) < 6 and max(plan["field"]["sigma_um"]) < 6.2
        assert len(plan["probes_mm"]) <= plan["grid"]["columns"] * plan["grid"]["rows"]
        rows = [[float(value) for value in row.split(",")]
                for row in listed.read_text().splitlines()[1:]]
        assert all(abs(a - b) < 1e-6 for row, place in zip(rows, plan["probes_mm"], strict=True) for a, b in zip(row, place)), rows

        exports(panelcal, root, map_file, Path(folder))
        format_files(panelcal, root, probes, Path(folder))

        # A map against itself has not changed.
        same = json.loads(run(panelcal, "surface", "diff", map_file, map_file, "--json", "-").stdout)
        assert not same["changed"] and same["greatest_um"] == 0, same


if __name__ == "__main__":
    main()
