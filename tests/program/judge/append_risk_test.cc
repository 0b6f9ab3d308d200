// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <string>

#include "calib/base/statistics/random.h"
#include "program/writers/text_writer.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

std::string written(double risk) {
  std::string out;
  append_risk(out, risk);
  return out;
}

TEST(AppendRisk, HasFourDigits) {
  EXPECT_EQ(written(0.25), "0.25");
  EXPECT_EQ(written(0.0123456), "0.01235");
  EXPECT_EQ(written(0.0001), "0.0001");
  EXPECT_EQ(written(0.00001), "1e-05");
  EXPECT_EQ(written(1.23456e-12), "1.235e-12");
  EXPECT_EQ(written(9.9996e-10), "1e-09");
  EXPECT_EQ(written(0.99999), "1");
}

TEST(AppendRisk, IsBetweenImpossibleAndCertain) {
  EXPECT_EQ(written(0), "0");
  EXPECT_EQ(written(5e-324), "0");
  EXPECT_EQ(written(1), "1");
  EXPECT_EQ(written(2), "1");
  EXPECT_EQ(written(std::numeric_limits<double>::quiet_NaN()), "1");
}

TEST(AppendRisk, AgreesWithTheLibrary) {
  constexpr int kValues = 50'000;
  Random random(20260703);
  for (int i = 0; i < kValues; ++i) {
    const double risk = std::pow(10, -random.uniform(0, i % 2 == 0 ? 8 : 299));
    ASSERT_EQ(written(risk), fmt::format("{:.4g}", risk));
  }
}

}  // namespace
}  // namespace panelcal
