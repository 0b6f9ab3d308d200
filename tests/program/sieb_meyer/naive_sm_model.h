// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "tests/program/sieb_meyer/random_sm_job.h"

namespace panelcal::test {

/// True place of the board, in work coordinates, mm.
using BoardMap = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;

struct NaiveCut {
  bool is_controlled = false;  ///< G83
  std::optional<double> z_mm;
  std::optional<double> depth_mm;
  std::optional<double> lower_limit_mm;
};

/// One thing that the tool does, in work coordinates, mm.
struct NaiveEvent {
  enum class Kind { Hole, Line, Arc, Figure };
  Kind kind = Kind::Hole;
  int tool = 0;
  NaiveCut cut;
  Eigen::Vector2d nominal_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();      ///< corrected; of a rout its end
  Eigen::Vector2d from_mm = Eigen::Vector2d::Zero();    ///< of a rout; a figure's plunge point
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();  ///< of an arc or figure
  int turn = 0;                                         ///< 1 counterclockwise, -1 clockwise
  int side = 0;                                         ///< of the cutter: 1 left, -1 right
  /// Holes with the same number above 0 come in any order.
  int group = 0;
  double radius_mm = 0;  ///< of the cutter's way round a circular figure
  /// Corners of a rectangle for the cutter's centre.
  std::vector<Eigen::Vector2d> corners_mm;
};

/// Works out what a job does, by the manual and the semantics page alone.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 2.5, 3, 5, 8.1, 8.2, 9
std::vector<NaiveEvent> naive_events(const SmJob& job, const BoardMap& board);

}  // namespace panelcal::test
