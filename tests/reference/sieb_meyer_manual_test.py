#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The second reading of SIEB & MEYER programs, on the worked examples of the manual."""

import math
import unittest

from sieb_meyer import Refusal, Setting, interpret, read
from sieb_meyer.sections import build

CONTOUR = "X10.Y30.T0T2 M31\nX10.Y40.G1 F1.2\nX20.Y40.\nX20.Y10.\nX10.Y10.\nX10.Y10.T0\n"
# Offset lines -> places of the two executions. The manual prints Y80 and Y40 for the first place under
# M70, and its own formula and the other three places give Y90 and Y50.
OFFSETS = {
    "X30.Y40.M50\nX70.Y20.M50M30": [(40, 80), (50, 80), (50, 50), (40, 50), (80, 60), (90, 60), (90, 30), (80, 30)],
    "X60.Y60.M60\nX90.Y10.M60M30": [(20, 70), (20, 80), (50, 80), (50, 70), (50, 20), (50, 30), (80, 30), (80, 20)],
    "X10.Y60.M60M70\nX30.Y10.M60M70M30": [(50, 70), (50, 80), (20, 80), (20, 70), (70, 20), (70, 30), (40, 30), (40, 20)],
    "X50.Y80.M60M80\nX90.Y40.M60M80M30": [(10, 70), (10, 60), (40, 60), (40, 70), (50, 30), (50, 20), (80, 20), (80, 30)],
    "X10.Y90.M60M90\nX50.Y50.M60M90M30": [(50, 80), (50, 70), (20, 70), (20, 80), (90, 40), (90, 30), (60, 30), (60, 40)],
    "X40.Y50.M70\nX80.Y10.M70M30": [(30, 90), (20, 90), (20, 60), (30, 60), (70, 50), (60, 50), (60, 20), (70, 20)],
    "X10.Y90.M80\nX60.Y60.M80M30": [(20, 50), (30, 50), (30, 80), (20, 80), (70, 20), (80, 20), (80, 50), (70, 50)],
    "X40.Y90.M90\nX80.Y60.M90M30": [(30, 50), (20, 50), (20, 80), (30, 80), (70, 20), (60, 20), (60, 50), (70, 50)],
}


def operations(lines, format_="5000", tools="", subprograms=""):
    return interpret(f"%%{format_}\n{lines}\n" + (f"$\n{tools}\n$\n" if tools else ""), subprograms)


def places(found, kind):
    return [tuple(round(v, 6) for v in (o.at or o.end)) for o in found if o.kind == kind]


class Sections(unittest.TestCase):
    def test_offset_commands_place_the_contour_where_the_manual_has_it(self):
        for offsets, wanted in OFFSETS.items():
            self.assertEqual(places(operations(CONTOUR + offsets), "line"), wanted, offsets)

    def test_a_mirror_reverses_arcs_and_the_side_of_the_cutter(self):
        found = operations("X10.Y50.T0T5M31\nX70.Y40.G2G42R40.F1.2\nX70.Y40.T0\nXYM80\nXYM90M30")
        arcs = [(o.clockwise, o.compensation) for o in found if o.kind == "arc"]
        self.assertEqual(arcs, [(False, "left"), (True, "right")])

    def test_rows_and_columns_of_patterns_are_evenly_spaced(self):
        row = operations("XYT1M31M31M31\nX0Y0M50V2\nX440.YM50W5M30\nX0Y0M50V2\nXY320.M50W3M30\nX1.Y2.M50M30")
        self.assertEqual(places(row, "hole"), [(1 + x, 2 + y) for y in (0, 160, 320) for x in (0, 110, 220, 330, 440)])

    def test_the_bracket_of_a_whole_program_moves_every_section(self):
        text = "X10.Y30.T1M31M31\nX30.Y40.M50\nX70.Y20.M50M30\nX10.Y30.T2M31\nX30.Y40.M50\nX70.Y20.M50M30\nX123.45Y234.67M50M30"
        found = operations(text)
        self.assertEqual([o.tool for o in found], [1, 1, 2, 2])
        self.assertEqual(places(found, "hole"), [(163.45, 304.67), (203.45, 284.67)] * 2)

    def test_a_subprogram_has_its_zero_at_the_call(self):
        final = "@RESET\nM49,NOFA\n@FINAL\nXYT99\nXY500.\nX300.Y500.\nX300.Y\n"
        found = operations("XYM99,RESET\nX5.Y7.M99,FINAL", subprograms=final)
        self.assertEqual(places(found, "hole"), [(5, 7), (5, 507), (305, 507), (305, 7)])

    def test_a_subprogram_of_offset_lines_alone_places_the_section_that_calls_it(self):
        panel = "@PANEL\nXYM50\nX10.YM70\n@ROW\nX0Y0M50V2\nXY20.M50W3\n@MIXED\nX1.Y1.\nXYM50\n"
        found = operations("X1.Y2.T1M31\nX5.Y7.M30M99,PANEL\nXYM31\nXYM99,ROW\nM30", subprograms=panel)
        self.assertEqual(places(found, "hole"), [(6, 9), (14, 9), (0, 0), (0, 10), (0, 20)])
        for text in ("X1.Y2.T1M31\nM99,MIXED\nM30", "X1.Y1.T1M31\nX1.Y1.G91\nX5.Y5.M30M99,PANEL", "X1.Y1.T1M31M99,PANEL\nM30",
                     "X1.Y1.T1M31M31M31M31M31M31\nM30M99,PANEL\nM30M30M30M30M30"):
            with self.assertRaises(Refusal, msg=text):
                operations(text, subprograms=panel)

    def test_format_1000_ends_a_section_with_m30_alone(self):
        found = operations("X100Y100T1\nX1000Y1000M50\nX2000Y1000M50M30\nX300Y300\nX0Y0M90M30", "")
        self.assertEqual(places(found, "hole"), [(11, 11), (21, 11), (-3, -3)])

    def test_sections_that_do_not_pair_are_refused(self):
        for text in ("X1.Y1.M31", "X1.Y1.M30", "X1.Y1.M31\nXYM50\nX2.Y2.\nM30", "X1.Y1.M31\nX1.M50M30",
                     "X1.Y1.M31\nXYM70M80M30", "X1.Y1.M31\nM30\nX2.", "X1.Y1.M31M31M31M31M31M31M31\nM30M30M30M30M30M30M30"):
            with self.assertRaises(Refusal, msg=text):
                operations(text)

    def test_lines_of_a_section_keep_their_order(self):
        root = build(read("%%5000\nX1.Y1.M31\nX2.Y2.\nXYM50M30\nX3.Y3.\n").blocks, 5000)
        self.assertEqual([child.line for child in root.children], [2, 5])
        self.assertEqual([len(root.children[0].children), len(root.children[0].offsets)], [2, 1])


class Events(unittest.TestCase):
    def test_m28_in_a_rout_line_ends_the_contour_behind_its_track(self):
        start = "X10.Y50.T0T5\nX50.Y50.G1F1.M28\n"
        found = operations(start + "T0\nX1.Y1.")
        self.assertEqual([(o.kind, o.line) for o in found], [("plunge", 3), ("line", 3), ("retract", 3), ("hole", 5)])
        for line in ("X50.Y80.", "X50.Y80.T6", "X50.Y80.G1"):
            with self.assertRaises(Refusal, msg=line):
                operations(start + line)


class Holes(unittest.TestCase):
    def test_v1_in_the_standard_and_in_a_free_grid(self):
        standard = places(operations("X30.00Y70.00 V1\nX45.24Y62.38"), "hole")
        self.assertEqual(sorted(standard), sorted((30 + round(2.54 * k, 2), y) for k in range(7) for y in (70, 62.38)))
        free = places(operations("X70.00Y30.00 V1\nX77.50Y45.00 W7"), "hole")
        self.assertEqual(sorted(free), sorted((x, 30 + 2.5 * k) for k in range(7) for x in (70, 77.5)))

    def test_v2_has_its_first_and_its_last_hole(self):
        found = places(operations("X10.Y10.V2\nX37.94Y10.W12"), "hole")
        self.assertEqual(found, [(round(10 + 2.54 * k, 6), 10) for k in range(12)])

    def test_v3_corrects_the_corner_to_the_grid(self):
        standard = places(operations("X30.Y10.V3\nX50.Y30."), "hole")
        self.assertEqual((len(set(standard)), max(standard)), (32, (50.32, 30.32)))
        free = places(operations("X30.Y50.V3\nX50.Y70.W9"), "hole")
        self.assertEqual((len(set(free)), max(free), (32.5, 50) in free), (32, (50, 70), True))

    def test_v4_divides_the_circle(self):
        found = operations("X50.Y50.V4T1\nX80.Y50.W12")
        self.assertEqual(len(found), 12)
        for k in range(12):
            wanted = (50 + 30 * math.cos(math.radians(30 * k)), 50 + 30 * math.sin(math.radians(30 * k)))
            self.assertLess(min(math.dist(wanted, o.at) for o in found), 1e-9)

    def test_incremental_coordinates_count_from_the_last_one(self):
        text = "X20.Y-30.T0T5M31\nX20.Y-20.G1F1.2G42\nX30.Y-20.\nX30.Y\nX20.Y\nX20.Y30.\nX-20.Y10.\nY-20.X G91\nX-20.Y\n" \
               "XY-10.\nX10.Y-10.\nX20.Y-30.G90\nX20.Y-30.T0\nX80.Y70.M50M30"
        wanted = [(20, -20), (30, -20), (30, 0), (20, 0), (20, 30), (-20, 10), (-20, -10), (-40, -10), (-40, -20), (-30, -30),
                  (20, -30)]
        self.assertEqual(places(operations(text), "line"), [(x + 80, y + 70) for x, y in wanted])

    def test_formats_have_their_units(self):
        text = "PROGRAM EXAMPLE\n%%\nX1000Y1000T1\nX3456Y4567\nX12345Y450\n" + "$80$50$20$99$30$300" + "$" * 85 + "\n"
        self.assertEqual(places(interpret(text), "hole"), [(10, 10), (34.56, 45.67), (123.45, 4.5)])
        self.assertEqual(read(text).diameters_mm, {1: 0.8})
        text = "%%3000\nX10.Y10.T1\nX.3Y.45\nX123.45Y.451K40G83\n$\nT1D80S50F20R150N10A300\nM1M2M3\n$\n"
        self.assertEqual(places(interpret(text), "hole"), [(10, 10), (0.3, 0.45), (123.45, 0.451)])
        self.assertEqual(interpret(text)[2].depth.depth_mm, 0.4)

    def test_what_the_manual_leaves_open_is_refused(self):
        for text in ("X5.T1", "M49,FV4\nX1.Y1.", "M49,SAX3.Y100.", "X1.Y1.M93", "/X1.Y1.", "X1.Y1.G36", "x1.y1.", "X1.Y1.G99",
                     "X1.Y1.V3\nX11.Y41.W9", "X1.Y1.V1\nX7.35Y-4.", "G71\nX1.Y1.G82", "X1.Y1.R5.", "X1.Y1.M97,"):
            with self.assertRaises(Refusal, msg=text):
                operations(text)


class Routing(unittest.TestCase):
    def test_radius_and_direction_stay_in_force(self):
        found = operations("X30.Y50.T0 T5\nX40.Y50.G2 R15. F1.2\nX50.Y50.R-15.\nX60.Y50.G3\nX60.Y50.T0")
        self.assertEqual([o.kind for o in found], ["plunge", "arc", "arc", "arc", "retract"])
        reach = math.sqrt(15 ** 2 - 5 ** 2)
        self.assertEqual([round(o.center[1] - 50, 9) for o in found[1:4]], [round(v, 9) for v in (-reach, reach, -reach)])
        self.assertEqual([o.clockwise for o in found[1:4]], [True, True, False])

    def test_i_and_j_lead_from_the_center_to_the_start(self):
        arc = operations("X20.Y80.T5T0\nX65.Y20.G2I-30.J25.F12\nX65.Y20.T0", "5000")[1]
        self.assertEqual(arc.center, (50, 55))

    def test_plunge_points_of_finished_contours(self):
        for text, wanted in (("X35.Y50.G46R20.", (28.283, 66.217)), ("X35.Y50.G47R20.", (14, 51)),
                             ("X30.Y50.G50I40.J30.", (30, 57))):
            figure = operations(f"X35.Y50.T0T5\n{text}F1.2\nXYT0", tools="T5D2.")[0]
            self.assertLess(math.dist(figure.plunge, wanted), 0.001)

    def test_a_corner_is_rounded_by_a_touching_arc(self):
        found = operations("X0Y0T0T5\nX10.YG1D2.F1.\nX10.Y10.\nX10.Y10.T0")
        self.assertEqual([(o.kind, o.end or o.at) for o in found],
                         [("plunge", (0, 0)), ("line", (8, 0)), ("arc", (10, 2)), ("line", (10, 10)), ("retract", (10, 10))])
        self.assertEqual((found[2].center, found[2].clockwise), ((8, 2), False))

    def test_contours_that_do_not_pair_are_refused(self):
        for text in ("X1.Y1.G1", "X1.Y1.T0\nX2.Y2.G1F1.", "X1.Y1.T0\nX2.Y2.G1F1.\nX2.Y2.\nX2.Y2.T0", "X1.Y1.T0\nX9.Y1.G2R3.\nXYT0",
                     "X1.Y1.T0\nX9.Y1.G2\nXYT0", "X1.Y1.T0\nX2.Y2.G1M20\nXYT0", "X1.Y1.T0\nX9.Y1.G1D9.\nX9.Y5.\nXYT0"):
            with self.assertRaises(Refusal, msg=text):
                operations(text)


class Depths(unittest.TestCase):
    def test_depth_control_in_a_contour(self):
        text = "X20.Y30.T5T0 Z3.\nX20.Y30.G1 F1.2\nX40.Y30.\nX40.Y50.G83K2.\nX60.Y50.\nX90.Y80.T0 G82"
        depths = [(o.depth.reference, o.depth.depth_mm, o.depth.lower_mm) for o in operations(text)]
        self.assertEqual(depths, [("table", 3, None)] * 3 + [("board", 2, 3)] * 2 + [("table", 3, None)])

    def test_without_a_number_the_operators_value_holds(self):
        found = operations("X1.Y1.T1G83\nX2.Y1.G82\nX3.Y1.G83K.4Z1.3H5.\nX4.Y1.G82\nX5.Y1.G83")
        depths = [(o.depth.reference, o.depth.depth_mm, o.depth.lower_mm, o.depth.upper_mm) for o in found]
        self.assertEqual(depths, [("board", None, None, None), ("table", None, None, None), ("board", 0.4, 1.3, 5),
                                  ("table", 1.3, None, 5), ("board", 0.4, 1.3, 5)])

    def test_surface_memory(self):
        text = "G71\nX165.Y15.G73L1\nG75\nX110.Y10.G73L2\nG75\nG71K.4\nL1\nX165.Y15.T1\nX170.Y15.\nG71K.5\nL2\n" \
               "X110.Y10.T0T5\nX110.Y30.G1F1.5\nX110.Y30.T0\nG70\nXY"
        found = [o for o in operations(text) if o.kind in ("hole", "line")]
        depths = [(o.depth.reference, o.depth.depth_mm, o.depth.memory) for o in found]
        self.assertEqual(depths, [("surface", 0.4, 1)] * 2 + [("surface", 0.5, 2), ("table", None, None)])

    def test_a_ramp_begins_where_the_line_before_was(self):
        line = operations("X20.Y40.T0T2Z2.0\nX70.Y40.G1F.8G6Z3.5\nX70.Y40.T0")[1]
        self.assertEqual((line.ramp_from.depth_mm, line.depth.depth_mm), (2, 3.5))

    def test_peck_drilling_keeps_its_values(self):
        found = operations("X2.Y7.T2G81I5.P80J1.4W1000\nX3.Y7.G80\nX4.Y7.G81J1.2")
        first = (("I", 5.0), ("J", 1.4), ("P", 80), ("W", 1000))
        self.assertEqual([o.cycle for o in found], [("peck", first), None, ("peck", (first[0], ("J", 1.2), *first[2:]))])


class Numbers(unittest.TestCase):
    def test_a_setting_has_the_numbers_where_the_digits_behind_the_percent_signs_do_not(self):
        inch = Setting("inch", "TZ", (2, 4), "m/min")
        text = "X1.Y20000T1\n$\nT1D.04\n$\n"
        self.assertEqual(places(interpret("%%5001\n" + text, "", inch), "hole"), [(25.4, 50.8)])
        self.assertEqual(places(interpret("%%5000\n" + text, "", inch), "hole"), [(1, 20)])
        self.assertEqual(places(interpret("%%5000\n" + text, "", Setting("inch", rules=True)), "hole"), [(25.4, 50.8)])
        self.assertAlmostEqual(read("%%5001\n" + text, inch).diameters_mm[1], 1.016)
        leading = Setting("inch", "LZ", (2, 4))
        self.assertEqual(places(interpret("%%\nX01Y0025T1\n", "", leading), "hole"), [(25.4, 6.35)])
        part = Setting(None, "LZ", (3, 3))
        self.assertEqual(places(interpret("%%\nX1000Y250T1\n", "", part), "hole"), [(10, 2.5)])

    def test_what_no_setting_states_is_refused(self):
        inch, leading = Setting("inch", rules=True), Setting("inch", "LZ", (2, 4), rules=True)
        for text, setting in (("%%5001\nX1.Y1.T1", None), ("%%5001\nX1.Y1.T1", Setting("inch", "TZ")), ("%%\nX1Y1T1", inch),
                              ("%%\nX1Y1T1", Setting("inch", "TZ")),
                              ("%%5000\nX1.Y1.T1\n$\nT1D80\n$", inch), ("%%3000\nX1.Y1.T1Z20", inch),
                              ("%%5000\nX1.Y1.T1\n$\nT1F2.\n$", inch), ("%%5000\nX1.Y1.T1Z01", leading)):
            with self.assertRaises(Refusal, msg=text):
                interpret(text + "\n", "", setting)


if __name__ == "__main__":
    unittest.main()
