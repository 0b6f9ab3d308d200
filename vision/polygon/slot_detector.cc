// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vision/fit/detector.h"
#include "vision/fit/frame.h"
#include "vision/fit/pattern_search.h"
#include "vision/fit/place.h"
#include "vision/polygon/fit.h"
#include "vision/polygon/slot_follower.h"
#include "vision/polygon/target.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Verdict = FittedCandidate::Verdict;

constexpr double kSlotHalfTurn = std::numbers::pi;
constexpr std::size_t kMaxPeaks = 64;  // a slot has a ridge of them
constexpr double kMinWidthPx = 3;
/// The search sees the slot about this number of pixels wide.
constexpr double kSlotSearchPx = 8;
constexpr double kSlotAngleStep = 0.2;
constexpr double kSlotSizeStep = 0.12;
constexpr double kMinSlotCorrelation = 0.5;
/// A piece of this length, in widths, is fitted first and then followed both ways.
constexpr double kPiece = 2;
/// Shorter ones, in widths, are no slots unless they leave the picture at both ends.
constexpr double kLeastLength = 1.5;
constexpr double kLeastCutLength = 0.5;

ExpectedSlot expected_slot(const Target& target, const CameraMapping* mapping) {
  ExpectedSlot expected;
  expected.width = frame_length(target.size, target.size_px, mapping).value_or(0);
  expected.angle_rad = target.angle.in_rad();
  expected.angle_tolerance_rad = std::min(target.angle_tolerance.in_rad(), kSlotHalfTurn / 2);
  expected.size_tolerance = target.size_tolerance;
  expected.is_dark = target.polarity == Polarity::Dark;
  return expected;
}

/// A stretch of a slot: what lies beyond its ends and far aside is not known.
CellModel slot_model(const ExpectedSlot& expected, double from, double to) {
  const double w = expected.width / 2;
  const double far = w + expected.reach();
  CellPattern pattern{{from, to},
                      {-far, -w, w, far},
                      {Cell::Background, Cell::Target, Cell::Background},
                      Cell::Unknown,
                      {},
                      {}};
  return {std::move(pattern), PoseKind::Similarity, Eigen::Vector2d::Zero(), 0.5 * expected.width};
}

struct SlotTrial {
  double angle_rad;
  double scale;
};

std::vector<SlotTrial> slot_trials(const ExpectedSlot& expected) {
  const auto n_steps = [](double range, double step) {
    return std::max(0, static_cast<int>(std::ceil(range / step - 0.5)));
  };
  const int n_angles = n_steps(expected.angle_tolerance_rad, kSlotAngleStep);
  const int n_sizes = n_steps(expected.size_tolerance, kSlotSizeStep);
  std::vector<SlotTrial> trials;
  for (int i = -n_angles; i <= n_angles; ++i) {
    for (int k = -n_sizes; k <= n_sizes; ++k) {
      trials.push_back({expected.angle_rad + i * kSlotAngleStep, std::pow(1 + kSlotSizeStep, k)});
    }
  }
  return trials;
}

std::vector<SlotSighting> see_slots(const DetectorInput& input, const ExpectedSlot& expected) {
  const auto box = input.area.box(input.image, 1.5 * expected.width + 4);
  const int factor = std::max(1, static_cast<int>(std::lround(expected.width / kSlotSearchPx)));
  const ReducedPicture reduced = reduce(input.image, box, factor);
  const Eigen::Vector2d middle(box.x0 + 0.5 * box.width, box.y0 + 0.5 * box.height);
  const Eigen::Matrix2d frame_from_px = FitFrame(input.mapping, middle).jacobian(middle);
  const double half_piece = 0.5 * kPiece * expected.width;
  const CellModel model = slot_model(expected, -half_piece, half_piece);
  // To be drawn, a slot goes on for ever.
  const CellModel endless = slot_model(expected, -1e3 * expected.width, 1e3 * expected.width);
  const std::vector<SlotTrial> trials = slot_trials(expected);
  std::vector<SearchPattern> patterns;
  for (const SlotTrial& trial : trials) {
    patterns.push_back(drawn(endless,
                             placed(Eigen::Vector2d::Zero(), trial.angle_rad, trial.scale),
                             expected.width * trial.scale,
                             frame_from_px,
                             factor));
  }
  PatternSearchOptions options;
  options.min_correlation = kMinSlotCorrelation;
  options.min_gain = 0.5 * input.options.min_contrast * input.image.full_scale();
  options.same_place = 0.3 * expected.width / factor;
  options.max_peaks = kMaxPeaks;
  options.is_inverted = expected.is_dark;
  std::vector<SlotSighting> sightings;
  for (const PatternPeak& peak : search_patterns(reduced, patterns, options)) {
    if (sightings.size() >= kMaxFittedSlow) break;
    const Eigen::Vector2d at = reduced.in_picture(peak.at);
    const bool is_seen =
        std::any_of(sightings.begin(), sightings.end(), [&](const SlotSighting& s) {
          return std::abs(place_on(s, at).y()) < 0.5 * expected.width;
        });
    if (is_seen) continue;
    const SlotTrial& trial = trials[peak.i_pattern];
    const FitFrame fit_frame(input.mapping, at);
    const CellState start = placed(Eigen::Vector2d::Zero(), trial.angle_rad, trial.scale);
    const auto state = rough_fit(reduced, fit_frame, model, start, 0);
    if (state) sightings.push_back({fit_frame, *state});
  }
  return sightings;
}

/// The centre of the searched area, if only a part of the picture is searched.
std::optional<Eigen::Vector2d> wanted_place(const DetectorInput& input) {
  if (!input.options.search_center || !input.options.search_radius) return std::nullopt;
  return input.options.search_center->in_px();
}

Eigen::Vector2d picture_middle(const Image& image) {
  return {0.5 * (image.width() - 1), 0.5 * (image.height() - 1)};
}

/// Slot by a fit, in frame units and radians.
struct MeasuredSlot {
  double width = 0;
  double angle_rad = 0;
  double angle_sigma_rad = 0;
  double along = 0;  ///< the reported place, pattern units
  CellPlace place;
};

MeasuredSlot measured_slot(const DetectorInput& input,
                           const ExpectedSlot& expected,
                           const FitFrame& fit_frame,
                           const CellModel& model,
                           const SlotStretch& stretch,
                           const CellFit& fit) {
  const Eigen::Matrix2d frame_from_pattern =
      fit.state.jacobian(fit.state.to_frame({0, 0})).inverse();
  const double scale = std::sqrt(std::abs(frame_from_pattern.determinant()));
  MeasuredSlot m;
  m.width = scale * expected.width;
  const double angle = std::atan2(frame_from_pattern(1, 0), frame_from_pattern(0, 0));
  m.angle_rad = expected.angle_rad + std::remainder(angle - expected.angle_rad, kSlotHalfTurn);
  m.angle_sigma_rad = std::sqrt(std::max(0.0, fit.cov(2, 2)));
  m.along = 0.5 * (stretch.from + stretch.to);
  if (const auto wanted = wanted_place(input)) {
    const double along = fit.state.to_pattern(fit_frame.from_image(*wanted)).x();
    m.along = std::clamp(along, stretch.from, stretch.to);
  }
  CellFit blind = fit;
  // Uniform over what is seen.
  blind.cov.row(0).setZero();
  blind.cov.col(0).setZero();
  blind.cov(0, 0) = stretch.length() * stretch.length() / 12;
  m.place = place_of(model, blind, {m.along, 0});
  return m;
}

std::vector<std::vector<Eigen::Vector2d>> outlines_of(const FitFrame& fit_frame,
                                                      const ExpectedSlot& expected,
                                                      const CellState& state,
                                                      const SlotStretch& stretch) {
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  for (const double across : {-0.5 * expected.width, 0.5 * expected.width}) {
    std::vector<Eigen::Vector2d> edge;
    for (const double along : {stretch.from, stretch.to}) {
      const auto u = fit_frame.to_image(state.to_frame({along, across}));
      if (u) edge.push_back(*u);
    }
    outlines.push_back(std::move(edge));
  }
  return outlines;
}

std::optional<std::string> unfit_slot_reason(const FitFrame& fit_frame,
                                             const ExpectedSlot& expected,
                                             const MeasuredSlot& m) {
  return size_problem(fit_frame, "its width", m.width, expected.width, expected.size_tolerance);
}

/// Too short to be a slot; empty if it is long enough.
std::optional<std::string> length_problem(const FitFrame& fit_frame,
                                          const ExpectedSlot& expected,
                                          const SlotStretch& stretch) {
  const bool is_through = stretch.is_cut_from && stretch.is_cut_to;
  // The ends that are not straight are part of a slot's length.
  const double ends = (stretch.is_cut_from ? 0 : 0.6) + (stretch.is_cut_to ? 0 : 0.6);
  const double least = ((is_through ? kLeastCutLength : kLeastLength) - ends) * expected.width;
  if (stretch.length() >= std::max(least, 4.0)) return std::nullopt;
  const double unit = fit_frame.unit();
  return fmt::format("it is too short for a slot: {:.3g} {} of its straight edges are seen",
                     std::max(0.0, stretch.length()) * unit,
                     fit_frame.mapping() ? "mm" : "px");
}

FittedCandidate fitted_slot(const DetectorInput& input,
                            const ExpectedSlot& expected,
                            const SlotSighting& sighting,
                            int factor) {
  FittedCandidate candidate;
  const SlotStretch stretch = seen_stretch(
      input.image, sighting, expected, wanted_place(input).value_or(picture_middle(input.image)));
  if (auto reason = length_problem(sighting.fit_frame, expected, stretch)) {
    candidate.reason = *std::move(reason);
    // A pixel either way says that this is no measurement.
    set_place(sighting.fit_frame,
              sighting.state.to_frame({0, 0}),
              Eigen::Matrix2d::Identity(),
              expected.width,
              candidate.fit);
    return candidate;
  }
  const CellModel model = slot_model(expected, stretch.from, stretch.to);
  CellFitOptions options;
  options.reach = 0;
  options.start_error = std::max(1.0, 0.3 * factor);
  options.max_sigma_px = input.options.max_blur_px;
  options.is_blind_along_x = true;
  options.may_be_textured = true;
  const CellFit fit = fit_cells(input.image, sighting.fit_frame, model, sighting.state, options);
  const MeasuredSlot m = measured_slot(input, expected, sighting.fit_frame, model, stretch, fit);
  TargetFit& out = candidate.fit;
  set_place(sighting.fit_frame, m.place.at, m.place.cov, m.width, out);
  set_quality(model, fit, m.place, out);
  out.angle = rad(m.angle_rad);
  out.angle_sigma = rad(m.angle_sigma_rad);
  out.blind_direction = out.angle;
  out.outlines_px = outlines_of(sighting.fit_frame, expected, fit.state, stretch);
  judge_cells(input,
              fit,
              {.border = "edges",
               .unfit = unfit_slot_reason(sighting.fit_frame, expected, m),
               .turn_rad = m.angle_rad - expected.angle_rad,
               .turn_sigma_rad = m.angle_sigma_rad,
               .turn_tolerance_rad = expected.angle_tolerance_rad,
               .max_sigma_px = options.max_sigma_px},
              candidate);
  return candidate;
}

}  // namespace

std::vector<FittedCandidate> detect_slots(const DetectorInput& input) {
  const ExpectedSlot expected = expected_slot(input.target, input.mapping);
  std::vector<FittedCandidate> candidates;
  if (expected.width < kMinWidthPx) return candidates;
  const int factor = std::max(1, static_cast<int>(std::lround(expected.width / kSlotSearchPx)));
  for (const SlotSighting& sighting : see_slots(input, expected)) {
    auto candidate = fitted_slot(input, expected, sighting, factor);
    if (input.area.contains(candidate.fit.center.position.in_px(), 0)) {
      candidates.push_back(std::move(candidate));
    }
  }
  return candidates;
}

}  // namespace panelcal::internal
