// SPDX-License-Identifier: Apache-2.0
#include "machine/plate/fit.h"

#include <cmath>

#include "calib/base/plane_vectors.h"
#include <Eigen/Geometry>

namespace panelcal::internal {

PlatePose best_pose(const std::vector<PlacePair>& pairs,
                    const PlatePose& pose,
                    Length least_lever) {
  if (pairs.empty()) return pose;
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector2d plate_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d machine_mm = Eigen::Vector2d::Zero();
  for (const PlacePair& pair : pairs) {
    plate_mm += pair.plate_mm / n;
    machine_mm += pair.machine_mm / n;
  }
  double dot = 0;
  double cross = 0;
  double lever_mm2 = 0;
  for (const PlacePair& pair : pairs) {
    const Eigen::Vector2d a = pair.plate_mm - plate_mm;
    const Eigen::Vector2d b = pair.machine_mm - machine_mm;
    dot += a.dot(b);
    cross += internal::cross(a, b);
    lever_mm2 += a.squaredNorm();
  }
  PlatePose out = pose;
  if (std::sqrt(lever_mm2) >= least_lever.in_mm()) out.angle_rad = std::atan2(cross, dot);
  out.shift_mm = machine_mm - Eigen::Rotation2Dd(out.angle_rad) * plate_mm;
  return out;
}

Length rms_from(const PlatePose& pose, const std::vector<PlacePair>& pairs) {
  if (pairs.empty()) return Length();
  const Eigen::Rotation2Dd turn(pose.angle_rad);
  double sum_mm2 = 0;
  for (const PlacePair& pair : pairs) {
    sum_mm2 += (turn * pair.plate_mm + pose.shift_mm - pair.machine_mm).squaredNorm();
  }
  return mm(std::sqrt(sum_mm2 / static_cast<double>(pairs.size())));
}

}  // namespace panelcal::internal
