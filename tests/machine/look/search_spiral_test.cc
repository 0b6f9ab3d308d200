// SPDX-License-Identifier: Apache-2.0
#include "machine/look/search_spiral.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

constexpr int kPoints = 2000;

/// 6.4 x 4.8 mm a picture; turned, off-centre and with a lens.
ZoomedCamera camera(double rotation_rad, double k1_per_px2) {
  CameraMapping::Parameters parameters;
  parameters.scale_mm_per_px = 0.01;
  parameters.rotation_rad = rotation_rad;
  parameters.axis_px << 330, 231;
  parameters.k1_per_px2 = k1_per_px2;
  return {CameraMapping(parameters), 640, 480};
}

const Position<frame::Machine> kExpected = position_mm<frame::Machine>(120, -40);
constexpr Length kMargin = mm(0.62);

/// True if some view shows a target at `place`, margin and all, by the camera's own arithmetic.
bool is_seen(const ZoomedCamera& camera,
             const std::vector<Position<frame::Machine>>& axes,
             const Position<frame::Machine>& place) {
  const double margin_px = kMargin.in_mm() / 0.01;
  return std::ranges::any_of(axes, [&](const Position<frame::Machine>& axis) {
    const auto pixel = camera.pixel_of(place, axis);
    if (!pixel) return false;
    const Eigen::Vector2d& u = pixel->in_px();
    return u.x() >= margin_px && u.x() <= 639 - margin_px && u.y() >= margin_px &&
           u.y() <= 479 - margin_px;
  });
}

TEST(SearchSpiral, SeesEveryPlaceOfTheAreaWithTheTargetWhole) {
  for (const double rotation_rad : {0.0, 0.35, 1.6, -2.9}) {
    for (const double k1_per_px2 : {-1e-7, 0.0, 1e-7}) {
      for (const double radius_mm : {0.5, 3.0, 9.0}) {
        const ZoomedCamera camera = panelcal::camera(rotation_rad, k1_per_px2);
        const auto view = usable_view(camera, kMargin);
        ASSERT_TRUE(view) << view.error().text();
        const auto axes = search_spiral(kExpected, mm(radius_mm), *view);
        ASSERT_TRUE(axes) << axes.error().text();
        Random random(11);
        for (int i = 0; i < kPoints; ++i) {
          const double r_mm = radius_mm * std::sqrt(random.uniform());
          const double angle = random.uniform(0, 2 * M_PI);
          const auto place = kExpected + displacement_mm<frame::Machine>(r_mm * std::cos(angle),
                                                                         r_mm * std::sin(angle));
          ASSERT_TRUE(is_seen(camera, *axes, place))
              << place.in_mm().transpose() << " turned " << rotation_rad << " k1 " << k1_per_px2;
        }
      }
    }
  }
}

TEST(SearchSpiral, BeginsInTheMiddleAndWalksOutwards) {
  const auto view = usable_view(camera(0, 0), kMargin);
  ASSERT_TRUE(view);
  const auto axes = search_spiral(kExpected, mm(9), *view);
  ASSERT_TRUE(axes);
  EXPECT_EQ(axes->front(), kExpected);
  std::set<std::pair<long, long>> cells;
  long outermost = 0;
  for (const auto& axis : *axes) {
    const Eigen::Vector2d step_mm = (axis - kExpected).in_mm();
    const long i = std::lround(step_mm.dot(view->along_mm) / view->along_mm.squaredNorm());
    const long j = std::lround(step_mm.dot(view->across_mm) / view->across_mm.squaredNorm());
    EXPECT_TRUE(cells.emplace(i, j).second) << "twice " << i << ' ' << j;
    const long ring = std::max(std::abs(i), std::abs(j));
    EXPECT_GE(ring, outermost);
    outermost = std::max(outermost, ring);
  }
  // pi 9^2 mm^2 in cells of about 5 x 3.5 mm, and those cut by the rim.
  EXPECT_GT(axes->size(), 254.0 / (5.1 * 3.6));
  EXPECT_LT(axes->size(), 32u);
}

TEST(SearchSpiral, SmallAreaIsOneView) {
  const auto view = usable_view(camera(0.1, 0), kMargin);
  ASSERT_TRUE(view);
  EXPECT_EQ(search_spiral(kExpected, mm(1.2), *view)->size(), 1u);
}

TEST(SearchSpiral, RefusesWhatCannotBeSearched) {
  EXPECT_THAT(usable_view(camera(0, 0), mm(2.5)), FailsWith(Code::NotSupported, "500.0 px"));
  const auto view = usable_view(camera(0, 0), kMargin);
  ASSERT_TRUE(view);
  EXPECT_THAT(search_spiral(kExpected, mm(300), *view), FailsWith(Code::NotSupported, "400 views"));
}

}  // namespace
}  // namespace panelcal
