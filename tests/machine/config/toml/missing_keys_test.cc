// SPDX-License-Identifier: Apache-2.0
#include "machine/config/toml/missing_keys.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "machine/config/machine_config.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::Reports;
using testing::HasSubstr;
using testing::Not;

std::string refusal(std::string_view toml) {
  const auto config = parse_machine_config(toml, "machine.toml");
  return config ? "accepted" : config.error().text();
}

TEST(RequiredKeys, OfAllTablesAreNamedAtOnce) {
  EXPECT_THAT(refusal("[camera]\n[coupon]\nrows = 3\n[[vision.tool]]\nsize_px = 40\n"
                      "[[vision.tool]]\nnumber = 2\nshape = \"disc\"\n[[depth]]\n"),
              Reports("machine.toml:1:1: error[config-value]",
                      "[camera]: missing key \"calibration\"",
                      "[coupon] (line 2): missing key \"origin_mm\"",
                      "[[vision.tool]] (line 4): missing keys \"number\", \"shape\"",
                      "[[vision.tool]] (line 6): missing key \"size_mm\"",
                      "[[depth]] (line 9): missing keys \"number\", \"depth_mm\"",
                      "origin_mm = [x, y]"));
}

TEST(RequiredKeys, OfOneTableAreNamedOnceEach) {
  const std::string text = refusal("[[depth]]\n");
  EXPECT_THAT(text, HasSubstr("missing key \"depth_mm\""));
  EXPECT_EQ(text.find("\"number\""), text.rfind("\"number\"")) << text;
  EXPECT_THAT(refusal("[coupon]\n"), Not(HasSubstr("(line")));
  EXPECT_THAT(refusal("[[vision.tool]]\n"), Not(HasSubstr("(line")));
}

TEST(RequiredKeys, AreNotAddedToAnotherProblem) {
  EXPECT_THAT(refusal("[machine]\nname = 3\n[coupon]\n"), Not(HasSubstr("origin_mm")));
  EXPECT_THAT(refusal("[camera]\ncalibratoin = \"a\"\n[coupon]\n"), Not(HasSubstr("origin_mm")));
}

/// Each table alone, with all that it needs but one key: its reader refuses it, so that no table
/// here asks for what is not required.
TEST(RequiredKeys, AreThoseThatTheReadersRequire) {
  const std::vector<std::pair<std::string, std::string>> lacking = {
      {"[camera]\n", "calibration"},
      {"[coupon]\n", "origin_mm"},
      {"[[depth]]\ndepth_mm = 1\n", "number"},
      {"[[depth]]\nnumber = 1\n", "depth_mm"},
      {"[[diameter_page]]\n", "diameter_mm"},
      {"[ledger]\n", "file"},
      {"[nightly]\n", "machine_driver"},
      {"[nightly]\ncamera = \"folder:p\"\n[nightly.surface]\nlow_mm = [0, 0]\nhigh_mm = [1, 1]\n",
       "file"},
      {"[nightly]\ncamera = \"folder:p\"\n[nightly.surface]\nfile = \"s\"\nhigh_mm = [1, 1]\n",
       "low_mm"},
      {"[nightly]\ncamera = \"folder:p\"\n[nightly.surface]\nfile = \"s\"\nlow_mm = [0, 0]\n",
       "high_mm"},
      {"[nightly]\ncamera = \"folder:p\"\n[nightly.table]\n", "plate"},
      {"[table]\n", "calibration"},
      {"[[tolerance.tool]]\nposition_um = 5\n", "number"},
      {"[[vision.tool]]\nshape = \"disc\"\nsize_px = 9\n", "number"},
      {"[[vision.tool]]\nnumber = 1\nsize_px = 9\n", "shape"},
      {"[[vision.tool]]\nnumber = 1\nshape = \"disc\"\n", "size_mm"}};
  for (const auto& [toml, key] : lacking) {
    EXPECT_THAT(refusal(toml), testing::AllOf(HasSubstr("error[config-value]"), HasSubstr(key)))
        << toml;
  }
}

}  // namespace
}  // namespace panelcal
