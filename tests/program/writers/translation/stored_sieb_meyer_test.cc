// SPDX-License-Identifier: Apache-2.0
// Corrections that copies keep for later patterns: G39,SAVE and G39,LOAD as M50, M51 and M52. Run
// on the same panel, source and translation drill the same holes.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/writers/translation/boards.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::same_holes;
using test::sieb_meyer;
using test::translate;
using test::Translation;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr char kOffsets[] = "X0.Y0.M50\nX50.Y0.M50\nX0.Y50.M50\nX100.Y50.M90M30\n";

/// SIEB & MEYER CNC 8x.00 Command Set, G39, Example.
TEST(StoredTranslation, TheManualsExampleOfG39) {
  const std::string text = same_holes(
      sieb_meyer("M31\nG34\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\nG30\n" + std::string(kOffsets) +
                 "M31\nG39,LOAD\nX10.Y20.T1\nX30.Y40.\n" + kOffsets + "G30\nX1.Y1.\n"));
  EXPECT_THAT(text, HasSubstr("M50,1\nM25\nG37\n"));
  EXPECT_THAT(text, HasSubstr("M51,1\nM25\nM52,2\n"));
}

TEST(StoredTranslation, TwoSectionsThatSaveAreTwoLabels) {
  const std::string first =
      "M31\nG34\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\n" + std::string(kOffsets);
  const std::string second =
      "M31\nG34\nX5.Y45.G32\nX45.Y5.G32\nX5.Y5.G32\nG31\nG39,SAVE\n" + std::string(kOffsets);
  const std::string use = "M31\nG39,LOAD\nX10.Y20.T1\nX30.Y40.\n" + std::string(kOffsets);
  const std::string text = same_holes(sieb_meyer(first + use + second + use));
  EXPECT_THAT(text, HasSubstr("M51,2\nM25\nM52,3\n"));
}

std::vector<std::string> errors_of(const std::string& body) {
  return translate(sieb_meyer(body), Dialect::Excellon).errors;
}

/// Boards may be left out where the program is run; M51 wants all of M50's.
TEST(StoredTranslation, RefusesToLoadTheSetsOfOtherCopies) {
  const std::string save = "M31\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\n" + std::string(kOffsets);
  const std::string load = "M31\nG39,LOAD\nX1.Y1.T1\n";
  const auto is_named = ElementsAre(
      test::Reports("p:11:1: error[not-supported]", "loads the corrections of other copies"));
  EXPECT_THAT(errors_of(save + load + "X0.Y0.M50M30\n"), is_named);
  EXPECT_THAT(errors_of(save + load + "X0.Y0.M50\nX50.Y0.M50M30\n"), is_named);
  EXPECT_THAT(errors_of(save + load + kOffsets), IsEmpty());
}

/// The control fits them with those of one copy.
TEST(StoredTranslation, RefusesTargetsThatOneCopyWouldTake) {
  const std::string two = "X5.Y5.G32\nX45.Y5.G32\nG31\n";
  for (const std::string save : {"G39,SAVE\n", "X7.Y7.T1\n"}) {
    EXPECT_THAT(errors_of("X5.Y45.G32\nM31\n" + two + save + kOffsets),
                ElementsAre(test::Reports("p:6:1: error[not-supported]",
                                          "\"G31\" with targets from ahead of its section")));
    EXPECT_THAT(errors_of("M31\n" + two + save + "X5.Y45.G32\n" + kOffsets + "G34\n"),
                ElementsAre(test::Reports("p:11:1: error[not-supported]",
                                          "leaves targets to its next copy")));
  }
  same_holes(sieb_meyer("X5.Y45.G32\nM31\n" + two + "X7.Y7.T1\nX0.Y0.M50M30\n"));
}

/// SIEB & MEYER CNC 8x.00 Command Set, G34, and G30: a second one running.
TEST(StoredTranslation, TargetsThatWaitAreCleared) {
  const std::string three = "X5.Y5.G32\nX45.Y5.G32\nX5.Y45.G32\nG31\n";
  for (const std::string clear : {"G34\n", "G30\nG30\n"}) {
    const std::string text =
        same_holes(sieb_meyer("X150.Y150.G32\n" + clear + three + "X9.Y9.T1\n"));
    EXPECT_THAT(text, HasSubstr("$uvis,alg,0,3\n"));
  }
  const std::string text =
      same_holes(sieb_meyer("X150.Y150.G32\nM31\nG34\n" + three + "G39,SAVE\n" + kOffsets +
                            "M31\nG39,LOAD\nX9.Y9.T1\n" + kOffsets));
  EXPECT_THAT(text, HasSubstr("M51,1\nM25\nM52,3\n"));
}

/// An offset under CAMA holds until the end of the copy that it was measured in.
TEST(StoredTranslation, AnOffsetOfTheProgramHoldsInSections) {
  const std::string section = "M31\nX2.Y2.\nX0.Y0.M50\nX50.Y0.M50M30\n";
  const std::string outside = "M49,CAMA\nX5.Y5.G36\nX1.Y1.T1\n";
  same_holes(sieb_meyer(outside + section + "X3.Y3.\nG34\nX4.Y4.\n"));
  EXPECT_THAT(errors_of(outside + "M31\nX5.Y6.G36\nX0.Y0.M50\nX50.Y0.M50M30\n"),
              ElementsAre(test::Reports("p:6:1: error[not-supported]",
                                        "\"X5.Y6.G36\" under an offset from outside")));
}

TEST(StoredTranslation, RefusesLocationsByNumberAndLateLoads) {
  EXPECT_THAT(errors_of("X5.Y5.G32\nG31\nG39,SAVE1\nX1.Y1.T1\n"),
              ElementsAre(test::Reports("p:4:1: error[not-supported]", "\"G39,SAVE1\"")));
  const Translation late =
      translate(sieb_meyer("M31\nX5.Y5.G32\nG31\nG39,SAVE\n" + std::string(kOffsets) +
                           "M31\nX9.Y9.T1\nG39,LOAD\nX1.Y1.\n" + kOffsets),
                Dialect::Excellon);
  EXPECT_TRUE(late.is_refused);
  EXPECT_THAT(late.losses, ElementsAre(HasSubstr("work ahead of G39,LOAD")));
}

}  // namespace
}  // namespace panelcal
