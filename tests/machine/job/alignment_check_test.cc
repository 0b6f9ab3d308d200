// SPDX-License-Identifier: Apache-2.0
#include "machine/job/alignment_check.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal {
namespace {

/// A panel whose four pads lie at the corners of (0, 0) to (80, 60), measured from (-900, 70) of
/// the machine.
WalkOptions aligned_walk() {
  WalkOptions walk;
  walk.series_size = 4;
  walk.absolute_zero = position_mm<frame::Machine>(-1000, 20);
  walk.work_zero = position_mm<frame::Machine>(100, 50);
  NominalSource panel;
  DiagnosticLog log;
  const Program pads = test::program_of(
      "M48\nMETRIC,TZ\nVER,1\n%\nG34,1\nG36X0.0Y0.0\nG36X80.0Y0.0\nG36X80.0Y60.0\n"
      "G36X0.0Y60.0\nM30\n");
  walk.aligned = std::make_shared<const Survey>(survey(pads, walk, panel, log));
  EXPECT_FALSE(log.has_errors()) << test::all_text(log);
  return walk;
}

/// How a program with these lines in its header and holes at these places is refused.
std::string refusal(const std::string& header, const std::string& holes) {
  const WalkOptions walk = aligned_walk();
  const Program program = test::program_of("M48\nMETRIC,TZ\nVER,1\nT1C0.8F100\n" + header +
                                           "%\nT1\n" + holes + "M30\n");
  DiagnosticLog log;
  const CheckedWalk checked = check(program, walk, log);
  EXPECT_FALSE(log.has_errors()) << test::all_text(log);
  const Expected<void> fits = check_fits_alignment(program, walk, checked.survey);
  return fits ? "none" : fits.error().text();
}

constexpr const char* kHoles = "X10.0Y10.0\nX70.0Y50.0\n";

TEST(AlignmentCheck, RefusesAnotherWorkZero) {
  EXPECT_EQ(refusal("", kHoles), "none");
  // In place of [100, 50], and beside it.
  const std::string corrected = refusal("ZC,X3.0Y4.0\n", kHoles);
  EXPECT_NE(corrected.find("from another work zero than the pads"), std::string::npos) << corrected;
  EXPECT_NE(corrected.find("they from (-900.000, 70.000) mm"), std::string::npos) << corrected;
  EXPECT_NE(refusal("Z,X3.0Y4.0\n", kHoles).find("from another work zero"), std::string::npos);
}

/// The pads lie from (0, 0) to (80, 60): half of them is 40 by 30.
TEST(AlignmentCheck, RefusesFilesOfTwoOrigins) {
  // The board's middle is the origin of one.
  const std::string shifted = refusal("", "X-41.0Y10.0\nX38.0Y50.0\n");
  EXPECT_NE(shifted.find("(-41.000, 10.000) to (38.000, 50.000) mm"), std::string::npos) << shifted;
  EXPECT_NE(shifted.find("(0.000, 0.000) to (80.000, 60.000) mm"), std::string::npos) << shifted;
}

TEST(AlignmentCheck, TakesHolesAroundThePadsAndAmongThem) {
  EXPECT_EQ(refusal("", "X-60.0Y-50.0\nX140.0Y110.0\n"), "none");
  EXPECT_EQ(refusal("", "X5.0Y5.0\nX9.0Y9.0\n"), "none") << "few, in a corner";
  EXPECT_EQ(refusal("", "X40.0Y30.0\n"), "none");
  EXPECT_EQ(refusal("", "X-60.0Y10.0\nX80.0Y50.0\n"), "none") << "beyond at one side only";
  EXPECT_EQ(refusal("", "X-30.0Y10.0\nX50.0Y50.0\n"), "none") << "by 30 of 80, as a tab would";
}

}  // namespace
}  // namespace panelcal
