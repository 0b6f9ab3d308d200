// SPDX-License-Identifier: Apache-2.0
// Do charts alarm falsely as often as they say? Runs of many nights of independent standard scores.
#include <cmath>

#include "calib/base/statistics/random.h"
#include "calib/charts/cusum.h"
#include "calib/charts/ewma.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr int kSeries = 20000;
constexpr double kNights = 200;
/// Run lengths are nearly exponential, so their mean over the series has this relative sigma.
const double kBand = 4 / std::sqrt(static_cast<double>(kSeries));

template <class Chart, class Add>
double mean_run_length(Chart chart, const Add& add) {
  const Random seed(77);
  double sum = 0;
  for (int i = 0; i < kSeries; ++i) {
    Random random = seed.fork(static_cast<std::uint64_t>(i));
    chart.restart();
    int night = 1;
    while (!add(chart, random)) ++night;
    sum += night;
  }
  return sum / kSeries;
}

TEST(ChartsSlow, AveragesRunAsLongAsTheySay) {
  for (const int n_axes : {1, 2, 3}) {
    const double nights = mean_run_length(EwmaChart(n_axes, 0.2, kNights),
                                          [n_axes](EwmaChart& chart, Random& random) {
                                            Eigen::VectorXd u(n_axes);
                                            for (double& v : u) v = random.normal();
                                            return chart.add(u);
                                          });
    EXPECT_NEAR(nights / kNights, 1, kBand) << n_axes << " axes";
  }
}

TEST(ChartsSlow, SumsRunAsLongAsTheySay) {
  const auto add = [](CusumChart& chart, Random& random) { return chart.add(random.normal()); };
  EXPECT_NEAR(mean_run_length(CusumChart(Shift::Both, 0.25, kNights), add) / kNights, 1, kBand);
  EXPECT_NEAR(mean_run_length(CusumChart(Shift::Up, 0.5, kNights), add) / kNights, 1, kBand);
}

}  // namespace
}  // namespace panelcal
