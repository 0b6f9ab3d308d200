#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of the picture simulator against estimates that share no code with it.

    render_test.py [-v] [--every-cell]     --every-cell: also render each cell with each shape
"""
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import struct
import subprocess
import sys
import tempfile
import unittest
import warnings
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import numpy as np

from simulator import cells, files, geometry, process
from simulator.lens import Optics
from simulator.grid import Grid, View
from simulator.parameters import changed, defaults, merged
from simulator.picture import irradiance, render
from simulator.sensor import expose, mosaic, noise_levels

WIDE = {"picture__width_px": 300, "picture__height_px": 300, "target__centre_px": [149.8137, 149.3729]}
# what linear ramps on the working grid leave
CENTRE_PX = 0.003
AREA = 2e-4


def light(name, seed, **changes):
    """(noise-free light, parameters) of a cell."""
    p = cells.draw(name, seed, [(k.replace("__", "."), v) for k, v in changes.items()])
    planes, scene, _ = irradiance(p, seed)
    return planes[0].astype(float), p


def centroid(a):
    """(x, y) of the light by which a target differs from the even ground that the corners show.

    Linear, unlike edges and thresholds, so that sampling by pixels does not matter. The far halo of a
    diffraction pattern is cut evenly if the target stands in the middle of a wide picture.
    """
    d = a - np.median(np.stack([a[0, 0], a[0, -1], a[-1, 0], a[-1, -1]]))
    y, x = np.mgrid[:a.shape[0], :a.shape[1]]
    return np.array([(d * x).sum(), (d * y).sum()]) / d.sum()


def moments(c, x, y):
    """Area, centroid and second moments of a coverage at coordinates x and y."""
    area = c.sum()
    mx, my = (c * x).sum() / area, (c * y).sum() / area
    dx, dy = x - mx, y - my
    return np.array([area, mx, my, (c * dx * dx).sum() / area, (c * dx * dy).sum() / area, (c * dy * dy).sum() / area])


def by_samples(p, inside, n=16):
    """Picture of an indicator function by n x n samples a pixel; inside(u, v) of board px about the centre."""
    t = (np.arange(160 * n) + 0.5) / n - 0.5
    cx, cy = p["target"]["centre_px"]
    a = np.deg2rad(p["target"]["angle_deg"])
    u, v = t[None, :] - cx, t[:, None] - cy
    u, v = u * np.cos(a) + v * np.sin(a), v * np.cos(a) - u * np.sin(a)
    return inside(u, v).reshape(160, n, 160, n).mean((1, 3))


class Truth(unittest.TestCase):
    def test_centroid_of_clean_picture_is_truth(self):
        for shape in ("disc", "hole", "ring", "square", "diamond", "cross", "triangle"):
            for seed in (1, 2):
                with self.subTest(shape=shape, seed=seed):
                    a, p = light(f"clean:{shape}", seed, board__style="bare", target__inner="etched", **WIDE)
                    np.testing.assert_allclose(centroid(a), p["target"]["centre_px"], atol=CENTRE_PX)

    def test_area_is_that_of_the_artwork(self):
        areas = {
            "disc": lambda t: np.pi / 4 * t["size_px"] ** 2,
            "ring": lambda t: np.pi / 4 * (t["size_px"] ** 2 - t["inner_px"] ** 2),
            "square": lambda t: t["size_px"] ** 2,
            "diamond": lambda t: t["size_px"] ** 2,
            "cross": lambda t: 2 * t["size_px"] * t["width_px"] - t["width_px"] ** 2,
            "triangle": lambda t: np.sqrt(3) / 4 * t["size_px"] ** 2,
        }
        for shape, area in areas.items():
            with self.subTest(shape=shape):
                p = cells.draw(f"clean:{shape}", 4, [("board.style", "bare"), ("target.inner", "etched")])
                scene = irradiance(p, 4)[1]
                self.assertAlmostEqual(scene.c.sum(dtype=float) * scene.grid.h ** 2 / area(p["target"]), 1, delta=AREA)

    def test_shapes_agree_with_plain_supersampling(self):
        half = 30.0
        for shape, inside in {
            "disc": lambda u, v: u * u + v * v < half ** 2,
            "square": lambda u, v: (abs(u) < half) & (abs(v) < half),
            "diamond": lambda u, v: abs(u) + abs(v) < half * np.sqrt(2),
            "cross": lambda u, v: ((abs(u) < half) & (abs(v) < 6)) | ((abs(v) < half) & (abs(u) < 6)),
        }.items():
            with self.subTest(shape=shape):
                p = cells.draw(f"clean:{shape}", 2, [("target.size_px", 2 * half), ("target.width_px", 12.0), ("board.style", "bare")])
                scene = irradiance(p, 2)[1]
                x, y = np.meshgrid(scene.grid.x.astype(float), scene.grid.y.astype(float))
                mine = moments(scene.c.astype(float), x, y) * [scene.grid.h ** 2, 1, 1, 1, 1, 1]
                y, x = np.mgrid[:160, :160].astype(float)
                other = moments(by_samples(p, inside), x, y)
                # 16 x 16 samples a pixel are good to a few parts in 10^4; the pixel adds 1/12 px^2
                np.testing.assert_allclose(mine, other, rtol=1e-3, atol=0.1)
                np.testing.assert_allclose(mine[1:3], other[1:3], atol=CENTRE_PX)

    def test_tag_is_dark_and_bright_where_its_code_says(self):
        a, p = light("clean:tag", 1, target__tag_id=7, target__angle_deg=0.0, board__style="bare")
        cell = p["target"]["size_px"] / 8
        cx, cy = p["target"]["centre_px"]
        cellsof = geometry.tag_cells(geometry.TAG36H11[7])
        level = (a.max() + a.min()) / 2
        for j in range(10):
            for i in range(10):
                x, y = cx + (i - 4.5) * cell, cy + (j - 4.5) * cell
                self.assertEqual(a[round(y), round(x)] > level, cellsof[j, i] > 0.5, (i, j))

    def test_tag_codes_differ_by_eleven_bits_in_any_turn(self):
        # what 36h11 means; a slip in the table would break it
        turned = [[np.rot90(geometry.tag_cells(c), k) for k in range(4)] for c in geometry.TAG36H11]
        for i in range(10):
            for j in range(10):
                for k in range(4):
                    if (i, k) != (j, 0):
                        self.assertGreaterEqual(np.sum(turned[i][k] != turned[j][0]), 11)

    def test_tilted_disc_keeps_truth_at_the_projected_centre(self):
        # outline of a circle, projected point by point with cameras written down here once more
        p = cells.draw("clean", 3, [("view.kind", "entocentric"), ("view.distance_px", 1500.0), ("view.tilt_deg", 8.0),
                                    ("view.axis_px", [-130.0, 80.0]), ("picture.width_px", 300), ("picture.height_px", 300),
                                    ("target.centre_px", [149.8, 149.4])])
        p["view"]["tilt_azimuth_deg"] = 0.0
        planes, _, _ = irradiance(p, 3)
        measured = centroid(planes[0].astype(float))
        cx, cy = np.subtract(p["target"]["centre_px"], (-130.0, 80.0))
        d, c, s = 1500.0, np.cos(np.deg2rad(8)), np.sin(np.deg2rad(8))
        q0 = cx * d / (d * c - cx * s)
        s0 = cy * (d + q0 * s) / d
        t = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
        r = p["target"]["size_px"] / 2
        q, w = q0 + r * np.cos(t), s0 + r * np.sin(t)
        x, y = q * c * d / (d + q * s) - 130, w * d / (d + q * s) + 80
        cross = x * np.roll(y, -1) - np.roll(x, -1) * y
        area = cross.sum() / 2
        expected = [((x + np.roll(x, -1)) * cross).sum() / 6 / area, ((y + np.roll(y, -1)) * cross).sum() / 6 / area]
        np.testing.assert_allclose(measured, expected, atol=CENTRE_PX)
        self.assertGreater(np.hypot(*np.subtract(expected, p["target"]["centre_px"])), 0.02)

    def test_defects_move_the_picture_but_not_truth(self):
        for changes, direction in (({"rim__etch_side_px": 2.0, "rim__etch_side_deg": 90.0}, (0, -1)),
                                   ({"board__style": "mask", "board__opening_px": 1.0, "board__opening_shift_px": [6.0, 0.0]}, (1, 0))):
            with self.subTest(changes=changes):
                a, p = light("clean", 2, board__mask_ridge=0.0, **changes, **WIDE)
                moved = centroid(a) - p["target"]["centre_px"]
                self.assertGreater(moved @ np.array(direction), 0.15)

    def test_bore_wall_shows_on_the_side_of_the_lower_face(self):
        a, p = light("clean:hole", 2, bore__wall_px=4.0, bore__wall_azimuth_deg=0.0, bore__wall=0.9, board__style="bare")
        x, y = (int(round(t)) for t in p["target"]["centre_px"])
        r = int(p["target"]["size_px"] / 2)
        self.assertGreater(a[y, x - r + 2], a[y, x + r - 3] + 0.05)


class Lens(unittest.TestCase):
    def test_light_is_conserved(self):
        p = defaults()
        view = View(p["view"], (79.5, 79.5))
        grid = Grid(160, 160, 4, view)
        for lens in ({}, {"defocus_waves": 1.0, "coma_waves": 0.2, "glare": 0.1}):
            p["motion"]["amplitude_px"] = 2.0
            optics = Optics(grid, {**p["lens"], **lens}, p["motion"], 0.0, (0.3, -0.2), 0.9)
            flat = optics.pixels(np.full(grid.shape, 0.7, np.float32))
            np.testing.assert_allclose(flat, 0.7, rtol=2e-5)
            point = np.zeros(grid.shape, np.float32)
            point[grid.shape[0] // 2, grid.shape[1] // 2] = 16.0
            np.testing.assert_allclose(optics.pixels(point).sum(), 1, rtol=0.02 if lens.get("glare") else 2e-3)

    def test_blur_agrees_with_airy(self):
        # half modulation of a round pupil lies at 0.404 of the cutoff, the pixel's aperture aside
        p = defaults()
        for k in ("glare", "spherical_waves", "coma_waves", "astigmatism_waves"):
            p["lens"][k] = 0.0
        p["lens"]["cutoff_per_px"] = 0.5
        grid = Grid(160, 160, 4, View(p["view"], (79.5, 79.5)))
        blur = Optics(grid, p["lens"], p["motion"], 0.0, (0, 0), 1e-6).blur_px()
        self.assertAlmostEqual(blur * 2 * np.pi / np.sqrt(2 * np.log(2)) * 0.404 * 0.5, 1, delta=0.03)

    def test_motion_keeps_the_centroid(self):
        a, p = light("clean", 5, motion__amplitude_px=2.0, motion__drift_px=0.7, **WIDE)
        np.testing.assert_allclose(centroid(a), p["target"]["centre_px"], atol=CENTRE_PX)


    def test_coma_keeps_edges_in_place(self):
        # mean of the places where rows and columns through the middle cross half the contrast
        a, p = light("clean", 5, lens__coma_waves=0.1, lens__coma_azimuth_deg=0.0, board__style="bare")
        x, y = p["target"]["centre_px"]
        row = a[round(y)]
        half = (row[round(x)] + row[0]) / 2
        i, j = np.flatnonzero(np.diff(row > half))
        left, right = (k + (half - row[k]) / (row[k + 1] - row[k]) for k in (i, j))
        self.assertAlmostEqual((left + right) / 2, x, delta=0.02)


class Sensor(unittest.TestCase):
    def test_noise_is_as_stated(self):
        p = defaults()["sensor"]
        p.update(bits=12, read_e=8.0, prnu=0.01, row_e=5.0, column_e=4.0)
        # the offsets of rows and columns are few: many pictures
        a = np.concatenate([expose(np.full((40, 40), 0.4, np.float32), p, s).ravel() for s in range(200)]) / 4095
        self.assertAlmostEqual(a.std() / noise_levels(0.4, p), 1, delta=0.03)
        self.assertAlmostEqual(a.mean(), 0.4 * 0.99 + 0.01, delta=5e-4)

    def test_flat_colours_survive_a_mosaic(self):
        rgb = np.broadcast_to(np.array([0.2, 0.5, 0.3], np.float32)[:, None, None], (3, 40, 44))
        for pattern in ("RG", "GR", "GB", "BG"):
            for method in ("bilinear", "edge"):
                np.testing.assert_allclose(process.demosaic(mosaic(rgb, pattern), pattern, method), rgb, atol=1e-6)

    def test_jpeg_agrees_with_a_real_encoder(self):
        try:
            import cv2
        except ImportError:
            self.skipTest("OpenCV for Python is not installed")
        a, _ = render(cells.draw("typical", 3), 3)
        for quality in (90, 60):
            _, data = cv2.imencode(".jpg", a, [cv2.IMWRITE_JPEG_QUALITY, quality])
            other = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE).astype(int)
            mine = np.rint(process.jpeg(a[None] / 255, quality)[0] * 255).astype(int)
            # near ties a coefficient may round the other way in fixed-point arithmetic
            self.assertLess(np.abs(mine - other).mean(), 0.25)
            self.assertAlmostEqual(np.abs(mine - a).mean() / np.abs(other - a.astype(int)).mean(), 1, delta=0.02)


class Files(unittest.TestCase):
    def test_png_holds_the_numbers(self):
        for a in (np.arange(12, dtype=np.uint8).reshape(3, 4), (np.arange(12, dtype=np.uint16) * 5000).reshape(3, 4),
                  np.arange(36, dtype=np.uint8).reshape(3, 4, 3)):
            data = files.png_bytes(a)
            self.assertEqual(struct.unpack(">II", data[16:24]), (4, 3))
            start = data.index(b"IDAT") + 4
            raw = zlib.decompress(data[start:data.index(b"IEND") - 8])
            rows = np.frombuffer(raw, np.uint8).reshape(3, -1)
            self.assertTrue((rows[:, 0] == 0).all())
            back = rows[:, 1:].copy().view(">u2" if a.dtype == np.uint16 else np.uint8).reshape(a.shape)
            np.testing.assert_array_equal(back, a)

    def test_bits_are_low_or_high(self):
        low, _ = render(cells.draw("bits10in16", 2), 2)
        high, _ = render(cells.draw("bits12high", 2), 2)
        self.assertEqual(low.dtype, np.uint16)
        self.assertLess(low.max(), 1024)
        self.assertGreater(low.max(), 255)
        self.assertTrue((high % 16 == 0).all())
        self.assertGreater(high.max(), 16384)


class Determinism(unittest.TestCase):
    def test_seed_and_parameters_make_the_picture(self):
        p = cells.draw("all", 11)
        a, truth = render(p, 11)
        b, _ = render(merged(json.loads(json.dumps(truth["parameters"]))), truth["seed"])
        c, _ = render(p, 12)
        np.testing.assert_array_equal(a, b)
        self.assertTrue((a != c).any())

    def test_sets_do_not_depend_on_jobs(self):
        with tempfile.TemporaryDirectory() as folder:
            for jobs in ("1", "2"):
                subprocess.run([sys.executable, str(HERE / "render.py"), "set", "--cell", "typical,empty_tracks:hole", "-n", "3",
                                "--seed", "5", "--jobs", jobs, "-o", f"{folder}/{jobs}"], check=True, stderr=subprocess.DEVNULL)
            names = sorted(str(f.relative_to(f"{folder}/1")) for f in Path(f"{folder}/1").rglob("*") if f.is_file())
            self.assertEqual(len(names), 2 * 3 + 2 + 1)
            for name in names:
                self.assertEqual(Path(folder, "1", name).read_bytes(), Path(folder, "2", name).read_bytes(), name)
            lines = [json.loads(s) for s in Path(folder, "1", "truth.jsonl").read_text().splitlines()]
            self.assertEqual([n["has_target"] for n in lines], [True] * 3 + [False] * 3)
            for line in lines[:3]:
                self.assertLessEqual(np.hypot(*np.subtract(line["at_px"], line["centre_px"])), 8.02)


class Cells(unittest.TestCase):
    def test_cells_render_without_warnings(self):
        shapes = cells.SHAPES if EVERY else ("disc", "hole")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for cell in cells.CELLS if EVERY else ("typical", "hasl", "burr05", "brushed", "chromatic", "bayer_edge", "entocentric", "all"):
                for shape in shapes:
                    with self.subTest(cell=cell, shape=shape):
                        picture, truth = render(cells.draw(f"{cell}:{shape}", 5), 5)
                        self.assertEqual(picture.shape[:2], (160, 160))
                        if truth["has_target"] and shape != "tag":
                            self.assertEqual(truth["contrast"] > 0, truth["polarity"] == "bright")


EVERY = "--every-cell" in sys.argv

if __name__ == "__main__":
    unittest.main(argv=[a for a in sys.argv if a != "--every-cell"])
