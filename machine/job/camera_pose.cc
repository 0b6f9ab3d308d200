// SPDX-License-Identifier: Apache-2.0
#include "machine/job/camera_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <vector>

#include "calib/base/plane_vectors.h"
#include <Eigen/Core>
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::size_t kMinTargets = 3;
/// The least part of the residuals that another pose of the camera must take away.
constexpr double kMinGain = 8;

struct CameraPose {
  std::string_view words;
  double xx, xy, yx, yy;

  Eigen::Vector2d operator()(const Eigen::Vector2d& v) const {
    return {xx * v.x() + xy * v.y(), yx * v.x() + yy * v.y()};
  }
};

/// The first one is the pose that the configuration has. Half a turn more leaves the same
/// residuals.
constexpr std::array<CameraPose, 4> kPoses = {{{"the camera as it is", 1, 0, 0, 1},
                                               {"x -> -x (or y -> -y)", -1, 0, 0, 1},
                                               {"a turn by 90 degrees (or -90)", 0, -1, 1, 0},
                                               {"x <-> y (or x <-> -y)", 0, 1, 1, 0}}};

struct SeenTarget {
  Eigen::Vector2d expected_mm;
  Eigen::Vector2d deviation_mm;
};

/// The root mean square that a rotation and an offset leave of the targets' places.
double rest_mm(const std::vector<SeenTarget>& targets, const CameraPose& pose) {
  const auto n = static_cast<double>(targets.size());
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  for (const SeenTarget& t : targets) {
    from += t.expected_mm / n;
    to += (t.expected_mm + pose(t.deviation_mm)) / n;
  }
  double dot = 0;
  double cross = 0;
  for (const SeenTarget& t : targets) {
    const Eigen::Vector2d a = t.expected_mm - from;
    const Eigen::Vector2d b = t.expected_mm + pose(t.deviation_mm) - to;
    dot += a.dot(b);
    cross += internal::cross(a, b);
  }
  const double angle = std::atan2(cross, dot);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  double sum_mm2 = 0;
  for (const SeenTarget& t : targets) {
    const Eigen::Vector2d a = t.expected_mm - from;
    const Eigen::Vector2d b = t.expected_mm + pose(t.deviation_mm) - to;
    sum_mm2 += (b - Eigen::Vector2d(c * a.x() - s * a.y(), s * a.x() + c * a.y())).squaredNorm();
  }
  return std::sqrt(sum_mm2 / n);
}

/// The pose that a series speaks for; 0: none but the configured one.
std::size_t best_pose(const std::vector<SeenTarget>& targets) {
  std::array<double, kPoses.size()> rests_mm{};
  for (std::size_t i = 0; i < kPoses.size(); ++i) rests_mm[i] = rest_mm(targets, kPoses[i]);
  const auto least = std::ranges::min_element(rests_mm);
  return kMinGain * *least <= rests_mm[0] ? static_cast<std::size_t>(least - rests_mm.begin()) : 0;
}

std::vector<SeenTarget> targets_of(const SeriesResult& series, const Survey& survey) {
  std::vector<SeenTarget> targets;
  for (const std::size_t i : series.measurements) {
    const Measurement& one = survey.measurements[i];
    if (one.status != MeasurementStatus::Found) continue;
    const Eigen::Vector2d deviation_mm = (one.measured.position - one.request.expected).in_mm();
    targets.push_back({one.request.expected.in_mm(), deviation_mm});
  }
  return targets;
}

}  // namespace

std::optional<std::string> camera_pose_words(const Survey& survey) {
  std::size_t n_refused = 0;
  std::size_t common = 0;
  for (const SeriesResult& series : survey.series) {
    if (series.is_accepted() || series.is_left_out) continue;
    const std::vector<SeenTarget> targets = targets_of(series, survey);
    if (targets.size() < kMinTargets) continue;
    const std::size_t pose = best_pose(targets);
    if (pose == 0 || (n_refused > 0 && pose != common)) return std::nullopt;
    common = pose;
    ++n_refused;
  }
  if (n_refused == 0) return std::nullopt;
  return fmt::format("mirrored or turned camera: residuals agree with {} ({} refused series)",
                     kPoses[common].words,
                     n_refused);
}

}  // namespace panelcal
