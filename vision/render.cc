// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "panelcal/vision/coverage.h"
#include "panelcal/vision/weave.h"

namespace panelcal {
namespace {

using internal::OutlineNode;
using internal::ShareMap;

/// Spacing of outline nodes in sigmas of the blur: the trapezoid rule's error is then about
/// exp(-(2 pi / 0.6)^2 / 2), nothing.
constexpr double kNodeSpacing = 0.6;

/// A node from a place on the outline and the tangent there times its weight, both in mm. False if
/// the lens model cannot draw the place, which is then far outside of any picture.
bool add_node(const CameraMapping& mapping,
              const Eigen::Vector2d& at_mm,
              const Eigen::Vector2d& step_mm,
              std::vector<OutlineNode>& nodes) {
  const auto u = mapping.image_of(position_mm<frame::Optical>(at_mm));
  if (!u) return false;
  const Eigen::Matrix2d j = mapping.jacobian(*u);
  const double det = j(0, 0) * j(1, 1) - j(0, 1) * j(1, 0);
  const double dy_px = (-j(1, 0) * step_mm.x() + j(0, 0) * step_mm.y()) / det;
  nodes.push_back({u->in_px(), dy_px});
  return true;
}

std::vector<OutlineNode> circle_nodes(const Camera& camera,
                                      const Eigen::Vector2d& center_mm,
                                      double radius_mm) {
  const double scale = camera.mapping.parameters().scale_mm_per_px;
  const double length_px = 2 * std::numbers::pi * radius_mm / scale;
  const int n = 32 + static_cast<int>(length_px / (kNodeSpacing * camera.blur_px));
  const double dtheta = 2 * std::numbers::pi / n;
  std::vector<OutlineNode> nodes;
  nodes.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d e(std::cos(i * dtheta), std::sin(i * dtheta));
    const Eigen::Vector2d tangent(-e.y(), e.x());
    const Eigen::Vector2d at = center_mm + radius_mm * e;
    if (!add_node(camera.mapping, at, radius_mm * dtheta * tangent, nodes)) return {};
  }
  return nodes;
}

/// A side has ends, where the trapezoid rule is poor: Gauss-Legendre of order 4 on short panels.
bool add_side(const Camera& camera,
              const Eigen::Vector2d& from_mm,
              const Eigen::Vector2d& to_mm,
              std::vector<OutlineNode>& nodes) {
  constexpr std::array kPlaces = {
      -0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
  constexpr std::array kWeights = {
      0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
  const double scale = camera.mapping.parameters().scale_mm_per_px;
  const Eigen::Vector2d whole = to_mm - from_mm;
  const int n = 1 + static_cast<int>(whole.norm() / scale / camera.blur_px);
  const Eigen::Vector2d panel = whole / n;
  for (int i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < kPlaces.size(); ++k) {
      const Eigen::Vector2d at = from_mm + (i + 0.5 + 0.5 * kPlaces[k]) * panel;
      if (!add_node(camera.mapping, at, 0.5 * kWeights[k] * panel, nodes)) return false;
    }
  }
  return true;
}

std::vector<OutlineNode> rectangle_nodes(const Camera& camera, const Feature& feature) {
  const double c = std::cos(feature.angle.in_rad());
  const double s = std::sin(feature.angle.in_rad());
  const Eigen::Vector2d along = 0.5 * feature.size.in_mm() * Eigen::Vector2d(c, s);
  const Eigen::Vector2d across = 0.5 * feature.inner_size.in_mm() * Eigen::Vector2d(-s, c);
  const Eigen::Vector2d& m = feature.center.in_mm();
  const std::array<Eigen::Vector2d, 4> corners = {
      m - along - across, m + along - across, m + along + across, m - along + across};
  std::vector<OutlineNode> nodes;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!add_side(camera, corners[i], corners[(i + 1) % corners.size()], nodes)) return {};
  }
  return nodes;
}

ShareMap share_of_circle(const Camera& camera, const Feature& feature, Length diameter) {
  const auto nodes = circle_nodes(camera, feature.center.in_mm(), diameter.in_mm() / 2);
  return share_inside(nodes, camera.blur_px, camera.width, camera.height);
}

ShareMap share_of(const Camera& camera, const Feature& feature) {
  if (feature.shape == Feature::Shape::Rectangle) {
    return share_inside(
        rectangle_nodes(camera, feature), camera.blur_px, camera.width, camera.height);
  }
  ShareMap share = share_of_circle(camera, feature, feature.size);
  if (feature.shape == Feature::Shape::Ring && feature.inner_size > mm(0)) {
    const ShareMap hole = share_of_circle(camera, feature, feature.inner_size);
    for (int y = std::max(share.y0, hole.y0); y < std::min(share.y1(), hole.y1()); ++y) {
      for (int x = std::max(share.x0, hole.x0); x < std::min(share.x1(), hole.x1()); ++x) {
        share.at(x, y) -= hole.at(x, y);
      }
    }
  }
  return share;
}

void paint_background(const Scene& scene, const Camera& camera, std::span<double> levels) {
  std::fill(levels.begin(), levels.end(), scene.background);
  if (scene.weave.amplitude == 0) return;
  const double period_mm = scene.weave.period.in_mm();
  std::size_t i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      const auto on_panel = scene.weave.panel_from_optical(camera.mapping(position_px(x, y)));
      levels[i] += scene.weave.amplitude *
                   internal::weave_level(on_panel.in_mm(), period_mm, scene.weave.seed);
    }
  }
}

void paint(const ShareMap& share, double level, int picture_width, std::span<double> levels) {
  for (int y = share.y0; y < share.y1(); ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_width);
    for (int x = share.x0; x < share.x1(); ++x) {
      double& v = levels[row + static_cast<std::size_t>(x)];
      v += (level - v) * share.at(x, y);
    }
  }
}

/// Light at a pixel, 1 in the middle of the picture.
double light(const Scene& scene, const Camera& camera, int x, int y) {
  const double dx = (x - 0.5 * (camera.width - 1)) / camera.width;
  const double dy = (y - 0.5 * (camera.height - 1)) / camera.height;
  const double corners = 2 * (dx * dx + dy * dy);
  return (1 + scene.light_gradient.x() * dx + scene.light_gradient.y() * dy) *
         (1 - scene.vignetting * corners);
}

}  // namespace

Image render(const Scene& scene, const Camera& camera, Random& random) {
  Image image(camera.width, camera.height, camera.full_scale);
  std::vector<double> levels(image.pixels().size());
  paint_background(scene, camera, levels);
  for (const Feature& feature : scene.features) {
    paint(share_of(camera, feature), feature.level, camera.width, levels);
  }
  std::size_t i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      double v = levels[i] * light(scene, camera, x, y) * camera.full_scale;
      if (camera.noise > 0) v += camera.noise * random.normal();
      image.pixels()[i] = static_cast<float>(std::clamp(std::round(v), 0.0, camera.full_scale));
    }
  }
  return image;
}

}  // namespace panelcal
