// SPDX-License-Identifier: Apache-2.0
#include "vision/suggest/common_scale.h"

#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

CommonScale scale_of(const std::vector<double>& ratios) {
  CommonScale scale;
  for (const double ratio : ratios) {
    Detection detection;
    detection.size_ratio = ratio;
    scale.add(detection);
  }
  scale.add(Detection());  // of nothing that has a size
  return scale;
}

std::optional<std::string> words_of(const std::vector<double>& ratios) {
  return scale_of(ratios).words();
}

TEST(CommonScale, TellsOfOneFactor) {
  const auto larger = words_of({1.021, 1.02, 1.019, 1.02});
  ASSERT_TRUE(larger.has_value());
  EXPECT_TRUE(larger->starts_with("all 4 targets measure 2.0 % larger than stated (they"))
      << *larger;
  const auto smaller = words_of({0.5, 0.5, 0.5});
  ASSERT_TRUE(smaller.has_value());
  EXPECT_TRUE(smaller->starts_with("all 3 targets measure 50.0 % smaller")) << *smaller;
}

TEST(CommonScale, IsAWarningWithACode) {
  const auto warning = scale_of({1.021, 1.02, 1.019, 1.02}).warning("m.toml");
  ASSERT_TRUE(warning.has_value());
  EXPECT_EQ(warning->code, Code::ScaleSuspicious);
  EXPECT_EQ(warning->severity(), Severity::Warning);
  EXPECT_TRUE(warning->text().starts_with("m.toml: warning[scale-suspicious]")) << warning->text();
  EXPECT_FALSE(scale_of({1.001, 1.002, 1.001}).warning("m.toml").has_value());
}

TEST(CommonScale, IsSilentWithoutOne) {
  EXPECT_FALSE(words_of({1.02, 1.02}).has_value());
  EXPECT_FALSE(words_of({1.001, 1.002, 1.001}).has_value());
  EXPECT_FALSE(words_of({0.9, 1.02, 1.1, 0.98}).has_value());
}

}  // namespace
}  // namespace panelcal
