// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/frames.h"
#include "program/writers/svg/sheet.h"

namespace panelcal {

/// A vision target in the picture.
struct SvgTarget {
  Position<frame::Actual> at;
  std::string label;
  std::optional<Displacement<frame::Actual>> residual;  ///< measured minus fitted
};

namespace svg {

/// Targets as crosses in rings, with arrows for their residuals. All arrows are magnified alike, so
/// that the longest is a good part of the panel.
class Targets {
 public:
  Targets(const std::vector<SvgTarget>& targets, const Sheet& sheet);

  std::string marks() const;                           ///< in the drawing, y up
  std::string labels() const;                          ///< above it, y down
  double arrow_scale() const { return arrow_scale_; }  ///< 0: there are no arrows
  double longest_residual_mm() const { return longest_mm_; }

 private:
  std::string cross(const Eigen::Vector2d& at_mm) const;

  const std::vector<SvgTarget>& targets_;
  double size_mm_ = 0;  ///< of an arm
  double longest_mm_ = 0;
  double arrow_scale_ = 0;
};

}  // namespace svg
}  // namespace panelcal
