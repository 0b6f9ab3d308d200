// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/spindle_camera.h"

#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearPosition;

TEST(SpindleCamera, LookingAtAPointPutsTheAxisOverIt) {
  const SpindleCameraOffset offset = {displacement_mm<frame::Machine>(80.25, -3.5)};
  const auto target = position_mm<frame::Machine>(200, 100);
  const auto spindle = offset.spindle_to_see(target);
  // Semantics, "Frames and order of operations": the spindle axis is commanded to p - d.
  EXPECT_EQ(spindle, position_mm<frame::Machine>(119.75, 103.5));
  EXPECT_EQ(offset.optical_axis(spindle), target);
}

TEST(SpindleCamera, ASeenPointLiesBesideTheOpticalAxis) {
  const SpindleCameraOffset offset = {displacement_mm<frame::Machine>(80, 0)};
  const auto spindle = position_mm<frame::Machine>(10, 20);
  const auto point =
      machine_from_optical(offset.optical_axis(spindle), position_mm<frame::Optical>(0.25, -0.5));
  EXPECT_THAT(point, IsNearPosition(position_mm<frame::Machine>(90.25, 19.5), um(1e-9)));
}

}  // namespace
}  // namespace panelcal
