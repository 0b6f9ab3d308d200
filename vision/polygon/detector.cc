// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/detector.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/fit/pattern_search.h"
#include "vision/fit/place.h"
#include "vision/polygon/fit.h"
#include "vision/polygon/target.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Verdict = FittedCandidate::Verdict;

constexpr double kQuarterTurn = std::numbers::pi / 2;
constexpr double kSamePolygon = 0.3;  // of the size: nearer candidates are one
/// The search sees the target about this number of pixels wide.
constexpr double kPolygonSearchPx = 16;
constexpr double kSearchMargin = 0.15;  // around the target, of its size
constexpr double kMinSizePx = 6;
/// A turn that moves the corners of the reduced target by about one of its pixels.
constexpr double kPolygonAngleStep = 0.2;
/// Sizes this much apart, relative, look alike to the search.
constexpr double kPolygonSizeStep = 0.12;
/// Behind a blur of a larger part of its size a square looks like a disc (docs/formats).
constexpr double kMaxBlurOfSize = 0.15;
/// Correlations in the search below this are not the target.
constexpr double kMinPolygonCorrelation = 0.5;

/// Appearance of a target; pattern units are those of the fit frame.
struct ExpectedCells {
  CellPattern pattern;
  Shape shape = Shape::Square;
  double size = 0;
  double width = 0;  ///< crosses
  double angle_rad = 0;
  double angle_tolerance_rad = 0;
  double size_tolerance = 0;
  bool is_dark = false;

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
  expected.pattern = pattern_of(target.shape, expected.size, expected.width);
  expected.angle_rad = target.angle.in_rad();
  // All three shapes look the same after a quarter turn.
  expected.angle_tolerance_rad = std::min(target.angle_tolerance.in_rad(), kQuarterTurn / 2);
  expected.size_tolerance = target.size_tolerance;
  expected.is_dark = target.polarity == Polarity::Dark;
  return expected;
}

CellModel polygon_model(const ExpectedCells& expected) {
  return {expected.pattern, PoseKind::Similarity, Eigen::Vector2d::Zero(), 0.5 * expected.size};
}

/// A pose that the search tries.
struct PolygonTrial {
  double angle_rad;
  double scale;
};

std::vector<PolygonTrial> polygon_trials(const ExpectedCells& expected) {
  const auto n_steps = [](double range, double step) {
    return static_cast<int>(std::ceil(range / step - 0.5));
  };
  const int n_angles = std::max(0, n_steps(expected.angle_tolerance_rad, kPolygonAngleStep));
  const int n_sizes = std::max(0, n_steps(expected.size_tolerance, kPolygonSizeStep));
  std::vector<PolygonTrial> trials;
  for (int i = -n_angles; i <= n_angles; ++i) {
    for (int k = -n_sizes; k <= n_sizes; ++k) {
      trials.push_back({expected.angle_rad + expected.turn_rad() + i * kPolygonAngleStep,
                        std::pow(1 + kPolygonSizeStep, k)});
    }
  }
  return trials;
}

/// A target seen in the reduced picture.
struct PolygonSighting {
  FitFrame fit_frame;
  CellState state;
  Eigen::Vector2d center_px;
};

/// A quick fit to the reduced picture, from where the search saw it.
std::optional<PolygonSighting> sighted(const ReducedPicture& reduced,
                                       const CameraMapping* mapping,
                                       const ExpectedCells& expected,
                                       const CellModel& model,
                                       const PolygonTrial& trial,
                                       const Eigen::Vector2d& at_px) {
  const FitFrame fit_frame(mapping, at_px);
  const CellState start = placed(Eigen::Vector2d::Zero(), trial.angle_rad, trial.scale);
  const auto state = rough_fit(reduced, fit_frame, model, start, 0.25 * expected.size);
  if (!state) return std::nullopt;
  const auto u = fit_frame.to_image(state->to_frame({0, 0}));
  if (!u) return std::nullopt;
  return PolygonSighting{fit_frame, *state, *u};
}

std::vector<PolygonSighting> see_cells(const DetectorInput& input,
                                       const ExpectedCells& expected,
                                       const CellModel& model) {
  const auto box = input.area.box(input.image, 0.9 * expected.size + 4);
  const int factor = std::max(1, static_cast<int>(std::lround(expected.size / kPolygonSearchPx)));
  const ReducedPicture reduced = reduce(input.image, box, factor);
  const Eigen::Vector2d middle(box.x0 + 0.5 * box.width, box.y0 + 0.5 * box.height);
  const Eigen::Matrix2d frame_from_px = FitFrame(input.mapping, middle).jacobian(middle);
  const std::vector<PolygonTrial> trials = polygon_trials(expected);
  std::vector<SearchPattern> patterns;
  for (const PolygonTrial& trial : trials) {
    const double diagonal =
        std::abs(std::cos(trial.angle_rad)) + std::abs(std::sin(trial.angle_rad));
    patterns.push_back(drawn(model,
                             placed(Eigen::Vector2d::Zero(), trial.angle_rad, trial.scale),
                             (0.5 * diagonal + kSearchMargin) * expected.size * trial.scale,
                             frame_from_px,
                             factor));
  }
  PatternSearchOptions options;
  options.min_correlation = kMinPolygonCorrelation;
  options.min_gain = 0.5 * input.options.min_contrast * input.image.full_scale();
  options.same_place = kSamePolygon * expected.size / factor;
  options.is_inverted = expected.is_dark;
  std::vector<PolygonSighting> sightings;
  for (const PatternPeak& peak : search_patterns(reduced, patterns, options)) {
    if (sightings.size() >= kMaxFitted) break;
    const Eigen::Vector2d at = reduced.in_picture(peak.at);
    if (!input.area.contains(at, 0.5 * expected.size)) continue;
    const auto sighting =
        sighted(reduced, input.mapping, expected, model, trials[peak.i_pattern], at);
    if (!sighting || !input.area.contains(sighting->center_px, 2.0 * factor)) continue;
    const bool is_new =
        std::none_of(sightings.begin(), sightings.end(), [&](const PolygonSighting& s) {
          return (s.center_px - sighting->center_px).norm() < kSamePolygon * expected.size;
        });
    if (is_new) sightings.push_back(*sighting);
  }
  return sightings;
}

/// Target by a fit, in frame units and radians.
struct MeasuredPolygon {
  double size = 0;
  double width = 0;
  double angle_rad = 0;
  double angle_sigma_rad = 0;
};

MeasuredPolygon measured_polygon(const ExpectedCells& expected, const CellFit& fit) {
  const Eigen::Matrix2d frame_from_pattern =
      fit.state.jacobian(fit.state.to_frame({0, 0})).inverse();
  const double scale = std::sqrt(std::abs(frame_from_pattern.determinant()));
  MeasuredPolygon m;
  m.size = scale * (expected.size + 2 * fit.state.growth);
  m.width = scale * (expected.width + 2 * fit.state.growth);
  const double angle = std::atan2(frame_from_pattern(1, 0), frame_from_pattern(0, 0));
  // Of the four equal ones the one nearest to what is asked for.
  m.angle_rad = expected.angle_rad +
                std::remainder(angle - expected.turn_rad() - expected.angle_rad, kQuarterTurn);
  m.angle_sigma_rad = std::sqrt(std::max(0.0, fit.cov(2, 2)));
  return m;
}

std::vector<Eigen::Vector2d> polygon_outline(const FitFrame& fit_frame,
                                             const ExpectedCells& expected,
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
  std::vector<Eigen::Vector2d> outline;
  for (const Eigen::Vector2d& v : corners) {
    if (const auto u = fit_frame.to_image(state.to_frame(v))) outline.push_back(*u);
  }
  return outline;
}

void fill_polygon(const FitFrame& fit_frame,
                  const ExpectedCells& expected,
                  const CellModel& model,
                  const CellFit& f,
                  const MeasuredPolygon& m,
                  TargetFit& fit) {
  const CellPlace place = place_of(model, f, {0, 0});
  set_place(fit_frame, place.at, place.cov, m.size, fit);
  fit.angle = rad(m.angle_rad);
  fit.angle_sigma = rad(m.angle_sigma_rad);
  set_quality(model, f, place, fit);
  fit.outlines_px = {polygon_outline(fit_frame, expected, f.state)};
}

std::optional<std::string> unfit_polygon_reason(const FitFrame& fit_frame,
                                                const ExpectedCells& expected,
                                                const CellFit& f,
                                                const MeasuredPolygon& m) {
  if (f.outside_picture > 0) {
    return "at the border: a part of its outline is outside of the picture";
  }
  if (auto reason =
          size_problem(fit_frame, "its size", m.size, expected.size, expected.size_tolerance)) {
    return reason;
  }
  if (expected.shape == Shape::Cross) {
    if (auto reason = size_problem(
            fit_frame, "its width", m.width, expected.width, expected.size_tolerance)) {
      return reason;
    }
  }
  return std::nullopt;
}

FittedCandidate fitted_polygon(const DetectorInput& input,
                               const ExpectedCells& expected,
                               const CellModel& model,
                               const PolygonSighting& sighting,
                               int factor) {
  CellFitOptions options;
  options.reach = std::clamp(8 + 0.2 * expected.size, 10.0, 26.0);
  options.start_error = std::max(1.0, 0.3 * factor);
  options.max_sigma_px = std::min(input.options.max_blur_px, kMaxBlurOfSize * expected.size);
  options.may_be_textured = true;
  const CellFit fit = fit_cells(input.image, sighting.fit_frame, model, sighting.state, options);
  FittedCandidate candidate;
  const MeasuredPolygon m = measured_polygon(expected, fit);
  fill_polygon(sighting.fit_frame, expected, model, fit, m, candidate.fit);
  judge_cells(input,
              fit,
              {.border = "outline",
               .unfit = unfit_polygon_reason(sighting.fit_frame, expected, fit, m),
               .turn_rad = m.angle_rad - expected.angle_rad,
               .turn_sigma_rad = m.angle_sigma_rad,
               .turn_tolerance_rad = expected.angle_tolerance_rad,
               .max_sigma_px = options.max_sigma_px},
              candidate);
  return candidate;
}

}  // namespace

std::vector<FittedCandidate> detect_cells(const DetectorInput& input) {
  const ExpectedCells expected = expected_cells(input.target, input.mapping);
  std::vector<FittedCandidate> candidates;
  if (expected.thickness() < kMinSizePx / 2 || expected.size < kMinSizePx) return candidates;
  const CellModel model = polygon_model(expected);
  const int factor = std::max(1, static_cast<int>(std::lround(expected.size / kPolygonSearchPx)));
  for (const PolygonSighting& sighting : see_cells(input, expected, model)) {
    auto candidate = fitted_polygon(input, expected, model, sighting, factor);
    if (input.area.contains(candidate.fit.center.position.in_px(), 0)) {
      candidates.push_back(std::move(candidate));
    }
  }
  return candidates;
}

}  // namespace panelcal::internal
