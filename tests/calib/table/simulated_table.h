// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/table/fit.h"

namespace panelcal::test {

using TableError = std::function<Eigen::Vector2d(const Eigen::Vector2d& commanded_mm)>;

/// 300 mm of travel that are off by 30 um at most, as bent ways and a warm screw leave them.
inline Eigen::Vector2d smooth_warp_mm(const Eigen::Vector2d& c) {
  const double x = c.x() / 300;
  const double y = c.y() / 300;
  return {0.020 * std::sin(4.5 * x + 1.0) * std::cos(3.0 * y) + 0.010 * std::sin(6.0 * y + 2.0 * x),
          0.018 * std::cos(5.0 * y - 0.5) * std::sin(2.5 * x + 0.4) + 0.012 * std::cos(5.5 * x)};
}

inline Eigen::Matrix2d turned(double angle_rad) {
  Eigen::Matrix2d r;
  r << std::cos(angle_rad), -std::sin(angle_rad), std::sin(angle_rad), std::cos(angle_rad);
  return r;
}

/// A square plate about its zero, whose dots lie off by up to `off_mm` at random from its drawing.
struct SimulatedPlate {
  std::vector<PlateDot> dots;
  std::vector<Eigen::Vector2d> true_mm;
};
inline SimulatedPlate simulated_plate(
    int per_side, double pitch_mm, bool is_certified, double off_sigma_mm, Random& random) {
  SimulatedPlate plate;
  const double middle = (per_side - 1) / 2.0;
  for (int row = 0; row < per_side; ++row) {
    for (int column = 0; column < per_side; ++column) {
      const Eigen::Vector2d drawn_mm((column - middle) * pitch_mm, (row - middle) * pitch_mm);
      const double x_mm = off_sigma_mm * random.normal();
      const double y_mm = off_sigma_mm * random.normal();
      plate.dots.push_back({position_mm<frame::Plate>(drawn_mm), is_certified, mm(0)});
      plate.true_mm.push_back(drawn_mm + Eigen::Vector2d(x_mm, y_mm));
    }
  }
  return plate;
}

/// Looks at every dot of the plate in a pose that is as said to `laid_rad` and `laid_mm`, where the
/// stage goes to the place the dot should have, or up to `beside_mm` beside it, and finds it a
/// little beside.
inline void look(const SimulatedPlate& plate,
                 const PlatePose& meant,
                 const TableError& error,
                 double noise_mm,
                 Random& random,
                 TableData& data,
                 double beside_mm = 0) {
  const std::size_t i_pose = data.views.empty() ? 0 : data.views.back().i_pose + 1;
  const double off_rad = 3e-4 * random.normal();
  const Eigen::Vector2d off_mm(0.05 * random.normal(), 0.05 * random.normal());
  if (data.dots.empty()) data.dots = plate.dots;
  for (std::size_t j = 0; j < plate.dots.size(); ++j) {
    Eigen::Vector2d commanded_mm =
        turned(meant.angle_rad) * plate.dots[j].place.in_mm() + meant.shift_mm;
    if (beside_mm > 0) {
      const double along_mm = beside_mm * (2 * random.uniform() - 1);
      commanded_mm += Eigen::Vector2d(along_mm, beside_mm * (2 * random.uniform() - 1));
    }
    const Eigen::Vector2d dot_mm =
        turned(meant.angle_rad + off_rad) * plate.true_mm[j] + meant.shift_mm + off_mm;
    const Eigen::Vector2d stands_mm = commanded_mm + error(commanded_mm);
    const double x_mm = noise_mm * random.normal();
    const double y_mm = noise_mm * random.normal();
    data.views.push_back({position_mm<frame::Machine>(commanded_mm), i_pose});
    data.seen.push_back(
        {data.views.size() - 1,
         j,
         {position_mm<frame::Optical>(dot_mm - stands_mm + Eigen::Vector2d(x_mm, y_mm)),
          std::max(noise_mm, 1e-5) * std::max(noise_mm, 1e-5) * Eigen::Matrix2d::Identity()}});
  }
}

/// Part of an error that is left when shift and turn are taken out of it, as TableFit does: by the
/// means over a square of 41 x 41 places from `low_mm` to `high_mm`.
struct MapComparison {
  double rms_mm = 0;  ///< of the vector
  double largest_mm = 0;
  double scale = 0;  ///< of what is left
  double squareness = 0;
};
inline MapComparison compare(const TableMap& map,
                             const TableError& error,
                             double low_mm,
                             double high_mm) {
  constexpr int kSide = 41;
  const double middle_mm = (low_mm + high_mm) / 2;
  std::vector<Eigen::Vector2d> at;
  std::vector<Eigen::Vector2d> off;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Eigen::Vector2d c_mm(low_mm + (high_mm - low_mm) * (i % kSide) / (kSide - 1.0),
                               low_mm + (high_mm - low_mm) * (i / kSide) / (kSide - 1.0));
    at.emplace_back(c_mm.x() - middle_mm, c_mm.y() - middle_mm);
    off.push_back(map.error_mm(position_mm<frame::Machine>(c_mm)) - error(c_mm));
  }
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& o : off) mean += o / static_cast<double>(off.size());
  double squares = 0;
  Eigen::Matrix2d moment = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < at.size(); ++i) {
    squares += at[i].x() * at[i].x();
    moment += (off[i] - mean) * at[i].transpose();
  }
  const Eigen::Matrix2d slope = moment / squares;
  MapComparison out;
  out.scale = (slope(0, 0) + slope(1, 1)) / 2;
  out.squareness = slope(0, 1) + slope(1, 0);
  const double turn = (slope(1, 0) - slope(0, 1)) / 2;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Eigen::Vector2d left = off[i] - mean - turn * Eigen::Vector2d(-at[i].y(), at[i].x());
    out.rms_mm += left.squaredNorm() / static_cast<double>(at.size());
    out.largest_mm = std::max(out.largest_mm, left.norm());
  }
  out.rms_mm = std::sqrt(out.rms_mm);
  return out;
}

}  // namespace panelcal::test
