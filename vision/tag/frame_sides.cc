// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/frame_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "vision/fit/regression.h"
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

/// Distance at which a side is searched, cells to either side: first widely, then near what was
/// found.
constexpr std::array kSideReach = {1.3, 0.6};
constexpr double kDepthStep = 0.1;  // cells
constexpr int kStepsPerSide = 20;   // places on a side
constexpr double kAgreeing = 0.25;  // of a cell: steps that lie so near a line agree with it
constexpr double kLeastAgreeing = 0.4;

double frame_level_at(const Image& image, const Eigen::Vector2d& u_px) {
  const double x = std::clamp(u_px.x(), 0.0, image.width() - 1.0);
  const double y = std::clamp(u_px.y(), 0.0, image.height() - 1.0);
  const int x0 = std::min(static_cast<int>(x), std::max(0, image.width() - 2));
  const int y0 = std::min(static_cast<int>(y), std::max(0, image.height() - 2));
  const int x1 = std::min(x0 + 1, image.width() - 1);
  const int y1 = std::min(y0 + 1, image.height() - 1);
  const double a = x - x0;
  const double b = y - y0;
  return (1 - b) * ((1 - a) * image.at(x0, y0) + a * image.at(x1, y0)) +
         b * ((1 - a) * image.at(x0, y1) + a * image.at(x1, y1));
}

/// A side and the directions about it.
struct FrameSide {
  Eigen::Vector2d from;
  Eigen::Vector2d along;    ///< to the next corner
  Eigen::Vector2d outward;  ///< of one cell's length
};

/// A step of level: how far along the side (0 to 1) and outwards of it (cells) it is.
struct SideStep {
  double along = 0;
  double out = 0;
};

/// A tag's own levels lie between these; levels beyond are debris or a glint.
struct LevelRange {
  double low = 0;
  double high = 0;
};

LevelRange range_about(const Image& image, const TagQuad& quad) {
  constexpr int kSamples = 32;
  constexpr double kWider = 1.2;  // than the corners' square
  constexpr double kPart = 0.1;   // of the levels beyond either end
  const Eigen::Matrix3d h = quad.image_from_tag();
  std::vector<double> levels;
  for (int i = 0; i < kSamples * kSamples; ++i) {
    const Eigen::Vector2d v((i % kSamples + 0.5) / kSamples - 0.5,
                            (i / kSamples + 0.5) / kSamples - 0.5);
    levels.push_back(frame_level_at(image, (h * (kWider * v).homogeneous()).hnormalized()));
  }
  std::sort(levels.begin(), levels.end());
  const auto at = [&](double part) {
    return levels[static_cast<std::size_t>(part * static_cast<double>(levels.size() - 1))];
  };
  return {at(kPart), at(1 - kPart)};
}

/// View in which sides are searched.
struct SideView {
  const Image& image;
  LevelRange range;
  double reach = 0;  ///< cells
  double sign = 1;   ///< 1 if the frame is darker inside
};

/// Step at which the level changes most from outside to inside of the frame, at one place of a
/// side.
std::optional<SideStep> step_at(const SideView& view, const FrameSide& side, double along) {
  const auto& [image, range, reach, sign] = view;
  const double cell_px = side.outward.norm();
  const int n = static_cast<int>(std::lround(reach / kDepthStep));
  const int half = static_cast<int>(std::lround(0.8 / kDepthStep));
  const int gap = 1;
  // Running sums of the profile; a place's level is the mean over most of a cell along the side.
  const int n_across = std::clamp(static_cast<int>(cell_px / 2), 1, 5);
  const Eigen::Vector2d spread = 0.7 * cell_px * side.along.normalized();
  std::vector<double> sums = {0};
  for (int k = -n - half - gap; k <= n + half + gap; ++k) {
    const Eigen::Vector2d middle = side.from + along * side.along + k * kDepthStep * side.outward;
    double level = 0;
    for (int j = 0; j < n_across; ++j) {
      const Eigen::Vector2d at = middle + ((j + 0.5) / n_across - 0.5) * spread;
      level += std::clamp(frame_level_at(image, at), range.low, range.high);
    }
    sums.push_back(sums.back() + level / n_across);
  }
  const auto sum = [&](int from, int to) {  // of depths from <= k < to
    const int first = n + half + gap;
    return sums[static_cast<std::size_t>(to + first)] -
           sums[static_cast<std::size_t>(from + first)];
  };
  double best = 0;
  std::optional<SideStep> step;
  for (int k = -n; k <= n; ++k) {
    const double outside = sum(k + gap, k + gap + half);
    const double inside = sum(k - gap - half + 1, k - gap + 1);
    const double change = sign * (outside - inside);
    if (change <= best) continue;
    best = change;
    step = SideStep{along, k * kDepthStep};
  }
  return step;
}

/// out = at_start + slope along; the line that most steps agree on.
struct SideLine {
  double at_start = 0;
  double slope = 0;
  int n_agreeing = 0;
};

SideLine least_squares_line(const std::vector<SideStep>& steps, const SideLine& near) {
  Regression sums;
  for (const SideStep& s : steps) {
    if (std::abs(s.out - near.at_start - near.slope * s.along) > kAgreeing) continue;
    sums.add(s.along, s.out);
  }
  if (!(sums.n * sums.model_square() > 1e-9)) return near;
  SideLine line = near;
  line.slope = sums.gain();
  line.at_start = (sums.v - line.slope * sums.m) / sums.n;
  return line;
}

std::optional<SideLine> agreed_line(const std::vector<SideStep>& steps) {
  constexpr double kLeastApart = 0.25;  // of the side: two steps that make a line
  SideLine best;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    for (std::size_t k = i + 1; k < steps.size(); ++k) {
      const double apart = steps[k].along - steps[i].along;
      if (apart < kLeastApart) continue;
      SideLine line;
      line.slope = (steps[k].out - steps[i].out) / apart;
      line.at_start = steps[i].out - line.slope * steps[i].along;
      for (const SideStep& s : steps) {
        line.n_agreeing += std::abs(s.out - line.at_start - line.slope * s.along) <= kAgreeing;
      }
      if (line.n_agreeing > best.n_agreeing) best = line;
    }
  }
  if (best.n_agreeing < kLeastAgreeing * kStepsPerSide) return std::nullopt;
  return least_squares_line(steps, best);
}

/// A line of the picture as homogeneous coordinates.
std::optional<Eigen::Vector3d> seen_side(const SideView& view, const FrameSide& side) {
  std::vector<SideStep> steps;
  for (int i = 0; i < kStepsPerSide; ++i) {
    const double along = (i + 0.5) / kStepsPerSide;
    if (const auto step = step_at(view, side, along)) steps.push_back(*step);
  }
  const auto line = agreed_line(steps);
  if (!line) return std::nullopt;
  const Eigen::Vector2d a = side.from + line->at_start * side.outward;
  const Eigen::Vector2d b = side.from + side.along + (line->at_start + line->slope) * side.outward;
  return a.homogeneous().cross(b.homogeneous());
}

/// Convex and not folded: what a flat square looks like from in front of it.
bool is_convex(const TagQuad& quad) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d a = quad.corners_px[(i + 1) % 4] - quad.corners_px[i];
    const Eigen::Vector2d b = quad.corners_px[(i + 2) % 4] - quad.corners_px[(i + 1) % 4];
    // Counter-clockwise as seen, so clockwise where y points down.
    if (!(a.x() * b.y() - a.y() * b.x() < -0.2 * a.norm() * b.norm())) return false;
  }
  return true;
}

std::optional<TagQuad> sides_once(const SideView& view,
                                  const TagFamily& family,
                                  const TagQuad& quad) {
  const double cell_px = quad.mean_side_px() / family.n_on_side;
  std::array<Eigen::Vector3d, 4> lines;
  for (std::size_t i = 0; i < 4; ++i) {
    FrameSide side;
    side.from = quad.corners_px[i];
    side.along = quad.corners_px[(i + 1) % 4] - side.from;
    // The corners run counter-clockwise as seen: outside is on the right of every side.
    side.outward = cell_px * Eigen::Vector2d(-side.along.y(), side.along.x()).normalized();
    const auto line = seen_side(view, side);
    if (!line) return std::nullopt;
    lines[i] = *line;
  }
  TagQuad moved;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d corner = lines[(i + 3) % 4].cross(lines[i]);
    if (!(std::abs(corner.z()) > 0)) return std::nullopt;
    moved.corners_px[i] = corner.hnormalized();
    if (!moved.corners_px[i].allFinite()) return std::nullopt;
  }
  if (!is_convex(moved)) return std::nullopt;
  return moved;
}

}  // namespace

std::optional<TagQuad> moved_to_sides(const Image& image,
                                      const TagFamily& family,
                                      const TagQuad& quad,
                                      bool is_inverted) {
  const double sign = family.is_reversed == is_inverted ? 1 : -1;
  const LevelRange range = range_about(image, quad);
  std::optional<TagQuad> moved = quad;
  for (const double reach : kSideReach) {
    moved = sides_once({image, range, reach, sign}, family, *moved);
    if (!moved || !moved->image_from_tag().allFinite()) return std::nullopt;
  }
  return moved;
}

}  // namespace panelcal::internal
