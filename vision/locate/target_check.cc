// SPDX-License-Identifier: Apache-2.0
#include "vision/locate/target_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/base/units.h"
#include "vision/fit/frame.h"
#include "vision/polygon/dot_code.h"
#include "vision/template/model.h"
#include "vision/template/symmetry.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// A little more, so that half a turn is below it.
constexpr double kMaxHalfTurn = 1.001 * std::numbers::pi;

/// Two poses within the tolerance are at most so far apart; both ends at once are no case of life.
double turn_limit(const Target& target) {
  constexpr double kInside = 0.999;
  return std::min(2 * kInside * target.angle_tolerance.in_rad(), kMaxHalfTurn);
}

TargetProblem same_when_turned(const std::string& what, double turn_rad) {
  return {fmt::format("{} looks the same when turned by {:.0f} degrees",
                      what,
                      std::abs(rad(turn_rad).in_deg())),
          true};
}

std::optional<TargetProblem> template_problem(const Target& target, const CameraMapping* mapping) {
  const double width = frame_length(target.size, target.size_px, mapping).value_or(0);
  const auto model = make_template_model(*target.picture, width, mapping ? -1 : 1);
  if (!model) return TargetProblem{model.error()};
  const auto turn_rad = self_turn(*model, turn_limit(target));
  if (!turn_rad) return std::nullopt;
  return same_when_turned("the template " + target.picture->file, *turn_rad);
}

std::optional<TargetProblem> dots_problem(const Target& target) {
  DotCode code;
  code.dots = target.dots;
  code.turn_tolerance = turn_limit(target);
  code.scale_tolerance = target.size_tolerance;
  const double size = target.size ? target.size->in_mm() : target.size_px->in_px();
  code.place_tolerance = kDotPlaceTolerance * size;
  code.fits_scale = !target.size;
  const auto turn_rad = self_turn(code);
  if (!turn_rad) return std::nullopt;
  return same_when_turned("the code", *turn_rad);
}

}  // namespace

std::optional<TargetProblem> target_problem(const Target& target, const CameraMapping* mapping) {
  if (target.shape == Shape::Template) return template_problem(target, mapping);
  if (target.shape == Shape::Dots) return dots_problem(target);
  return std::nullopt;
}

}  // namespace panelcal::internal
