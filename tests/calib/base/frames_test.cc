// SPDX-License-Identifier: Apache-2.0
#include "calib/base/frames.h"

#include <concepts>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearPosition;

using NominalPoint = Position<frame::Nominal>;
using ActualPoint = Position<frame::Actual>;

template <class A, class B>
concept Adds = requires(A a, B b) {
  a + b;
};
template <class A, class B>
concept Subtracts = requires(A a, B b) {
  a - b;
};
template <class A, class B>
concept Multiplies = requires(A a, B b) {
  a* b;
};
template <class A>
concept InMm = requires(A a) {
  a.in_mm();
};
template <class A>
concept InPx = requires(A a) {
  a.in_px();
};

// An expression that mixes frames does not compile.
static_assert(Subtracts<NominalPoint, NominalPoint>);
static_assert(!Subtracts<NominalPoint, ActualPoint>);
static_assert(!Adds<NominalPoint, NominalPoint>);
static_assert(Adds<NominalPoint, Displacement<frame::Nominal>>);
static_assert(!Adds<NominalPoint, Displacement<frame::Actual>>);
static_assert(!std::is_convertible_v<NominalPoint, ActualPoint>);
static_assert(!std::is_constructible_v<NominalPoint, Eigen::Vector2d>);
static_assert(InMm<NominalPoint> && !InPx<NominalPoint>);
static_assert(InPx<Position<frame::Image>> && !InMm<Position<frame::Image>>);
static_assert(
    Multiplies<Transform<frame::Actual, frame::Base>, Transform<frame::Base, frame::Nominal>>);
static_assert(
    !Multiplies<Transform<frame::Base, frame::Nominal>, Transform<frame::Actual, frame::Base>>);
static_assert(std::invocable<Transform<frame::Actual, frame::Base>, Position<frame::Base>>);
static_assert(!std::invocable<Transform<frame::Actual, frame::Base>, NominalPoint>);

Eigen::Matrix2d matrix(double a, double b, double c, double d) {
  Eigen::Matrix2d m;
  m << a, b, c, d;
  return m;
}

TEST(Frames, PositionsAndDisplacementsFormAnAffineSpace) {
  const auto p = position_mm<frame::Actual>(3, 4);
  const auto d = displacement_mm<frame::Actual>(0.5, -0.25);
  EXPECT_EQ((p + d) - p, d);
  EXPECT_EQ((p + d) - d, p);
  EXPECT_EQ(2.0 * d, d + d);
  EXPECT_EQ(-d + d, Displacement<frame::Actual>());
  EXPECT_EQ(position_px(2, 3).in_px(), Eigen::Vector2d(2, 3));
}

TEST(Frames, TransformsMoveDisplacementsWithoutTheTranslation) {
  const Transform<frame::Actual, frame::Nominal> t(matrix(0, -1, 1, 0), {10, 20});
  EXPECT_EQ(t(position_mm<frame::Nominal>(1, 2)), position_mm<frame::Actual>(8, 21));
  EXPECT_EQ(t(displacement_mm<frame::Nominal>(1, 2)), displacement_mm<frame::Actual>(-2, 1));
}

TEST(Frames, CompositionIsOneAfterTheOther) {
  Random random(91);
  const auto any = [&] { return random.uniform(-2, 2); };
  for (int trial = 0; trial < 100; ++trial) {
    const Transform<frame::Base, frame::Nominal> first(matrix(any(), any(), any(), any()),
                                                       {any(), any()});
    const Transform<frame::Actual, frame::Base> second(matrix(any(), any(), any(), any()),
                                                       {any(), any()});
    const auto p = position_mm<frame::Nominal>(any(), any());
    EXPECT_THAT((second * first)(p), IsNearPosition(second(first(p)), mm(1e-14)));
  }
}

TEST(Frames, InverseLeadsBack) {
  const Transform<frame::Actual, frame::Nominal> t(matrix(1.1, 0.2, -0.3, 0.9), {100, -50});
  const auto p = position_mm<frame::Nominal>(12, 34);
  EXPECT_THAT(t.inverse()(t(p)), IsNearPosition(p, mm(1e-13)));
}

}  // namespace
}  // namespace panelcal
