// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "vision/fit/frame.h"
#include "vision/polygon/fit.h"
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Verdict = FittedCandidate::Verdict;

/// Greatest error of the quad's corners, as part of a cell, and at least, px.
constexpr double kStartError = 0.12;
constexpr double kLeastStartError = 1.0;
/// A second attempt, if the first one's correlation is less than that.
constexpr double kSureTag = 0.9;
constexpr double kWideStartError = 0.6;
constexpr double kWideBlur = 0.25;
/// Pixels per cell and axis that a rough fit looks at.
constexpr double kRoughPerCell = 4;
/// Edges blurrier than this part of a cell: its middle no longer shows its own level.
constexpr double kMaxBlur = 0.6;
/// More of the edges' pixels at the ends of the scale than this leave too little to fit.
constexpr double kMaxTagClipped = 0.6;

CellPattern cell_pattern(const TagPattern& tag) {
  CellPattern pattern;
  pattern.x = tag.lines;
  pattern.y = tag.lines;
  for (const TagCell cell : tag.levels) {
    pattern.cells.push_back(cell == TagCell::White   ? Cell::Target
                            : cell == TagCell::Black ? Cell::Background
                                                     : Cell::Unknown);
  }
  pattern.outside = Cell::Unknown;
  return pattern;
}

/// State of the tag in the fit frame by the quad.
CellState start_state(const FitFrame& fit_frame, const TagQuad& quad, double cell_px) {
  TagQuad in_frame;
  std::transform(quad.corners_px.begin(),
                 quad.corners_px.end(),
                 in_frame.corners_px.begin(),
                 [&](const Eigen::Vector2d& u) { return fit_frame.from_image(u); });
  CellState state;
  state.pattern_from_frame = in_frame.image_from_tag().inverse();
  state.pattern_from_frame /= state.pattern_from_frame(2, 2);
  state.sigma_px = std::clamp(0.15 * cell_px, 0.6, 1.5);
  return state;
}

/// First few of the pixels, quickly, then all of them.
CellFit fit_from(const Image& image,
                 const FitFrame& fit_frame,
                 const CellModel& model,
                 const CellState& start,
                 double start_error,
                 double cell_px) {
  CellFitOptions options{.reach = 0,
                         .start_error = std::max(kLeastStartError, start_error),
                         .max_sigma_px = std::max(1.5, cell_px),
                         .is_rough = true,
                         .stride = std::clamp(static_cast<int>(cell_px / kRoughPerCell), 1, 8)};
  const CellFit rough = fit_cells(image, fit_frame, model, start, options);
  if (!rough.converged) return rough;
  // Strides of few pixels are precise enough for that.
  options.start_error = kLeastStartError;
  options.is_rough = false;
  options.is_refined = true;
  options.stride = 1;
  return fit_cells(image, fit_frame, model, rough.state, options);
}

CellFit fit_pattern(const Image& image,
                    const FitFrame& fit_frame,
                    const CellModel& model,
                    const CellState& start,
                    double cell_px) {
  CellFit near = fit_from(image, fit_frame, model, start, kStartError * cell_px, cell_px);
  if (near.converged && near.correlation > kSureTag) return near;
  // Something on the frame's rim has pulled one of the quad's corners away. A blurred model is
  // drawn to the right place from farther off.
  CellState blurred = start;
  blurred.sigma_px = std::max(start.sigma_px, kWideBlur * cell_px);
  CellFit wide = fit_from(image, fit_frame, model, blurred, kWideStartError * cell_px, cell_px);
  return wide.converged && !(near.converged && near.correlation > wide.correlation) ? wide : near;
}

PositionEstimate<frame::Image> in_image(const FitFrame& fit_frame, const CellPlace& place) {
  const Eigen::Vector2d u = fit_frame.to_image(place.at).value_or(Eigen::Vector2d::Zero());
  const Eigen::Matrix2d px_from_frame = fit_frame.jacobian(u).inverse();
  return {position_px<frame::Image>(u), propagate(px_from_frame, place.cov)};
}

/// The direction of the tag's x in the fit frame, at its middle.
double tag_angle(const CellState& state) {
  const Eigen::Matrix2d frame_from_tag = state.jacobian(state.to_frame({0, 0})).inverse();
  return std::atan2(frame_from_tag(1, 0), frame_from_tag(0, 0));
}

double angle_sigma(const CellModel& model, const CellFit& fit) {
  constexpr double kStep = 1e-6;
  CellVector gradient = CellVector::Zero();
  for (int k = 0; k < model.n_pose(); ++k) {
    CellVector step = CellVector::Zero();
    step[k] = kStep;
    const double high = tag_angle(model.moved(fit.state, step));
    const double low = tag_angle(model.moved(fit.state, -step));
    gradient[k] = std::remainder(high - low, 2 * std::numbers::pi) / (2 * kStep);
  }
  return std::sqrt(gradient.dot(fit.cov * gradient));
}

double mean_side(const std::array<Eigen::Vector2d, 4>& corners) {
  return TagQuad{corners}.mean_side_px();
}

/// The corners' square; a lens bends its sides.
std::vector<Eigen::Vector2d> outline(const FitFrame& fit_frame, const CellState& state) {
  constexpr int kPieces = 8;
  const int n = fit_frame.mapping() ? kPieces : 1;
  const auto corners = tag_corners();
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < 4; ++i) {
    for (int k = 0; k < n; ++k) {
      const double part = static_cast<double>(k) / n;
      const Eigen::Vector2d v = (1 - part) * corners[i] + part * corners[(i + 1) % 4];
      if (const auto u = fit_frame.to_image(state.to_frame(v))) points.push_back(*u);
    }
  }
  if (!points.empty()) points.push_back(points.front());
  return points;
}

/// Mean side of a tag in the fit frame.
double side_in_frame(const CellState& state) {
  auto corners = tag_corners();
  for (Eigen::Vector2d& c : corners) c = state.to_frame(c);
  return mean_side(corners);
}

void fill_tag(const FitFrame& fit_frame, const CellModel& model, const CellFit& f, TargetFit& fit) {
  const CellPlace middle = place_of(model, f, Eigen::Vector2d::Zero());
  fit.center = in_image(fit_frame, middle);
  std::array<Eigen::Vector2d, 4> corners_px;
  for (std::size_t i = 0; i < 4; ++i) {
    fit.corners.push_back(in_image(fit_frame, place_of(model, f, tag_corners()[i])));
    corners_px[i] = fit.corners.back().position.in_px();
  }
  fit.size = px(mean_side(corners_px));
  fit.angle = rad(tag_angle(f.state));
  if (fit_frame.mapping()) {
    const double unit_mm = fit_frame.unit();
    fit.center_optical = PositionEstimate<frame::Optical>{fit_frame.to_optical(middle.at),
                                                          unit_mm * unit_mm * middle.cov};
    fit.size_mm = mm(side_in_frame(f.state) * unit_mm);
  }
  fit.blur_px = f.state.sigma_px;
  fit.background = f.state.levels[0];
  fit.contrast = f.state.levels[3];
  fit.noise = f.rim_noise;
  fit.excluded = f.excluded;
  // Edges too short to be looked at one by one tell nothing either way.
  fit.visible = f.outside_picture < 1 ? std::min(1.0, f.visible / (1 - f.outside_picture)) : 1;
  fit.outlines_px = {outline(fit_frame, f.state)};
}

/// Only where the tag is, as the quad says it: a pixel either way says that this is no measurement.
void fill_roughly(const FitFrame& fit_frame,
                  const CellState& start,
                  const TagQuad& quad,
                  const TagReading& reading,
                  TargetFit& fit) {
  const CellPlace middle{start.to_frame({0, 0}), Eigen::Matrix2d::Identity()};
  fit.center = in_image(fit_frame, middle);
  for (const Eigen::Vector2d& u : quad.corners_px) {
    fit.corners.push_back({position_px<frame::Image>(u), Eigen::Matrix2d::Identity()});
  }
  fit.size = px(quad.mean_side_px());
  fit.angle = rad(tag_angle(start));
  if (fit_frame.mapping()) {
    const double unit_mm = fit_frame.unit();
    fit.center_optical = PositionEstimate<frame::Optical>{fit_frame.to_optical(middle.at),
                                                          unit_mm * unit_mm * middle.cov};
    fit.size_mm = mm(side_in_frame(start) * unit_mm);
  }
  fit.contrast = reading.contrast;
  fit.outlines_px = {outline(fit_frame, start)};
}

/// True if a part of the frame or of the bits is outside; the quiet zone may be.
bool leaves_picture(const Image& image,
                    const FitFrame& fit_frame,
                    const TagFamily& family,
                    const CellState& state) {
  const TagPattern blank = family.blank();
  const auto is_inside = [&](int column, int row) {
    const Eigen::Vector2d v(blank.lines[static_cast<std::size_t>(column)],
                            blank.lines[static_cast<std::size_t>(row)]);
    const auto u = fit_frame.to_image(state.to_frame(v));
    return u && u->x() >= -0.5 && u->y() >= -0.5 && u->x() <= image.width() - 0.5 &&
           u->y() <= image.height() - 0.5;
  };
  const auto cell_leaves = [&](int column, int row) {
    return !is_inside(column, row) || !is_inside(column + 1, row) || !is_inside(column, row + 1) ||
           !is_inside(column + 1, row + 1);
  };
  const auto bit_leaves = [&](const TagFamily::Bit& bit) {
    return cell_leaves(bit.column, bit.row);
  };
  const int first = (family.n_cells - family.n_on_side) / 2;
  const int last = first + family.n_on_side - 1;
  return cell_leaves(first, first) || cell_leaves(last, first) || cell_leaves(first, last) ||
         cell_leaves(last, last) || std::any_of(family.bits.begin(), family.bits.end(), bit_leaves);
}

std::optional<std::string> tag_size_problem(const DetectorInput& input,
                                            const FitFrame& fit_frame,
                                            double side) {
  const Target& target = input.target;
  const auto asked = frame_length(target.size, target.size_px, input.mapping);
  if (!asked) return std::nullopt;
  const double deviation = side / *asked - 1;
  if (std::abs(deviation) <= target.size_tolerance) return std::nullopt;
  return fmt::format("its size is {:.4g} {}, {:+.1f} % from {:.4g}; {:.1f} % are allowed",
                     side * fit_frame.unit(),
                     fit_frame.mapping() ? "mm" : "px",
                     100 * deviation,
                     *asked * fit_frame.unit(),
                     100 * target.size_tolerance);
}

/// The fitted tag read again: its id must not hang on where the search put the corners.
bool reads_the_same(const DetectorInput& input,
                    const TagFamily& family,
                    const TargetFit& fit,
                    const TagReading& reading) {
  TagQuad quad;
  for (std::size_t i = 0; i < 4; ++i) quad.corners_px[i] = fit.corners[i].position.in_px();
  const auto again = read_tag(input.image, family, quad, reading.contrast < 0, input.target.tag_id);
  return again && again->id == reading.id && again->quarters == 0;
}

std::optional<std::string> unlikely_reason(const DetectorInput& input,
                                           const TagFamily& family,
                                           const TagReading& reading,
                                           const TargetFit& fit) {
  const double min_contrast = input.options.min_contrast * input.image.full_scale();
  if (std::abs(fit.contrast) < min_contrast) {
    return fmt::format("its contrast is {:.1f} grey levels, at least {:.1f} are asked for",
                       std::abs(fit.contrast),
                       min_contrast);
  }
  if ((fit.contrast < 0) != (reading.contrast < 0) ||
      !reads_the_same(input, family, fit, reading)) {
    return "it does not look like the target";
  }
  if (fit.score < input.options.min_score) {
    return fmt::format(
        "its score is {:.2f}, at least {:.2f} is asked for", fit.score, input.options.min_score);
  }
  return std::nullopt;
}

std::optional<std::string> unfit_tag_reason(const DetectorInput& input,
                                            const FitFrame& fit_frame,
                                            const TagFamily& family,
                                            const CellFit& f,
                                            const TargetFit& fit) {
  if (leaves_picture(input.image, fit_frame, family, f.state)) {
    return "at the border: a part of it is outside of the picture";
  }
  if (f.clipped > kMaxTagClipped) {
    return fmt::format(
        "saturated: {:.0f} % of its edges' pixels are black or white; at most {:.0f} % "
        "are allowed",
        100 * f.clipped,
        100 * kMaxTagClipped);
  }
  const double cell_px = fit.size.in_px() / family.n_on_side;
  if (fit.blur_px > kMaxBlur * cell_px) {
    return fmt::format(
        "out of focus: its edges are blurred by {:.1f} px, at most {:.1f} are allowed",
        fit.blur_px,
        kMaxBlur * cell_px);
  }
  return tag_size_problem(input, fit_frame, side_in_frame(f.state));
}

}  // namespace

FittedCandidate fit_tag(const DetectorInput& input,
                        const TagFamily& family,
                        const TagSighting& sighting) {
  const auto& [quad, reading] = sighting;
  const Eigen::Vector2d center_px =
      (quad.image_from_tag() * Eigen::Vector3d::UnitZ()).hnormalized();
  const FitFrame fit_frame(input.mapping, center_px);
  const double cell_px = quad.mean_side_px() / family.n_on_side;
  const CellState start = start_state(fit_frame, quad, cell_px);

  FittedCandidate candidate;
  TargetFit& fit = candidate.fit;
  fit.tag_id = reading.id;
  const int n_seen = static_cast<int>(family.bits.size()) - reading.unseen_bits;
  fit.score = 1 - static_cast<double>(reading.wrong_bits) / n_seen;
  if (input.target.tag_id.value_or(reading.id) != reading.id) {
    fill_roughly(fit_frame, start, quad, reading, fit);
    candidate.verdict = Verdict::Unfit;
    candidate.reason =
        fmt::format("it is tag {}, {} is asked for", reading.id, *input.target.tag_id);
    return candidate;
  }
  const CellModel model(cell_pattern(family.pattern(reading.id)),
                        PoseKind::Homography,
                        Eigen::Vector2d::Zero(),
                        side_in_frame(start));
  const CellFit f = fit_pattern(input.image, fit_frame, model, start, cell_px);
  if (!f.converged) {
    fill_roughly(fit_frame, start, quad, reading, fit);
    fit.score = 0;
    candidate.reason = "it does not look like the target";
    return candidate;
  }
  fill_tag(fit_frame, model, f, fit);
  fit.angle_sigma = rad(angle_sigma(model, f));
  // Wrong bits are debris, which the correlation leaves out: decoded() has judged them.
  fit.score = f.correlation * fit.visible;
  if (auto reason = unlikely_reason(input, family, reading, fit)) {
    candidate.reason = *std::move(reason);
  } else if (auto unfit = unfit_tag_reason(input, fit_frame, family, f, fit)) {
    candidate.verdict = Verdict::Unfit;
    candidate.reason = *std::move(unfit);
  } else {
    candidate.verdict = Verdict::Good;
  }
  return candidate;
}

}  // namespace panelcal::internal
