// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/camera/fit/fit.h"

namespace panelcal::test {

/// 10 um/px over 640 x 480 px.
inline CameraModel::Parameters straight_camera() {
  CameraModel::Parameters p;
  p.scale_mm_per_px = 0.010;
  p.axis_px = {320, 240};
  p.focal_px = 5000;
  return p;
}

/// As bad as a machine camera gets: 2 degrees of tilt, and a lens that bends the corner by 1 px by
/// k1, 0.3 px by k2 and 0.2 px by p1 and p2.
inline CameraModel::Parameters bent_camera() {
  CameraModel::Parameters p = straight_camera();
  p.scale_mm_per_px = 0.0101;
  p.rotation_rad = 0.02;
  p.tilt = {0.030, -0.018};
  p.k1_per_px2 = 1.6e-8;
  p.k2_per_px4 = 3e-14;
  p.p1_per_px = 5e-7;
  p.p2_per_px = -4e-7;
  return p;
}

/// The centroid of the image of a disc, from a polygon of its rim.
inline Eigen::Vector2d centroid_px(const CameraModel& camera,
                                   const Position<frame::Optical>& center,
                                   Length radius,
                                   int corners = 720) {
  const Eigen::Vector2d about_px = camera.image_of(center)->in_px();
  double area = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  const auto corner = [&](int i) {
    const double angle_rad = 2 * std::numbers::pi * i / corners;
    const Eigen::Vector2d rim_mm =
        radius.in_mm() * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    return Eigen::Vector2d(
        camera.image_of(center + displacement_mm<frame::Optical>(rim_mm))->in_px() - about_px);
  };
  Eigen::Vector2d last = corner(0);
  for (int i = 1; i <= corners; ++i) {
    const Eigen::Vector2d next = corner(i);
    const double twice = last.x() * next.y() - last.y() * next.x();
    area += twice / 2;
    moment += twice / 6 * (last + next);
    last = next;
  }
  return about_px + moment / area;
}

/// A square plate of dots about its zero, as its drawing has it.
inline std::vector<PlateDot> dot_plate(int per_side, double pitch_mm, Length radius) {
  std::vector<PlateDot> dots;
  for (int row = 0; row < per_side; ++row) {
    for (int column = 0; column < per_side; ++column) {
      const double middle = (per_side - 1) / 2.0;
      dots.push_back(
          {position_mm<frame::Plate>((column - middle) * pitch_mm, (row - middle) * pitch_mm),
           true,
           radius});
    }
  }
  return dots;
}

/// Adds the places at which view `view` shows a plate's dots, which lie at `dots_mm`; without
/// noise.
inline void see(const CameraModel& camera,
                const std::vector<Eigen::Vector2d>& dots_mm,
                const PlatePose& pose,
                std::size_t i_view,
                CameraData& data) {
  const double c = std::cos(pose.angle_rad);
  const double s = std::sin(pose.angle_rad);
  for (std::size_t j = 0; j < dots_mm.size(); ++j) {
    const Eigen::Vector2d& dot = dots_mm[j];
    const Eigen::Vector2d place =
        Eigen::Vector2d(c * dot.x() - s * dot.y(), s * dot.x() + c * dot.y()) + pose.shift_mm -
        data.views[i_view].axis_at.in_mm();
    const auto center = position_mm<frame::Optical>(place);
    const auto u = camera.image_of(center);
    if (!u || u->in_px().x() < 10 || u->in_px().y() < 10 || u->in_px().x() > 629 ||
        u->in_px().y() > 469) {
      continue;
    }
    const Length radius = data.dots[j].radius;
    const Eigen::Vector2d seen_px =
        radius > mm(0) ? centroid_px(camera, center, radius, 90) : u->in_px();
    data.seen.push_back(
        {i_view, j, {position_px<frame::Image>(seen_px), Eigen::Matrix2d::Identity()}});
  }
}

inline void add_noise(Random& random, double sigma_px, CameraData& data) {
  for (CameraObservation& seen : data.seen) {
    const double x_px = sigma_px * random.normal();
    const double y_px = sigma_px * random.normal();
    seen.seen.position =
        seen.seen.position + displacement_px<frame::Image>(Eigen::Vector2d(x_px, y_px));
    seen.seen.cov = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
  }
}

/// Five views of a certified plate of 9 x 9 dots that is laid down anew before each.
inline CameraData plate_views(const CameraModel& camera, Length radius) {
  CameraData data;
  data.dots = dot_plate(9, 0.6, radius);
  std::vector<Eigen::Vector2d> dots_mm;
  for (const PlateDot& dot : data.dots) dots_mm.push_back(dot.place.in_mm());
  const PlatePose poses[] = {{0.01, {0.1, 0.05}},
                             {0.5, {-0.4, 0.3}},
                             {1.6, {0.5, 0.4}},
                             {-0.8, {0.3, -0.5}},
                             {3.0, {-0.2, -0.2}}};
  for (std::size_t i = 0; i < std::size(poses); ++i) {
    data.views.push_back({position_mm<frame::Machine>(0, 0), i});
    see(camera, dots_mm, poses[i], i, data);
  }
  return data;
}

/// One target of unknown place, looked at from a grid of stage places.
inline CameraData target_views(const CameraModel& camera, int per_side, Length radius) {
  CameraData data;
  data.dots = {{position_mm<frame::Plate>(0, 0), false, radius}};
  const PlatePose pose{0, {100.3, 80.7}};
  for (int row = 0; row < per_side; ++row) {
    for (int column = 0; column < per_side; ++column) {
      const double x_mm = 100 + 5.2 * (column / (per_side - 1.0) - 0.5);
      const double y_mm = 80 + 3.8 * (row / (per_side - 1.0) - 0.5);
      data.views.push_back({position_mm<frame::Machine>(x_mm, y_mm), 0});
      see(camera, {Eigen::Vector2d(0, 0)}, pose, data.views.size() - 1, data);
    }
  }
  return data;
}

}  // namespace panelcal::test
