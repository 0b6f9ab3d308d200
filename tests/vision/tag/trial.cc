// SPDX-License-Identifier: Apache-2.0
#include "tests/vision/tag/trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/fit/coverage.h"
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace panelcal::test {
namespace {

using internal::OutlineNode;
using internal::ShareMap;

/// Gauss-Legendre of order 4 on panels of at most one blur, along a straight side in the picture.
void add_side(const Eigen::Vector2d& from,
              const Eigen::Vector2d& to,
              double panel_px,
              std::vector<OutlineNode>& nodes) {
  constexpr std::array kPlaces = {
      -0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
  constexpr std::array kWeights = {
      0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
  const Eigen::Vector2d whole = to - from;
  const int n = 1 + static_cast<int>(whole.norm() / panel_px);
  const Eigen::Vector2d panel = whole / n;
  for (int i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < kPlaces.size(); ++k) {
      nodes.push_back({from + (i + 0.5 + 0.5 * kPlaces[k]) * panel, 0.5 * kWeights[k] * panel.y()});
    }
  }
}

/// The outline, clockwise in the picture, of all cells of one level.
std::vector<OutlineNode> outline_of(const TagScene& scene, TagCell level) {
  const TagPattern& p = scene.pattern;
  const auto is_in = [&](int column, int row) {
    return column >= 0 && row >= 0 && column < p.n_cells && row < p.n_cells &&
           p.at(column, row) == level;
  };
  const auto at = [&](int column, int row) {
    return project(
        scene.image_from_tag,
        {p.lines[static_cast<std::size_t>(column)], p.lines[static_cast<std::size_t>(row)]});
  };
  std::vector<OutlineNode> nodes;
  for (int row = 0; row < p.n_cells; ++row) {
    for (int column = 0; column < p.n_cells; ++column) {
      if (!is_in(column, row)) continue;
      const std::array corners = {
          at(column, row), at(column + 1, row), at(column + 1, row + 1), at(column, row + 1)};
      const std::array is_edge = {!is_in(column, row - 1),
                                  !is_in(column + 1, row),
                                  !is_in(column, row + 1),
                                  !is_in(column - 1, row)};
      for (std::size_t i = 0; i < 4; ++i) {
        if (is_edge[i]) add_side(corners[i], corners[(i + 1) % 4], scene.blur_px, nodes);
      }
    }
  }
  return nodes;
}

void add_levels(const TagScene& scene, TagCell level, double step, std::vector<double>& levels) {
  const auto nodes = outline_of(scene, level);
  if (nodes.empty()) return;
  const ShareMap map = internal::integrate_inside(
      nodes, internal::PixelResponse(scene.blur_px), scene.width, scene.height);
  for (int y = map.y0; y < map.y1(); ++y) {
    for (int x = map.x0; x < map.x1(); ++x) {
      levels[static_cast<std::size_t>(y) * static_cast<std::size_t>(scene.width) +
             static_cast<std::size_t>(x)] += step * map.at(x, y);
    }
  }
}

}  // namespace

Eigen::Vector2d project(const Eigen::Matrix3d& image_from_tag, const Eigen::Vector2d& at) {
  return (image_from_tag * at.homogeneous()).hnormalized();
}

Eigen::Vector2d TagScene::center_px() const {
  return project(image_from_tag, Eigen::Vector2d::Zero());
}

std::array<Eigen::Vector2d, 4> TagScene::corners_px() const {
  std::array<Eigen::Vector2d, 4> corners = tag_corners();
  for (Eigen::Vector2d& c : corners) c = project(image_from_tag, c);
  return corners;
}

std::vector<double> tag_levels(const TagScene& scene) {
  std::vector<double> levels(
      static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height), scene.around);
  add_levels(scene, TagCell::White, scene.white - scene.around, levels);
  add_levels(scene, TagCell::Black, scene.black - scene.around, levels);
  const Eigen::Vector2d center = scene.center_px();
  const double unit = scene.full_scale / 255;
  std::size_t i = 0;
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      const double light = 1 + scene.light_gradient.x() * (x - center.x()) / scene.width +
                           scene.light_gradient.y() * (y - center.y()) / scene.height;
      levels[i++] *= light * unit;
    }
  }
  return levels;
}

Image tag_picture(const TagScene& scene, Random& random) {
  return noisy_picture(scene, tag_levels(scene), random);
}

Image noisy_picture(const TagScene& scene, const std::vector<double>& levels, Random& random) {
  Image image(scene.width, scene.height, scene.full_scale);
  const double sigma = scene.noise * scene.full_scale / 255;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double level = levels[i] + sigma * random.normal();
    image.pixels()[i] = static_cast<float>(std::clamp(std::round(level), 0.0, scene.full_scale));
  }
  return image;
}

Eigen::Matrix3d random_pose(const TagScene& scene,
                            double side_px,
                            double tilt_rad,
                            Random& random) {
  constexpr double kDistance = 5;
  constexpr double kShiftPx = 20;
  const double turn = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double tilt = tilt_rad * random.uniform();
  const double towards = random.uniform(-std::numbers::pi, std::numbers::pi);
  const Eigen::Vector3d axis(std::cos(towards), std::sin(towards), 0);
  const Eigen::Matrix3d r =
      (Eigen::AngleAxisd(tilt, axis) * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  Eigen::Matrix3d camera_from_tag;
  camera_from_tag << r.col(0), r.col(1), Eigen::Vector3d(0, 0, kDistance);
  const double focal = side_px * kDistance;
  Eigen::Matrix3d image_from_camera = Eigen::Matrix3d::Identity();
  image_from_camera(0, 0) = image_from_camera(1, 1) = focal;
  image_from_camera(0, 2) = 0.5 * (scene.width - 1) + random.uniform(-kShiftPx, kShiftPx);
  image_from_camera(1, 2) = 0.5 * (scene.height - 1) + random.uniform(-kShiftPx, kShiftPx);
  return image_from_camera * camera_from_tag;
}

TagBound tag_bound(const TagScene& scene) {
  // Pose, both levels with two slopes each, blur.
  constexpr int kPose = 8;
  constexpr int kUnknown = kPose + 7;
  constexpr double kStep = 1e-4;
  using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, kUnknown>;
  const auto n = static_cast<Eigen::Index>(scene.width) * scene.height;
  Jacobian j(n, kUnknown);
  const auto column = [&](int i, TagScene low, TagScene high, double step) {
    const std::vector<double> a = tag_levels(low);
    const std::vector<double> b = tag_levels(high);
    j.col(i) = (Eigen::Map<const Eigen::VectorXd>(b.data(), n) -
                Eigen::Map<const Eigen::VectorXd>(a.data(), n)) /
               (2 * step);
  };
  const Eigen::Matrix3d h = scene.image_from_tag / scene.image_from_tag(2, 2);
  const auto moved = [&](int i, double step) {
    TagScene s = scene;
    s.image_from_tag = h;
    s.image_from_tag(i / 3, i % 3) += step;
    return s;
  };
  // Slopes of perspective act on places of about the side's length.
  const double side = h.topLeftCorner<2, 2>().norm();
  for (int i = 0; i < kPose; ++i) {
    const double step = i < 6 ? kStep * 10 : kStep * 10 / side;
    column(i, moved(i, -step), moved(i, step), step);
  }
  const auto levels = [&](double black, double white) {
    TagScene s = scene;
    s.black = black;
    s.white = white;
    s.light_gradient.setZero();
    const auto values = tag_levels(s);
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(values.data(), n));
  };
  const Eigen::VectorXd neither = levels(scene.around, scene.around);
  const Eigen::VectorXd black = levels(scene.around + 1, scene.around) - neither;
  const Eigen::VectorXd white = levels(scene.around, scene.around + 1) - neither;
  const Eigen::Vector2d center = scene.center_px();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d plane(1,
                                (static_cast<double>(i % scene.width) - center.x()) / side,
                                (static_cast<double>(i / scene.width) - center.y()) / side);
    j.block<1, 3>(i, kPose) = black[i] * plane.transpose();
    j.block<1, 3>(i, kPose + 3) = white[i] * plane.transpose();
  }
  TagScene sharp = scene;
  TagScene blurred = scene;
  sharp.blur_px -= kStep;
  blurred.blur_px += kStep;
  column(kPose + 6, sharp, blurred, kStep);
  // Nothing is known of surroundings that show in the blur: such pixels tell nothing.
  for (Eigen::Index i = 0; i < n; ++i) {
    if (black[i] + white[i] < 1 - 1e-3) j.row(i).setZero();
  }
  const double variance = std::pow(scene.noise * scene.full_scale / 255, 2);
  const Eigen::Matrix<double, kUnknown, kUnknown> information = j.transpose() * j / variance;
  const Eigen::Matrix<double, kPose, kPose> cov =
      information.inverse().topLeftCorner<kPose, kPose>();
  const auto variance_at = [&](const Eigen::Vector2d& at) {
    Eigen::Matrix<double, 2, kPose> d;
    for (int i = 0; i < kPose; ++i) {
      const double step = i < 6 ? kStep : kStep / side;
      d.col(i) = (project(moved(i, step).image_from_tag, at) -
                  project(moved(i, -step).image_from_tag, at)) /
                 (2 * step);
    }
    return (d * cov * d.transpose()).trace() / 2;
  };
  TagBound bound;
  bound.center_px = std::sqrt(variance_at(Eigen::Vector2d::Zero()));
  for (const Eigen::Vector2d& c : tag_corners()) bound.corner_px += variance_at(c) / 4;
  bound.corner_px = std::sqrt(bound.corner_px);
  return bound;
}

}  // namespace panelcal::test
