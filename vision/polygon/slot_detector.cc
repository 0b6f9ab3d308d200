// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/fit/pipeline.h"
#include "vision/fit/place.h"
#include "vision/polygon/fit.h"
#include "vision/polygon/slot_follower.h"
#include "vision/polygon/target.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr double kSlotHalfTurn = std::numbers::pi;
constexpr std::size_t kMaxPeaks = 64;  // a slot has a ridge of them
constexpr double kMinWidthPx = 3;
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

/// The centre of the searched area, if only a part of the picture is searched.
std::optional<Eigen::Vector2d> wanted_place(const DetectorInput& input) {
  if (!input.options.search_center || !input.options.search_radius) return std::nullopt;
  return input.options.search_center->in_px();
}

Eigen::Vector2d picture_middle(const Image& image) {
  return {0.5 * (image.width() - 1), 0.5 * (image.height() - 1)};
}

/// Too short to be a slot; empty if it is long enough.
Problem length_problem(const FitFrame& fit_frame,
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

/// Two parallel edges.
class Slots {
 public:
  using Sighting = SlotSighting;
  struct Fit {
    FitFrame fit_frame;
    TargetFit target;
    Problem too_short;  ///< of what is not fitted
    CellFit cells = {};
    double width = 0;  ///< frame units
  };

  explicit Slots(const DetectorInput& input)
      : input_(input),
        expected_(expected_slot(input.target, input.mapping)),
        search_{.size = expected_.width,
                .seen_px = 8,
                .reach_px = 1.5 * expected_.width + 4,
                .half_of_size = [](double) { return 1.0; },
                .angle_rad = expected_.angle_rad,
                .angle_tolerance_rad = expected_.angle_tolerance_rad,
                .max_peaks = kMaxPeaks} {
    options_.reach = 0;
    options_.start_error = std::max(1.0, 0.3 * search_.factor());
    options_.max_sigma_px = input.options.max_blur_px;
    options_.is_blind_along_x = true;
    options_.may_be_textured = true;
  }

  Proposals<Sighting> propose() const {
    const double width = expected_.width;
    if (width < kMinWidthPx) return {};
    const CellModel piece = slot_model(expected_, -0.5 * kPiece * width, 0.5 * kPiece * width);
    // To be drawn, a slot goes on for ever.
    const CellSightings seen =
        search_cells(input_, search_, slot_model(expected_, -1e3 * width, 1e3 * width));
    std::vector<Sighting> sightings;
    for (const CellSightings::Peak& peak : seen.peaks) {
      if (sightings.size() >= kMaxFittedSlow) break;
      const bool is_seen = std::ranges::any_of(sightings, [&](const Sighting& s) {
        return std::abs(place_on(s, peak.at_px).y()) < 0.5 * width;
      });
      if (is_seen) continue;
      const FitFrame fit_frame(input_.mapping, peak.at_px);
      const auto state = rough_fit(seen.reduced, fit_frame, piece, peak.state, 0);
      if (state) sightings.push_back({fit_frame, *state});
    }
    return {std::move(sightings)};
  }

  Fit fit(const Sighting& sighting) const {
    const FitFrame& fit_frame = sighting.fit_frame;
    Fit fit{fit_frame, {}, {}};
    const SlotStretch stretch =
        seen_stretch(input_.image,
                     sighting,
                     expected_,
                     wanted_place(input_).value_or(picture_middle(input_.image)));
    fit.too_short = length_problem(fit_frame, expected_, stretch);
    if (fit.too_short) {
      // A pixel either way says that this is no measurement.
      set_place(fit_frame,
                sighting.state.to_frame({0, 0}),
                Eigen::Matrix2d::Identity(),
                expected_.width,
                fit.target);
      return fit;
    }
    const CellModel model = slot_model(expected_, stretch.from, stretch.to);
    fit.cells = fit_cells(input_.image, fit_frame, model, sighting.state, options_);
    const CellState& state = fit.cells.state;
    const auto [scale, angle_rad] = pose_of(state);
    fit.width = scale * expected_.width;
    const double turn_rad = std::remainder(angle_rad - expected_.angle_rad, kSlotHalfTurn);
    fill_target(fit_frame,
                model,
                fit.cells,
                reported_place(fit_frame, model, stretch, fit.cells),
                fit.width,
                expected_.angle_rad + turn_rad,
                fit.target);
    fit.target.blind_direction = fit.target.angle;
    for (const double across : {-0.5 * expected_.width, 0.5 * expected_.width}) {
      fit.target.outlines_px.push_back(in_picture(
          fit_frame,
          {state.to_frame({stretch.from, across}), state.to_frame({stretch.to, across})}));
    }
    return fit;
  }

  Judgement judge(const Fit& fit) const {
    if (fit.too_short) return unlikely(*fit.too_short);
    return judge_cells(
        input_,
        fit.cells,
        fit.target,
        {.border = "edges",
         .unfit = size_problem(
             fit.fit_frame, "its width", fit.width, expected_.width, input_.target.size_tolerance),
         .turn_rad = fit.target.angle.in_rad() - expected_.angle_rad,
         .turn_tolerance_rad = expected_.angle_tolerance_rad,
         .max_sigma_px = options_.max_sigma_px});
  }

 private:
  /// In the middle of what is seen, or nearest to where it is wanted; along the slot its covariance
  /// is that of an even distribution over what is seen.
  CellPlace reported_place(const FitFrame& fit_frame,
                           const CellModel& model,
                           const SlotStretch& stretch,
                           const CellFit& seen) const {
    double along = 0.5 * (stretch.from + stretch.to);
    if (const auto wanted = wanted_place(input_)) {
      along = std::clamp(
          seen.state.to_pattern(fit_frame.from_image(*wanted)).x(), stretch.from, stretch.to);
    }
    CellFit fit;
    fit.state = seen.state;
    fit.cov = seen.cov;
    fit.cov.row(0).setZero();
    fit.cov.col(0).setZero();
    fit.cov(0, 0) = stretch.length() * stretch.length() / 12;
    return place_of(model, fit, {along, 0});
  }

  const DetectorInput& input_;
  ExpectedSlot expected_;
  CellSearch search_;
  CellFitOptions options_;
};

}  // namespace

std::vector<FittedCandidate> detect_slots(const DetectorInput& input) {
  return detect(input, Slots(input));
}

}  // namespace panelcal::internal
