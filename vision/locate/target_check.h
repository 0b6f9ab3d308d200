// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/camera/mapping.h"
#include "vision/fit/target.h"

// Not installed: what machine.toml is checked for.
namespace panelcal::internal {

/// The flaw of a target that no picture could mend.
struct TargetProblem {
  std::string why;
  /// It is its angle that cannot be told: a smaller angle_tolerance helps.
  bool is_of_angle = false;
};

/// Checks that a target's own looks determine its place and its angle: templates that are flat,
/// show parallel edges only or are too small in pictures, and templates and dot-codes that look the
/// same when turned within their tolerance.
///
/// In     a valid target; the mapping if its size is in mm
/// Cost   that of preparing a template once; of a template that may be turned far, 10 ms more
/// See    tests/vision/locate/target_check_test.cc
std::optional<TargetProblem> target_problem(const Target& target, const CameraMapping* mapping);

}  // namespace panelcal::internal
