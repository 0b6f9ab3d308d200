#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of the reference boards: what a part says of itself holds for its heights."""

import json
import unittest

import numpy as np

import boards


def of_kind(kind, n_boards=20):
    return [boards.Board(kind, np.random.default_rng([5, i])) for i in range(n_boards)]


def without_plane(board, n=60):
    x, y = np.meshgrid(np.linspace(0, board.size_mm[0], n), np.linspace(0, board.size_mm[1], n))
    places = np.column_stack([x.ravel(), y.ravel()])
    heights = board.height_mm(places)
    plane = np.column_stack([np.ones(len(places)), places])
    return heights - plane @ np.linalg.lstsq(plane, heights, rcond=None)[0]


class Boards(unittest.TestCase):
    def test_are_the_same_of_a_seed_and_others_of_another(self):
        one, same, other = (boards.make("rough", 25, 3, seed, 50) for seed in (1, 1, 2))
        self.assertEqual(boards.probe_lines(one), boards.probe_lines(same))
        self.assertNotEqual(boards.probe_lines(one), boards.probe_lines(other))

    def test_bend_by_tens_of_micrometres(self):
        for kind in boards.KINDS:
            for board in of_kind(kind):
                height = np.ptp(without_plane(board))
                self.assertTrue(0.005 < height < 1, f"{kind}: {height} mm")

    def test_a_step_has_one_jump(self):
        for board in of_kind("step"):
            part = board.parts[-1]
            places = np.random.default_rng(1).uniform(0, board.size_mm, (4000, 2))
            heights = part(places)
            drop = np.ptp(heights)
            self.assertTrue(0.029 < drop < 0.151)
            between = (heights < -0.01 * drop) & (heights > -0.99 * drop)
            self.assertLess(between.mean(), 0.25)

    def test_a_bow_has_its_sag(self):
        board = of_kind("smooth", 1)[0]
        part = boards.bow(board, np.random.default_rng(4), 0.1)
        corners = np.array([[x, y] for x in (0, board.size_mm[0]) for y in (0, board.size_mm[1])])
        self.assertLessEqual(np.abs(part(corners)).max(), 0.1 + 1e-9)
        self.assertAlmostEqual(part(0.5 * board.size_mm[None])[0], 0, places=9)

    def test_probes_scatter_as_they_say_but_for_wild_ones(self):
        t = []
        for index in range(60):
            board = boards.make("twist", 60, index, 3, 1)
            rng = np.random.default_rng([3, boards.zlib.crc32(b"twist"), 60, index])
            truth = boards.Board("twist", rng).height_mm(board["probes"])
            t.append((board["heights_mm"] - truth) / board["sigma_mm"])
        self.assertAlmostEqual(np.std(t), 1, delta=0.05)
        wild = boards.make("wild", 120, 1, 3, 1)
        self.assertEqual(len(wild["wild"]), 4)

    def test_places_lie_within_the_probes(self):
        board = boards.make("ripple", 25, 1, 9)
        self.assertTrue(boards.inside(boards.hull(board["probes"]), board["places"]).all())
        self.assertEqual(len(board["places"]), 400)

    def test_readings_have_the_format(self):
        lines = boards.probe_lines(boards.make("valley", 9, 0, 1, 1)).splitlines()
        self.assertEqual(len(lines), 9)
        record = json.loads(lines[4])
        self.assertEqual((record["probe"], record["status"], record["zaxis"]), (4, "found", 0))
        self.assertGreater(record["sigma"], 0)


if __name__ == "__main__":
    unittest.main()
