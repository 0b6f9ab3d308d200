#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Calibrates a camera by a plate with a tag: what --json says of its pictures.

    calibrate_plate_test.py PANELCAL REPOSITORY
"""
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

PANELCAL = str(Path(sys.argv[1]).resolve())
ROOT = Path(sys.argv[2]).resolve()
sys.path[:0] = [str(ROOT / "tests" / "golden"), str(ROOT / "tests" / "support")]
from facts import checked  # noqa: E402
from golden_pictures import png  # noqa: E402

MACHINE = """[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
"""
COLUMNS, ROWS, PITCH_MM, DOT_MM, TAG_MM = 6, 4, 15, 5, 7.5
PLATE = f"""[plate]
columns = {COLUMNS}
rows = {ROWS}
pitch_mm = {PITCH_MM}
dot_diameter_mm = {DOT_MM}
certified = true
[tags]
size_mm = {TAG_MM}
[[tag]]
id = 0
cell = [0.5, 0.5]
"""
# Tag 0 of tag36h11 without its black frame, white where there is a #.
BITS = ("##.#.#", ".###.#", ".##...", "#.#...", ".#.##.", "...#..")
WIDTH_PX, HEIGHT_PX, SCALE_MM, AXIS_PX = 160, 140, 0.25, (80, 70)
ZERO_MM = (100, 80)  # where dot (0, 0) lies
BLACK, WHITE = 40, 180
# Of the camera, in dots: the tag can be seen from the first.
NEAR = (0, 0.5, 1)
STOPS = [(i, j) for j in NEAR for i in NEAR] + [(i, j) for j in (0, 3) for i in (2, 5)]
PER_PIXEL = 3  # samples along a side
EDGE_MM = 0.6  # from black to white at a dot's rim: a lens makes no staircase
NOISE = 2  # grey levels


def level(x_mm, y_mm):
    """Of a place on the plate."""
    cell_mm = TAG_MM / 8
    column = (x_mm - 0.5 * PITCH_MM) // cell_mm + 4
    row = 3 - (y_mm - 0.5 * PITCH_MM) // cell_mm
    if 0 <= column < 8 and 0 <= row < 8:
        is_bit = 1 <= column < 7 and 1 <= row < 7
        return WHITE if is_bit and BITS[int(row) - 1][int(column) - 1] == "#" else BLACK
    i, j = round(x_mm / PITCH_MM), round(y_mm / PITCH_MM)
    if not (0 <= i < COLUMNS and 0 <= j < ROWS):
        return WHITE
    inwards_mm = DOT_MM / 2 - math.hypot(x_mm - i * PITCH_MM, y_mm - j * PITCH_MM)
    share = min(1.0, max(0.0, 0.5 + inwards_mm / EDGE_MM))
    return WHITE + share * (BLACK - WHITE)


def picture(x_mm, y_mm):
    """With the optical axis there, in machine directions."""
    noise = random.Random(f"{x_mm} {y_mm}")

    def grey(u, v):
        total = PER_PIXEL ** 2 * noise.gauss(0, NOISE)
        for a in range(PER_PIXEL):
            for b in range(PER_PIXEL):
                du = u + (a + 0.5) / PER_PIXEL - 0.5 - AXIS_PX[0]
                dv = v + (b + 0.5) / PER_PIXEL - 0.5 - AXIS_PX[1]
                total += level(x_mm - ZERO_MM[0] + SCALE_MM * du, y_mm - ZERO_MM[1] - SCALE_MM * dv)
        return round(total / PER_PIXEL ** 2)

    rows = [[grey(u, v) for u in range(WIDTH_PX)] for v in range(HEIGHT_PX)]
    return png(WIDTH_PX, HEIGHT_PX, rows)


def name(i, j):
    """Of the picture of a stop."""
    return f"{i:g}-{j:g}"


def calibrate(what, *words):
    done = subprocess.run([PANELCAL, "calibrate", what, "-m", "machine.toml", "--plate",
                           "plate.toml", "--images", "looks", "--force", *words],
                          capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
    assert done.returncode == 0, (what, words, done.returncode, done.stdout, done.stderr)
    return done.stdout


def check(what, *words):
    document = checked(json.loads(calibrate(what, "--json", "-", *words)), ROOT)
    assert document["verdict"] == "measured" and document["ledger_entry"] is None, document
    answer = document[what]
    (left_out,) = answer["pictures_left_out"]
    assert sorted(left_out) == ["picture", "reason"], left_out
    assert left_out["picture"] == "looks/1-0.png", left_out
    assert "mm beside where the others have it" in left_out["reason"], left_out
    far = [f"looks/{name(i, j)}.png" for i, j in STOPS if i > 1 or j > 1]
    assert answer["pictures_without_tag"] == far, answer["pictures_without_tag"]
    text = calibrate(what, *words)
    assert f"\n  pictures without a tag: {len(far)} (from {far[0]})" in text, text
    assert "\n  without looks/1-0.png: tag 0 lies" in text, text


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("machine.toml").write_text(MACHINE)
        Path("plate.toml").write_text(PLATE)
        Path("camera.cal.json").write_text(json.dumps({
            "kind": "camera", "version": 1, "date": "2026-11-01T00:00:00Z",
            "provenance": "made up", "units": {"length": "mm", "angle": "rad", "picture": "px"},
            "picture_px": [WIDTH_PX, HEIGHT_PX],
            "parameters": {"scale_mm_per_px": SCALE_MM, "rotation_rad": 0,
                           "axis_px": AXIS_PX, "k1_per_px2": 0},
            "covariance": [[0] * 5] * 5}))
        Path("looks").mkdir()
        lines = ["file,x,y"]
        for i, j in STOPS:
            x_mm, y_mm = ZERO_MM[0] + i * PITCH_MM, ZERO_MM[1] + j * PITCH_MM
            # One stop is a pitch off.
            stands_mm = x_mm - PITCH_MM if (i, j) == (1, 0) else x_mm
            Path(f"looks/{name(i, j)}.png").write_bytes(picture(stands_mm, y_mm))
            lines.append(f"{name(i, j)}.png,{x_mm},{y_mm}")
        Path("looks/images.csv").write_text("\n".join(lines) + "\n")
        check("camera", "--form", "flat")
        check("table")
