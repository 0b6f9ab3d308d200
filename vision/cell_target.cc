// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/cell_target.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <fmt/format.h>

#include "panelcal/vision/cell_solver.h"
#include "panelcal/vision/edge_profile.h"

namespace panelcal::internal {

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

void set_place(const FitFrame& fit_frame, const CellPlace& place, double size, TargetFit& fit) {
  const Eigen::Vector2d u = fit_frame.to_image(place.at).value_or(Eigen::Vector2d::Zero());
  const Eigen::Matrix2d px_from_frame = fit_frame.jacobian(u).inverse();
  fit.center = {position_px<frame::Image>(u), propagate(px_from_frame, place.cov)};
  fit.size = px(size * std::sqrt(std::abs(px_from_frame.determinant())));
  if (!fit_frame.mapping()) return;
  const double unit_mm = fit_frame.unit();
  fit.center_optical = PositionEstimate<frame::Optical>{fit_frame.to_optical(place.at),
                                                        unit_mm * unit_mm * place.cov};
  fit.size_mm = mm(size * unit_mm);
}

void set_quality(const CellModel& model,
                 const CellFit& cell_fit,
                 const CellPlace& place,
                 TargetFit& fit) {
  fit.score = cell_fit.correlation * cell_fit.visible;
  fit.blur_px = cell_fit.state.sigma_px;
  const Eigen::Vector3d terms = model.plane_terms(place.at);
  fit.background = terms.dot(cell_fit.state.levels.head<3>());
  fit.contrast = terms.dot(cell_fit.state.levels.tail<3>());
  fit.noise = cell_fit.rim_noise;
  fit.excluded = cell_fit.excluded;
  fit.visible = cell_fit.visible;
}

std::optional<std::string> size_problem(
    const FitFrame& fit_frame, std::string_view what, double seen, double asked, double tolerance) {
  const double deviation = seen / asked - 1;
  if (std::abs(deviation) <= tolerance) return std::nullopt;
  const double unit = fit_frame.unit();
  return fmt::format("{} is {:.4g} {}, {:+.1f} % from {:.4g}; {:.1f} % are allowed",
                     what,
                     seen * unit,
                     fit_frame.mapping() ? "mm" : "px",
                     100 * deviation,
                     asked * unit,
                     100 * tolerance);
}

}  // namespace panelcal::internal
