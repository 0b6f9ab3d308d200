// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/target.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vision/fit/edge_profile.h"
#include "vision/fit/place.h"
#include "vision/polygon/solver.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// A turn that moves the corners of the reduced target by about one of its pixels.
constexpr double kAngleStep = 0.2;
/// Sizes this much apart, relative, look alike to the search.
constexpr double kSizeStep = 0.12;
constexpr double kSamePlace = 0.3;  // of the size: nearer peaks are one

/// A model as a reduced picture shows it: its share.
///
/// In     half: half of the side of what is drawn, frame units; frame_from_px: jacobian of the fit
///        frame, which is taken as the same everywhere
SearchPattern drawn(const CellModel& model,
                    const CellState& state,
                    double half,
                    const Eigen::Matrix2d& frame_from_px,
                    int factor) {
  constexpr double kLensPx = 1.2;  // an ordinary one
  CellState seen = state;
  seen.sigma_px = std::sqrt(std::pow(kLensPx / factor, 2) + kPixelVariance);
  seen.levels << 0, 0, 0, 1, 0, 0;
  const double half_px = half / std::sqrt(std::abs(frame_from_px.determinant()));
  const int radius = std::max(3, static_cast<int>(std::ceil(half_px / factor)));
  SearchPattern pattern{Image(2 * radius + 1, 2 * radius + 1, 1)};
  CellView view(model, seen);
  CellPixel pixel;
  pixel.jacobian = factor * frame_from_px;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      pixel.at = pixel.jacobian * Eigen::Vector2d(x, y);
      pattern.picture.at(x + radius, y + radius) =
          static_cast<float>(view.evaluate(pixel, nullptr).share);
    }
  }
  return pattern;
}

/// The poses that the search tries.
std::vector<CellPose> trials(const CellSearch& search, double size_tolerance) {
  const auto n_steps = [](double range, double step) {
    return std::max(0, static_cast<int>(std::ceil(range / step - 0.5)));
  };
  const int n_angles = n_steps(search.angle_tolerance_rad, kAngleStep);
  const int n_sizes = n_steps(size_tolerance, kSizeStep);
  std::vector<CellPose> trials;
  for (int i = -n_angles; i <= n_angles; ++i) {
    for (int k = -n_sizes; k <= n_sizes; ++k) {
      trials.push_back({std::pow(1 + kSizeStep, k), search.angle_rad + i * kAngleStep});
    }
  }
  return trials;
}

}  // namespace

int CellSearch::factor() const {
  return std::max(1, static_cast<int>(std::lround(size / seen_px)));
}

CellSightings search_cells(const DetectorInput& input,
                           const CellSearch& search,
                           const CellModel& model) {
  const int factor = search.factor();
  const PixelBox box = input.area.box(input.image, search.reach_px);
  CellSightings seen{reduce(input.image, box, factor), {}};
  const Eigen::Vector2d middle(box.x0 + 0.5 * box.width, box.y0 + 0.5 * box.height);
  const Eigen::Matrix2d frame_from_px = FitFrame(input.mapping, middle).jacobian(middle);
  const std::vector<CellPose> poses = trials(search, input.target.size_tolerance);
  const auto state_of = [](const CellPose& pose) {
    return placed(Eigen::Vector2d::Zero(), pose.angle_rad, pose.scale);
  };
  std::vector<SearchPattern> patterns;
  for (const CellPose& pose : poses) {
    const double half = search.half_of_size(pose.angle_rad) * search.size * pose.scale;
    patterns.push_back(drawn(model, state_of(pose), half, frame_from_px, factor));
  }
  PatternSearchOptions options;
  options.min_gain = 0.5 * input.min_contrast();
  options.same_place = kSamePlace * search.size / factor;
  options.max_peaks = search.max_peaks;
  options.is_inverted = input.target.polarity == Polarity::Dark;
  for (const PatternPeak& peak : search_patterns(seen.reduced, patterns, options)) {
    seen.peaks.push_back({seen.reduced.in_picture(peak.at), state_of(poses[peak.i_pattern])});
  }
  return seen;
}

std::optional<CellState> rough_fit(const ReducedPicture& reduced,
                                   const FitFrame& fit_frame,
                                   const CellModel& model,
                                   const CellState& start,
                                   double reach) {
  const double k = reduced.factor;
  CellState first = start;
  first.sigma_px = std::sqrt(1.5 / (k * k) + kPixelVariance);
  CellFitOptions options;
  options.reach = reach;
  options.start_error = 1.5 * k;
  options.max_sigma_px = std::max(1.5, 0.2 * half_extent(model.pattern()) / k);
  options.reduction = reduced.factor;
  options.image_x0 = reduced.x0;
  options.image_y0 = reduced.y0;
  options.is_rough = true;
  const CellFit fit = fit_cells(reduced.image, fit_frame, model, first, options);
  if (!fit.converged) return std::nullopt;
  CellState state = fit.state;
  const double lens2 = std::max(0.3, (state.sigma_px * state.sigma_px - kPixelVariance) * k * k);
  state.sigma_px = std::clamp(std::sqrt(lens2 + kPixelVariance), 0.6, 3.0);
  return state;
}

void fill_target(const FitFrame& fit_frame,
                 const CellModel& model,
                 const CellFit& cell_fit,
                 const CellPlace& place,
                 double size,
                 double angle_rad,
                 TargetFit& fit) {
  set_place(fit_frame, place.at, place.cov, size, fit);
  fit.angle = rad(angle_rad);
  fit.angle_sigma = rad(std::sqrt(std::max(0.0, cell_fit.cov(2, 2))));
  fit.score = cell_fit.correlation * cell_fit.visible;
  fit.blur_px = cell_fit.state.sigma_px;
  const Eigen::Vector3d terms = model.plane_terms(place.at);
  fit.background = terms.dot(cell_fit.state.levels.head<3>());
  fit.contrast = terms.dot(cell_fit.state.levels.tail<3>());
  fit.noise = cell_fit.rim_noise;
  fit.excluded = cell_fit.excluded;
  fit.visible = cell_fit.visible;
}

namespace {

/// A target with less of its face is a pad with a hole, or half a pad.
constexpr double kLeastIntact = 0.8;
/// With more of the pixels near its lines left out the rest fits anything.
constexpr double kMostExcluded = 0.5;
/// Residuals near the lines beyond the ground's, of the contrast: a ring in a square's place leaves
/// 0.4, and a square under debris, which is left out, next to nothing.
constexpr double kMostUnexplained = 0.3;
/// More of the outline than this has to be visible for a target to count as partly hidden.
constexpr double kLeastVisible = 0.35;
/// A square has four sides: with one that is hardly there it is the end of a bar, or a corner of
/// something larger.
constexpr double kLeastSide = 0.45;
/// A pad stands out from its ground by the same all around. What photographs show by chance where a
/// square of 24 px is looked for (opencv-doc's 601) has 0.1 to 0.6, squares of a chessboard 0.8.
constexpr double kLeastEvenness = 0.65;
constexpr double kMostClipped = 0.75;

Problem unfit_cells(const CellFit& f, const TargetFit& fit, const CellJudgement& j) {
  if (j.unfit) return j.unfit;
  if (auto problem = turn_problem(j.turn_rad, fit.angle_sigma.in_rad(), j.turn_tolerance_rad)) {
    return problem;
  }
  if (f.weakest_side < kLeastSide) {
    return fmt::format(
        "only {:.0f} % of one of its sides are visible, at least {:.0f} % are needed",
        100 * f.weakest_side,
        100 * kLeastSide);
  }
  if (f.evenness < kLeastEvenness) {
    return fmt::format(
        "one of its sides has {:.0f} % of another's contrast, at least {:.0f} % is "
        "needed",
        100 * std::max(0.0, f.evenness),
        100 * kLeastEvenness);
  }
  if (f.state.sigma_px > 0.98 * j.max_sigma_px) {
    return fmt::format(
        "out of focus: its edges are blurred by {:.1f} px, at most {:.1f} are allowed "
        "(max_blur_px)",
        f.state.sigma_px,
        j.max_sigma_px);
  }
  if (f.rim_noise > std::hypot(f.noise_outside, kMostUnexplained * f.state.levels[3])) {
    return fmt::format(
        "its {} does not fit: {:.1f} grey levels are left unexplained there, the "
        "ground has {:.1f}",
        j.border,
        f.rim_noise,
        f.noise_outside);
  }
  if (f.clipped > kMostClipped) {
    return fmt::format("saturated: {:.0f} % of the pixels at its {} are black or white",
                       100 * f.clipped,
                       j.border);
  }
  return std::nullopt;
}

}  // namespace

Judgement judge_cells(const DetectorInput& input,
                      const CellFit& f,
                      const TargetFit& fit,
                      const CellJudgement& judgement) {
  if (!f.converged || !fit.center.cov.allFinite()) return unlikely(kUnlikeTarget);
  if (auto problem = contrast_problem(input.sign() * fit.contrast, input.min_contrast())) {
    return unlikely(*std::move(problem));
  }
  if (f.intact < kLeastIntact) {
    return unlikely(fmt::format("only {:.0f} % of its face look like it", 100 * f.intact));
  }
  if (f.excluded > kMostExcluded) {
    return unlikely(fmt::format(
        "{:.0f} % of what is near its {} do not look like it", 100 * f.excluded, judgement.border));
  }
  if (auto problem = score_problem(fit.score, input.options.min_score)) {
    if (f.correlation < input.options.min_score || f.visible < kLeastVisible) {
      return unlikely(*std::move(problem));
    }
    return unfit(
        fmt::format("only {:.0f} % of its {} are visible", 100 * f.visible, judgement.border));
  }
  if (auto problem = unfit_cells(f, fit, judgement)) return unfit(*std::move(problem));
  return {};
}

}  // namespace panelcal::internal
