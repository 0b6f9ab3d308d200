// SPDX-License-Identifier: Apache-2.0
#include "tools/history/certificate/certificate.h"

#include <cmath>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

namespace panelcal::history {
namespace {

/// GUM, table G.2, columns 95.45 and 99.73: two decimals.
constexpr double kHalfDigit = 0.005;

TEST(Certificate, CoverageFactorsAreThoseOfTheGum) {
  EXPECT_NEAR(coverage_factor_of(0.9545, 1), 13.97, kHalfDigit);
  EXPECT_NEAR(coverage_factor_of(0.9545, 2), 4.53, kHalfDigit);
  EXPECT_NEAR(coverage_factor_of(0.9545, 5), 2.65, kHalfDigit);
  EXPECT_NEAR(coverage_factor_of(0.9545, 10), 2.28, kHalfDigit);
  EXPECT_NEAR(coverage_factor_of(0.9545, 50), 2.05, kHalfDigit);
  EXPECT_NEAR(coverage_factor_of(0.9973, 4), 6.62, kHalfDigit);
  EXPECT_NEAR(coverage_factor_of(0.9545, std::nullopt), 2.000, 0.001);
}

TEST(Certificate, BudgetOfTheGumsEndGauge) {
  // GUM, H.1.6: effective degrees of freedom 16.7 of the parts of u_c = 31.7 nm (here as x, in nm).
  UncertaintyBudget budget;
  for (const auto& [sigma, degrees] : {std::pair(25.0, 18.0), std::pair(9.7, 25.6)}) {
    budget.rows.push_back({"look", 'A', {sigma, 0}, degrees, ""});
  }
  budget.rows.push_back({"plate", 'B', {2.9, 0}, 50, ""});
  budget.rows.push_back({"table", 'B', {16.6, 0}, 2, ""});
  EXPECT_NEAR(budget.combined_mm()[0], 31.7, 0.1);
  EXPECT_NEAR(*budget.degrees_of_freedom()[0], 16.7, 0.3);
  EXPECT_FALSE(budget.degrees_of_freedom()[1]);
}

TEST(Certificate, GaugeWithoutAScatterBetweenNightsIsThatOfItsLooks) {
  GaugeStudy gauge;
  gauge.repeatability = {4, 20};
  gauge.over_nights = {1, 6};
  gauge.within_variance = 3;
  EXPECT_EQ(gauge.reproducibility_variance(), 0);
  EXPECT_EQ(gauge.both().variance, 4);
  EXPECT_DOUBLE_EQ(gauge.both().degrees_of_freedom, 20);
  gauge.over_nights = {8, 6};
  EXPECT_EQ(gauge.both().variance, 9);
  EXPECT_DOUBLE_EQ(gauge.both().degrees_of_freedom, 81 / (16 / 20.0 + 64 / 6.0));
}

TEST(Certificate, IntervalOfASigmaIsThatOfChiSquare) {
  // Chi-square tables: of 10 degrees of freedom 3.247 and 20.483.
  const Scatter scatter{1, 10};
  EXPECT_NEAR(scatter.interval()[0], std::sqrt(10 / 20.483), 1e-4);
  EXPECT_NEAR(scatter.interval()[1], std::sqrt(10 / 3.247), 1e-4);
}

}  // namespace
}  // namespace panelcal::history
