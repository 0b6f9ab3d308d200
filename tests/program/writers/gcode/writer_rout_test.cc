// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <string>

#include "program/writers/gcode/writer.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/writers/gcode/writer_run.h"

namespace panelcal {
namespace {

using namespace test;
using testing::HasSubstr;

TEST(GcodeWriter, RoutsAContour) {
  GcodeSetting setting = on_the_board();
  setting.approach_z = mm(1);
  const Written written = write_out({take(2),
                                     rapid_move(10, 10),
                                     plunge(),
                                     rout_line(2, 20, 10),
                                     rout_arc(RoutKind::Counterclockwise, 2, 25, 15, 20, 15),
                                     rout_arc(RoutKind::Clockwise, 2, 30, 20, 30, 15),
                                     Retract{},
                                     rapid_move(0, 0),
                                     Stop{StopKind::EndRewind, {}, {}}},
                                    setting);
  EXPECT_EQ(written.text,
            "T2 M6 ; 2.5 mm\n"
            "G0 Z5\n"
            "G0 X10 Y10\n"
            "S30000 M3\n"
            "G0 Z1\n"
            "G1 Z-2 F1200\n"
            "G1 X20 Y10\n"
            "G3 X25 Y15 I0 J5\n"
            "G2 X30 Y20 I5 J0\n"
            "G0 Z5\n"
            "G0 X0 Y0\n"
            "M5\n"
            "M2\n");
}

TEST(GcodeWriter, ARaisedToolIsNotRaisedAgain) {
  EXPECT_EQ(write_out({take(1), Retract{true}, drill(1, 1, 2), Retract{}}).text,
            "T1 M6 ; 1 mm\nS30000 M3\nG0 Z5\nG81 X1 Y2 Z-1.8 R5 F1200\nG80\nM5\nM2\n");
}

TEST(GcodeWriter, RampsAndStepsOfAContour) {
  Rout ramp = rout_line(2, 5, 0);
  ramp.cut = z(0.5);
  Rout helix = rout_arc(RoutKind::Clockwise, 2, 7, 0, 6, 0);
  helix.cut = z(0.25);
  const Written written = write_out({take(2),
                                     rapid_move(0, 0),
                                     plunge(z(1)),
                                     ramp,
                                     plunge(z(0.4)),
                                     helix,
                                     rout_line(2, 9, 0),
                                     Retract{}},
                                    on_the_table(),
                                    sieb_meyer_info());
  EXPECT_THAT(written.text,
              HasSubstr("G1 Z1 F1200\nG1 X5 Y0 Z0.5\nG1 Z0.4\nG2 X7 Y0 Z0.25 I1 J0\nG1 X9 Y0\n"
                        "G0 Z5\n"));
}

TEST(GcodeWriter, PassesOfAStepSlotAreDepthOffsets) {
  Plunge first = plunge();
  first.depth_offset = mm(1);
  Plunge last = plunge();
  last.depth_offset = mm(0);
  EXPECT_THAT(write_out({take(2),
                         rapid_move(0, 0),
                         first,
                         rout_line(2, 5, 0),
                         last,
                         rout_line(2, 0, 0),
                         Retract{}})
                  .text,
              HasSubstr("G1 Z-1 F1200\nG1 X5 Y0\nG1 Z-2\nG1 X0 Y0\nG0 Z5\n"));
}

TEST(GcodeWriter, CentersAreEquallyFarFromRoundedEnds) {
  // Two steps of an Excellon program's last digit off: the reader has adjusted that far.
  const Written written = write_out({take(2),
                                     rapid_move(0, 0),
                                     plunge(),
                                     rout_arc(RoutKind::Clockwise, 2, 1.0 / 3, 1.0 / 7, 0.25, -0.1),
                                     Retract{}});
  EXPECT_THAT(written.failure, HasSubstr("error[internal]"));
  const Eigen::Vector2d to(1.0 / 3, 1.0 / 7);
  const Eigen::Vector2d center = 0.5 * to + 0.7 * Eigen::Vector2d(-to.y(), to.x());
  const std::string text = write_out({take(2),
                                      rapid_move(0, 0),
                                      plunge(),
                                      rout_arc(RoutKind::Counterclockwise,
                                               2,
                                               to.x(),
                                               to.y(),
                                               center.x() + 1e-3 * to.x(),
                                               center.y() + 1e-3 * to.y()),
                                      Retract{}})
                               .text;
  double x = 0, y = 0, i = 0, j = 0;
  const auto at = text.find("G3 X");
  ASSERT_NE(at, std::string::npos) << text;
  ASSERT_EQ(std::sscanf(text.c_str() + at, "G3 X%lf Y%lf I%lf J%lf", &x, &y, &i, &j), 4) << text;
  EXPECT_NEAR(std::hypot(i, j), std::hypot(x - i, y - j), 2e-6);
  EXPECT_NEAR(i, center.x(), 1e-6);
  EXPECT_NEAR(j, center.y(), 1e-6);
}

TEST(GcodeWriter, AnArcOfNoLengthIsNoCircle) {
  const double tiny_mm = 4e-7;  // rounds to nothing
  const auto text_of = [&](double x_mm) {
    return write_out({take(2),
                      rapid_move(1, 0),
                      plunge(),
                      rout_arc(RoutKind::Clockwise, 2, 1 + x_mm, 0, 1 + x_mm / 2, -3),
                      Retract{}})
        .text;
  };
  EXPECT_THAT(text_of(tiny_mm), HasSubstr("G1 Z-2 F1200\nG0 Z5\n"));
  EXPECT_THAT(text_of(5e-5), HasSubstr("G1 X1.00005 Y0\n"));
  EXPECT_THAT(text_of(0.01), HasSubstr("G1 X1.01 Y0\n"));  // bulges by 4 nm
  EXPECT_THAT(text_of(0.1), HasSubstr("G2 X1.1 Y0 I0.05 J-3\n"));
}

}  // namespace
}  // namespace panelcal
