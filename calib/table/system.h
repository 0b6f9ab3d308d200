// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "calib/correction/table_basis.h"
#include "calib/table/fit_input.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Everything that a table fit estimates.
struct TableState {
  Eigen::VectorXd table_mm;  ///< coefficients, x and y by turns
  std::vector<PlatePose> poses;
  std::vector<Eigen::Vector2d> dots_mm;  ///< errors
};

/// Lays each pose on the dots as they are given, for a table without error.
TableState table_start(const TableData& data, const TableBasis& basis);

/// Seen minus fitted, in the table.
Eigen::Vector2d table_residual_mm(const TableData& data,
                                  const TableBasis& basis,
                                  const TableState& state,
                                  const TableObservation& seen);

/// Normal equations of everything but the smoothness, about a state's poses, with dots and poses
/// eliminated.
///
///   |y - A x|^2 = (x - x0)' S (x - x0) + rest,   S x = s   for the table's coefficients
class TableSystem {
 public:
  TableSystem(const TableData& data,
              std::span<const std::size_t> used,
              const TableBasis& basis,
              const TableState& about);

  const Eigen::MatrixXd& normal() const { return normal_; }
  const Eigen::VectorXd& right_side() const { return right_side_; }
  double sum_of_squares() const { return sum_of_squares_; }  ///< for a table of zeros
  int n_eliminated() const { return n_eliminated_; }
  /// Poses and dots that go with a table.
  TableState complete(const Eigen::VectorXd& table_mm) const;

 private:
  void add(const TableData& data, const TableObservation& seen, const TableBasis& basis);
  void eliminate_dots();
  void eliminate_poses();

  const TableState& about_;
  Eigen::MatrixXd normal_;
  Eigen::VectorXd right_side_;
  double sum_of_squares_ = 0;
  int n_eliminated_ = 0;
  /// Before dots are eliminated: table and poses, with each dot (2 columns and its right side).
  struct Dot {
    Eigen::MatrixXd cross;
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right_side = Eigen::Vector2d::Zero();
  };
  std::vector<Dot> dots_;
  Eigen::Index n_table_;
  Eigen::VectorXd before_;     ///< diagonal of the poses' part
  Eigen::MatrixXd pose_gain_;  ///< poses = pose_offset - pose_gain table
  Eigen::VectorXd pose_offset_;
};

}  // namespace panelcal::internal
