// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>
#include <vector>

#include "program/writers/pattern_copies.h"
#include "program/writers/sieb_meyer/writer.h"

#include "tests/program/writers/sieb_meyer/written.h"
#include "tests/support/matchers.h"

namespace panelcal::test::to_sieb_meyer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// --- patterns (5) ------------------------------------------------------------------------------

/// Place of a hole at (10, 20) in the manual's worked examples: the formula of each command.
TEST(SiebMeyerWriter, WritesTheEightOrientations) {
  struct Case {
    double xx, xy, yx, yy;
    std::string_view command;
  };
  constexpr std::array<Case, 8> kCases = {{{1, 0, 0, 1, "M50"},
                                           {0, -1, 1, 0, "M60"},
                                           {-1, 0, 0, 1, "M70"},
                                           {1, 0, 0, -1, "M80"},
                                           {-1, 0, 0, -1, "M90"},
                                           {0, 1, 1, 0, "M60M70"},
                                           {0, -1, -1, 0, "M60M80"},
                                           {0, 1, -1, 0, "M60M90"}}};
  for (const Case& one : kCases) {
    Eigen::Matrix2d linear;
    linear << one.xx, one.xy, one.yx, one.yy;
    const std::vector<Placement> copies = {Placement(),
                                           Placement(linear, Eigen::Vector2d(30, -40.5))};
    EXPECT_EQ(
        from_sieb_meyer({take(1, 1), PatternBegin{}, drill(1, 10, 20), PatternEnd{copies}}).body,
        "T1\nM31\nX10.Y20.\nX0.Y0.M50\nX30.Y-40.5" + std::string(one.command) + "M30\n");
  }
}

TEST(SiebMeyerWriter, OffsetsAreInTheWrittenAxes) {
  ProgramInfo info = info_of(Dialect::SiebMeyer);
  info.axis_version = 3;  // x points up, y points left
  Eigen::Matrix2d mirror_x;
  mirror_x << -1, 0, 0, 1;
  const std::vector<Placement> copies = {Placement(mirror_x, Eigen::Vector2d(3, 4))};
  // In work coordinates x is negated, which is the y of the written axes.
  EXPECT_THAT(write_out({PatternBegin{}, drill(1, 1, 2), PatternEnd{copies}}, info).text,
              HasSubstr("M49,NOSA\nM31\nX2.Y-1.\nX4.Y-3.M80M30\n$\n"));
}

TEST(SiebMeyerWriter, ACopyBeginsWithEverythingSaidAnew) {
  const std::vector<Placement> copies = {Placement()};
  EXPECT_EQ(from_sieb_meyer({drill_at(1, 0, z(1)),
                             PatternBegin{},
                             drill_at(2, 0, z(1)),
                             PatternEnd{copies},
                             drill_at(3, 0, z(1))})
                .body,
            "X1.Y0.Z1.\nM31\nX2.Y0.Z1.\nX0.Y0.M50M30\nX3.Y0.Z1.\n");
}

// --- vision (9) --------------------------------------------------------------------------------

using Targets = std::vector<Position<frame::Nominal>>;

Targets targets(std::initializer_list<Eigen::Vector2d> places_mm) {
  Targets out;
  for (const Eigen::Vector2d& place_mm : places_mm) {
    out.push_back(position_mm<frame::Nominal>(place_mm));
  }
  return out;
}

TEST(SiebMeyerWriter, WritesABoardMeasurement) {
  const Targets two = targets({{1, 2}, {90, 2}});
  EXPECT_EQ(from_excellon({VisionTool{3},
                           VisionSeries{CorrectionLevel::Base, two},
                           drill(1, 5, 5),
                           VisionSeries{CorrectionLevel::Base, two},
                           CancelCorrection{CorrectionLevel::Base},
                           drill(1, 6, 6)},
                          kept())
                .body,
            "G35,3\nX1.Y2.G32\nX90.Y2.G32\nG31\nX5.Y5.\nG34\nX1.Y2.G32\nX90.Y2.G32\nG31\nG34\n"
            "X6.Y6.\n");
}

TEST(SiebMeyerWriter, WritesANestedTargetAsThePatternsOffset) {
  const Targets one = targets({{1, 2}});
  const std::vector<Placement> copies = {Placement()};
  const Written written = from_excellon({take(1, 1),
                                         PatternBegin{},
                                         VisionSeries{CorrectionLevel::Nested, one},
                                         drill(1, 5, 5),
                                         CancelCorrection{CorrectionLevel::Nested},
                                         PatternEnd{copies},
                                         drill(1, 6, 6),
                                         TargetHole{CorrectionLevel::Base, one.front(), 1, {}}},
                                        kept());
  EXPECT_EQ(written.body,
            "T1\nM31\nM49,CAMA\nX1.Y2.G36\nX5.Y5.\nX0.Y0.M50M30\nX6.Y6.\nM49,NOCAMA\nX1.Y2.G36\n");
  EXPECT_THAT(written.losses, IsEmpty());
}

TEST(SiebMeyerWriter, RefusesNestedCorrectionsThatAreMoreThanAnOffset) {
  const Targets two = targets({{1, 2}, {3, 4}});
  const Targets one = targets({{1, 2}});
  const VisionSeries nested{CorrectionLevel::Nested, one};
  const Targets three = targets({{1, 2}, {9, 2}, {1, 9}});
  const std::vector<Placement> copies = {Placement()};
  EXPECT_THAT(from_excellon({VisionSeries{CorrectionLevel::Base, three},
                             VisionSeries{CorrectionLevel::Nested, two}})
                  .failure,
              AllOf(HasSubstr("error[translation-refused]"), HasSubstr("2 targets")));
  EXPECT_THAT(from_excellon({nested, drill(1, 1, 1), nested}).failure,
              HasSubstr("error[translation-refused]"));
  EXPECT_THAT(from_excellon({PatternBegin{}, nested, PatternEnd{copies}, drill(1, 1, 1)}).failure,
              HasSubstr("p:13: error[translation-refused]"));
  EXPECT_THAT(
      from_excellon(
          {PatternBegin{}, nested, CancelCorrection{CorrectionLevel::Nested}, drill(1, 1, 1)})
          .failure,
      HasSubstr("p:13: error[translation-refused]"));
}

}  // namespace
}  // namespace panelcal::test::to_sieb_meyer
