// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/detector.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/fit/pipeline.h"
#include "vision/polygon/fit.h"
#include "vision/polygon/target.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

constexpr double kQuarterTurn = std::numbers::pi / 2;
constexpr double kSamePolygon = 0.3;    // of the size: nearer candidates are one
constexpr double kSearchMargin = 0.15;  // around the target, of its size
constexpr double kMinSizePx = 6;
/// Behind a blur of a larger part of its size a square looks like a disc (docs/formats).
constexpr double kMaxBlurOfSize = 0.15;

/// Appearance of a target; pattern units are those of the fit frame.
struct ExpectedCells {
  Shape shape = Shape::Square;
  double size = 0;
  double width = 0;  ///< crosses
  double angle_rad = 0;
  double angle_tolerance_rad = 0;

  /// A diamond is a square on its tip.
  double turn_rad() const { return shape == Shape::Diamond ? kQuarterTurn / 2 : 0; }
  /// The narrowest part of the target.
  double thickness() const { return shape == Shape::Cross ? width : size; }
};

CellPattern pattern_of(Shape shape, double size, double width) {
  const double l = size / 2;
  const double w = width / 2;
  if (shape != Shape::Cross) {
    return {{-l, l}, {-l, l}, {Cell::Target}, Cell::Background, {}, {}};
  }
  constexpr Cell kOff = Cell::Background;
  constexpr Cell kOn = Cell::Target;
  return {{-l, -w, w, l},
          {-l, -w, w, l},
          {kOff, kOn, kOff, kOn, kOn, kOn, kOff, kOn, kOff},
          Cell::Background,
          {-1, -1, 1, 1},
          {-1, -1, 1, 1}};
}

ExpectedCells expected_cells(const Target& target, const CameraMapping* mapping) {
  ExpectedCells expected;
  expected.shape = target.shape;
  expected.size = frame_length(target.size, target.size_px, mapping).value_or(0);
  expected.width = frame_length(target.width, target.width_px, mapping).value_or(0);
  expected.angle_rad = target.angle.in_rad();
  // All three shapes look the same after a quarter turn.
  expected.angle_tolerance_rad = std::min(target.angle_tolerance.in_rad(), kQuarterTurn / 2);
  return expected;
}

double half_of_square(double angle_rad) {
  return 0.5 * (std::abs(std::cos(angle_rad)) + std::abs(std::sin(angle_rad))) + kSearchMargin;
}

std::vector<Eigen::Vector2d> polygon_outline(const ExpectedCells& expected,
                                             const CellState& state) {
  const double l = expected.size / 2 + state.growth;
  const double w = expected.width / 2 + state.growth;
  std::vector<Eigen::Vector2d> corners = {{l, l}, {-l, l}, {-l, -l}, {l, -l}};
  if (expected.shape == Shape::Cross) {
    corners = {{l, w},
               {w, w},
               {w, l},
               {-w, l},
               {-w, w},
               {-l, w},
               {-l, -w},
               {-w, -w},
               {-w, -l},
               {w, -l},
               {w, -w},
               {l, -w}};
  }
  for (Eigen::Vector2d& v : corners) v = state.to_frame(v);
  return corners;
}

/// Squares, diamonds and crosses.
class Polygons {
 public:
  struct Sighting {
    FitFrame fit_frame;
    CellState state;
    Eigen::Vector2d center_px;
  };
  struct Fit {
    FitFrame fit_frame;
    CellFit cells;
    double size = 0;  ///< frame units
    double width = 0;
    TargetFit target;
  };

  explicit Polygons(const DetectorInput& input)
      : input_(input),
        expected_(expected_cells(input.target, input.mapping)),
        model_(pattern_of(expected_.shape, expected_.size, expected_.width),
               PoseKind::Similarity,
               Eigen::Vector2d::Zero(),
               0.5 * expected_.size),
        search_{.size = expected_.size,
                .seen_px = 16,
                .reach_px = 0.9 * expected_.size + 4,
                .half_of_size = half_of_square,
                .angle_rad = expected_.angle_rad + expected_.turn_rad(),
                .angle_tolerance_rad = expected_.angle_tolerance_rad} {
    options_.reach = std::clamp(8 + 0.2 * expected_.size, 10.0, 26.0);
    options_.start_error = std::max(1.0, 0.3 * search_.factor());
    options_.max_sigma_px = std::min(input.options.max_blur_px, kMaxBlurOfSize * expected_.size);
    options_.may_be_textured = true;
  }

  Proposals<Sighting> propose() const {
    if (expected_.thickness() < kMinSizePx / 2 || expected_.size < kMinSizePx) return {};
    const CellSightings seen = search_cells(input_, search_, model_);
    std::vector<Sighting> sightings;
    for (const auto& [at_px, start] : seen.peaks) {
      if (sightings.size() >= kMaxFitted) break;
      if (!input_.area.contains(at_px, 0.5 * expected_.size)) continue;
      const FitFrame fit_frame(input_.mapping, at_px);
      const auto state = rough_fit(seen.reduced, fit_frame, model_, start, 0.25 * expected_.size);
      const auto u = state ? fit_frame.to_image(state->to_frame({0, 0})) : std::nullopt;
      if (!u || !input_.area.contains(*u, 2.0 * search_.factor())) continue;
      const bool is_new = std::ranges::none_of(sightings, [&](const Sighting& s) {
        return (s.center_px - *u).norm() < kSamePolygon * expected_.size;
      });
      if (is_new) sightings.push_back({fit_frame, *state, *u});
    }
    return {std::move(sightings)};
  }

  Fit fit(const Sighting& sighting) const {
    const FitFrame& fit_frame = sighting.fit_frame;
    Fit fit{fit_frame, fit_cells(input_.image, fit_frame, model_, sighting.state, options_)};
    const CellState& state = fit.cells.state;
    const auto [scale, angle_rad] = pose_of(state);
    fit.size = scale * (expected_.size + 2 * state.growth);
    fit.width = scale * (expected_.width + 2 * state.growth);
    // Of the four equal ones the one nearest to what is asked for.
    const double turn_rad = angle_rad - expected_.turn_rad() - expected_.angle_rad;
    fill_target(fit_frame,
                model_,
                fit.cells,
                place_of(model_, fit.cells, {0, 0}),
                fit.size,
                expected_.angle_rad + std::remainder(turn_rad, kQuarterTurn),
                fit.target);
    fit.target.outlines_px = {in_picture(fit_frame, polygon_outline(expected_, state))};
    return fit;
  }

  Judgement judge(const Fit& fit) const {
    return judge_cells(input_,
                       fit.cells,
                       fit.target,
                       {.border = "outline",
                        .unfit = unfit_problem(fit),
                        .turn_rad = fit.target.angle.in_rad() - expected_.angle_rad,
                        .turn_tolerance_rad = expected_.angle_tolerance_rad,
                        .max_sigma_px = options_.max_sigma_px});
  }

 private:
  Problem unfit_problem(const Fit& fit) const {
    if (fit.cells.outside_picture > 0) {
      return "at the border: a part of its outline is outside of the picture";
    }
    const double tolerance = input_.target.size_tolerance;
    auto problem = size_problem(fit.fit_frame, "its size", fit.size, expected_.size, tolerance);
    if (problem || expected_.shape != Shape::Cross) return problem;
    return size_problem(fit.fit_frame, "its width", fit.width, expected_.width, tolerance);
  }

  const DetectorInput& input_;
  ExpectedCells expected_;
  CellModel model_;
  CellSearch search_;
  CellFitOptions options_;
};

}  // namespace

std::vector<FittedCandidate> detect_cells(const DetectorInput& input) {
  return detect(input, Polygons(input));
}

}  // namespace panelcal::internal
