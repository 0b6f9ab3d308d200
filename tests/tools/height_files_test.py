#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`panelcal surface fit` finds the places and heights that files of other programs were made of.

    height_files_test.py PANELCAL ROOT
"""
import json
import sys
import tempfile
from pathlib import Path

from demo_job import run

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
sys.path.insert(0, str(Path(__file__).parents[1] / "reference"))
import height_files  # noqa: E402
from facts import checked  # noqa: E402

# The coarsest digits are those of an inch, 0.0001.
TOLERANCE_MM = 0.0051


def nearest(found, at):
    return min(found, key=lambda other: abs(other[0] - at[0]) + abs(other[1] - at[1]))


def same_places(found, wanted):
    assert len(found) == len(wanted), (len(found), len(wanted))
    for at in wanted:
        other = nearest(found, at)
        assert all(abs(a - b) < TOLERANCE_MM for a, b in zip(other, at)), (at, other)


def check(panelcal, root, folder, format_, name, maker, options):
    text, heights, missing = maker()
    path = Path(folder) / name
    path.write_bytes(text.encode())
    said = run(panelcal, "surface", "fit", path, "-o", Path(folder) / "map.json", "--model", "thin-plate", "--json", "-", *options).stdout
    document = checked(json.loads(said), root)
    source, = document["sources"]
    assert source["format"] == format_ and source["probes"] == len(heights) and source["missing"] == len(missing), source
    assert source["zero"] and source["unit"].startswith(("mm", "inch", "x in", "height in")), source
    zone, = document["zones"]
    assert zone["left_out"] == [], (name, zone["left_out"])
    kept = zone["kept"]
    found = dict(zip(zip(kept["x_mm"], kept["y_mm"]), kept["height_mm"]))
    same_places(found, heights)
    for at, z in heights.items():
        assert abs(found[nearest(found, at)] - z) < TOLERANCE_MM, (name, at, z, found[nearest(found, at)])
    same_places([tuple(one["place_mm"]) for one in document["missing"]], missing)
    return source


def main():
    panelcal, root = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        sources = {name: check(panelcal, root, folder, format_, name, maker, options)
                   for format_, name, maker, options in height_files.FILES}
    assert "by WCO of line 5" in sources["status.log"]["zero"], sources["status.log"]
    assert "by G55 + G92 + TLO of line 4" in sources["parameters.log"]["zero"], sources["parameters.log"]
    assert sources["inch.log"]["unit"] == "inch ($13=1, line 2)", sources["inch.log"]
    assert "whole mm" in sources["unified.txt"]["zero"] and "--mesh-mm" in sources["unified_flags.txt"]["zero"], sources


if __name__ == "__main__":
    main()
