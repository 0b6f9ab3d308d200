// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace panelcal {

/// A place where the program has a hole or a target, that a camera may take for another.
struct KnownPad {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  int line = 0;  ///< of the program; 0: unknown
  int tool = 0;  ///< that drills there; 0: a target
};

/// The pads of a program, to be asked for what lies near a place.
///
/// Cost   O(n log n) once, wherever they lie; a question costs what lies in the cells it touches
/// See    tests/calib/faults/known_pads_test.cc
class KnownPads {
 public:
  KnownPads() = default;
  /// Of pads nearer to each other than a micrometre the first is kept.
  explicit KnownPads(std::vector<KnownPad> pads);

  std::span<const KnownPad> all() const { return pads_; }
  /// Indices of the pads inside the rectangle, edges included, in ascending order of cells.
  void inside(const Eigen::Vector2d& low_mm,
              const Eigen::Vector2d& high_mm,
              std::vector<std::size_t>& found) const;
  /// Indices of the pads within a distance, the nearest first.
  std::vector<std::size_t> within(const Eigen::Vector2d& place_mm, double radius_mm) const;
  Eigen::Vector2d box_center_mm() const { return 0.5 * (low_mm_ + high_mm_); }
  double box_diagonal_mm() const { return (high_mm_ - low_mm_).norm(); }

 private:
  Eigen::Vector2i cell_of(const Eigen::Vector2d& place_mm) const;

  std::vector<KnownPad> pads_;  ///< by cell
  std::vector<std::size_t> first_of_cell_;
  Eigen::Vector2d low_mm_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_mm_ = Eigen::Vector2d::Zero();
  double cell_mm_ = 1;
  Eigen::Vector2i n_cells_ = Eigen::Vector2i::Zero();
};

}  // namespace panelcal
