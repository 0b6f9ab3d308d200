// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "vision/fit/frame.h"
#include "vision/fit/place.h"
#include "vision/polygon/fit.h"
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

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

double angle_sigma(const CellModel& model, const CellFit& fit) {
  constexpr double kStep = 1e-6;
  CellVector gradient = CellVector::Zero();
  for (int k = 0; k < model.n_pose(); ++k) {
    CellVector step = CellVector::Zero();
    step[k] = kStep;
    const double high = pose_of(model.moved(fit.state, step)).angle_rad;
    const double low = pose_of(model.moved(fit.state, -step)).angle_rad;
    gradient[k] = std::remainder(high - low, 2 * std::numbers::pi) / (2 * kStep);
  }
  return std::sqrt(gradient.dot(fit.cov * gradient));
}

/// The corners' square; a lens bends its sides.
std::vector<Eigen::Vector2d> tag_outline(const FitFrame& fit_frame, const CellState& state) {
  constexpr int kPieces = 8;
  const int n = fit_frame.mapping() ? kPieces : 1;
  const auto corners = tag_corners();
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t i = 0; i < 4; ++i) {
    for (int k = 0; k < n; ++k) {
      const double part = static_cast<double>(k) / n;
      outline.push_back(state.to_frame((1 - part) * corners[i] + part * corners[(i + 1) % 4]));
    }
  }
  outline.push_back(outline.front());
  return in_picture(fit_frame, outline);
}

TagQuad quad_of(const TargetFit& fit) {
  TagQuad quad;
  for (std::size_t i = 0; i < 4; ++i) quad.corners_px[i] = fit.corners[i].position.in_px();
  return quad;
}

/// Mean side of a tag in the fit frame.
double side_in_frame(const CellState& state) {
  auto corners = tag_corners();
  for (Eigen::Vector2d& c : corners) c = state.to_frame(c);
  return TagQuad{corners}.mean_side_px();
}

/// Precondition: fit.corners are filled.
void fill_tag_place(const FitFrame& fit_frame,
                    const CellState& state,
                    const CellPlace& middle,
                    TargetFit& fit) {
  set_place(fit_frame, middle.at, middle.cov, side_in_frame(state), fit);
  fit.size = px(quad_of(fit).mean_side_px());
  fit.angle = rad(pose_of(state).angle_rad);
  fit.outlines_px = {tag_outline(fit_frame, state)};
}

void fill_tag(const FitFrame& fit_frame, const CellModel& model, const CellFit& f, TargetFit& fit) {
  for (const Eigen::Vector2d& corner : tag_corners()) {
    const CellPlace place = place_of(model, f, corner);
    fit.corners.push_back(in_image(fit_frame, place.at, place.cov));
  }
  fill_tag_place(fit_frame, f.state, place_of(model, f, Eigen::Vector2d::Zero()), fit);
  fit.angle_sigma = rad(angle_sigma(model, f));
  fit.blur_px = f.state.sigma_px;
  fit.background = f.state.levels[0];
  fit.contrast = f.state.levels[3];
  fit.noise = f.rim_noise;
  fit.excluded = f.excluded;
  // Edges too short to be looked at one by one tell nothing either way.
  fit.visible = f.outside_picture < 1 ? std::min(1.0, f.visible / (1 - f.outside_picture)) : 1;
  // Wrong bits are debris, which the correlation leaves out: decoded() has judged them.
  fit.score = f.correlation * fit.visible;
}

/// Only where the tag is, as the quad says it: a pixel either way says that this is no measurement.
void fill_roughly(const FitFrame& fit_frame,
                  const CellState& start,
                  const TagSighting& sighting,
                  TargetFit& fit) {
  for (const Eigen::Vector2d& u : sighting.quad.corners_px) {
    fit.corners.push_back({position_px<frame::Image>(u), Eigen::Matrix2d::Identity()});
  }
  fill_tag_place(fit_frame, start, {start.to_frame({0, 0}), Eigen::Matrix2d::Identity()}, fit);
  fit.contrast = sighting.reading.contrast;
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

/// The fitted tag read again: its id must not hang on where the search put the corners.
bool reads_the_same(const DetectorInput& input, const TagFamily& family, const TagFit& fit) {
  const TagReading& reading = fit.reading;
  const auto again =
      read_tag(input.image, family, quad_of(fit.target), reading.contrast < 0, input.target.tag_id);
  return again && again->id == reading.id && again->quarters == 0;
}

Problem unfit_tag(const DetectorInput& input, const TagFamily& family, const TagFit& fit) {
  if (leaves_picture(input.image, fit.fit_frame, family, fit.cells.state)) {
    return "at the border: a part of it is outside of the picture";
  }
  if (fit.cells.clipped > kMaxTagClipped) {
    return fmt::format(
        "saturated: {:.0f} % of its edges' pixels are black or white; at most {:.0f} % "
        "are allowed",
        100 * fit.cells.clipped,
        100 * kMaxTagClipped);
  }
  const double cell_px = fit.target.size.in_px() / family.n_on_side;
  if (fit.target.blur_px > kMaxBlur * cell_px) {
    return fmt::format(
        "out of focus: its edges are blurred by {:.1f} px, at most {:.1f} are allowed",
        fit.target.blur_px,
        kMaxBlur * cell_px);
  }
  const auto asked = frame_length(input.target.size, input.target.size_px, input.mapping);
  if (!asked) return std::nullopt;
  return size_problem(fit.fit_frame,
                      "its size",
                      side_in_frame(fit.cells.state),
                      *asked,
                      input.target.size_tolerance);
}

}  // namespace

TagFit fit_tag(const DetectorInput& input, const TagFamily& family, const TagSighting& sighting) {
  const auto& [quad, reading] = sighting;
  const Eigen::Vector2d center_px =
      (quad.image_from_tag() * Eigen::Vector3d::UnitZ()).hnormalized();
  TagFit fit{FitFrame(input.mapping, center_px), reading, {}, {}};
  const double cell_px = quad.mean_side_px() / family.n_on_side;
  const CellState start = start_state(fit.fit_frame, quad, cell_px);
  const CellModel model(cell_pattern(family.pattern(reading.id)),
                        PoseKind::Homography,
                        Eigen::Vector2d::Zero(),
                        side_in_frame(start));
  if (is_wanted(input, reading)) {
    fit.cells = fit_pattern(input.image, fit.fit_frame, model, start, cell_px);
  } else {
    const int n_seen = static_cast<int>(family.bits.size()) - reading.unseen_bits;
    fit.target.score = 1 - static_cast<double>(reading.wrong_bits) / n_seen;
  }
  fit.target.tag_id = reading.id;
  if (fit.cells.converged) {
    fill_tag(fit.fit_frame, model, fit.cells, fit.target);
  } else {
    fill_roughly(fit.fit_frame, start, sighting, fit.target);
  }
  return fit;
}

Judgement judge_tag(const DetectorInput& input, const TagFamily& family, const TagFit& fit) {
  if (!is_wanted(input, fit.reading)) {
    return unfit(
        fmt::format("it is tag {}, {} is asked for", fit.reading.id, *input.target.tag_id));
  }
  if (!fit.cells.converged) return unlikely(kUnlikeTarget);
  const double contrast = fit.target.contrast;
  if (auto problem = contrast_problem(std::abs(contrast), input.min_contrast())) {
    return unlikely(*std::move(problem));
  }
  const bool is_inverted = (contrast < 0) != (fit.reading.contrast < 0);
  if (is_inverted || !reads_the_same(input, family, fit)) return unlikely(kUnlikeTarget);
  if (auto problem = score_problem(fit.target.score, input.options.min_score))
    return unlikely(*std::move(problem));
  if (auto problem = unfit_tag(input, family, fit)) return unfit(*std::move(problem));
  return {};
}

}  // namespace panelcal::internal
