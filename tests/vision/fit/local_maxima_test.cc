// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/local_maxima.h"

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

TEST(LocalMaxima, AreHighestFirstAndNoLowerThanAsked) {
  const cv::Mat map = (cv::Mat_<float>(3, 6) << 5,
                       1,
                       1,
                       1,
                       1,
                       9,  //
                       1,
                       1,
                       1,
                       1,
                       1,
                       1,  //
                       1,
                       1,
                       7,
                       1,
                       1,
                       2);
  const auto maxima = local_maxima(map, 3);
  ASSERT_EQ(maxima.size(), 3U);
  EXPECT_EQ(maxima[0], cv::Point(5, 0));
  EXPECT_EQ(maxima[1], cv::Point(2, 2));
  EXPECT_EQ(maxima[2], cv::Point(0, 0));
}

TEST(LocalMaxima, OfEqualNeighboursTheFirstCounts) {
  const cv::Mat map = (cv::Mat_<float>(2, 3) << 0,
                       4,
                       4,  //
                       0,
                       4,
                       0);
  const auto maxima = local_maxima(map, 1);
  ASSERT_EQ(maxima.size(), 1U);
  EXPECT_EQ(maxima[0], cv::Point(1, 0));
}

TEST(LocalMaxima, AnEmptyMapHasNone) {
  EXPECT_TRUE(local_maxima({}, 0).empty());
}

}  // namespace
}  // namespace panelcal::internal
