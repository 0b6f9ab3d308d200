// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/estimate.h"
#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/correction/table_map.h"
#include <Eigen/Core>

namespace panelcal {

/// A dot of the plate, seen from where the axis stood: in machine directions, camera calibrated.
/// Its covariance holds all that differs from look to look, the stage's repeatability too.
struct TableObservation {
  std::size_t i_view = 0;
  std::size_t i_dot = 0;
  PositionEstimate<frame::Optical> seen;
};

struct TableData {
  std::vector<PlateView> views;
  std::vector<PlateDot> dots;
  std::vector<TableObservation> seen;
};

struct TableFitOptions {
  /// Of the grid along its longer side. More follow a rougher warp and cost the cube; what the
  /// data do not ask for is smoothed away in any case.
  int steps = 10;
  /// The grid; by default the rectangle of commanded places.
  std::optional<TableGrid> grid;
  /// A polynomial error whose mean size is known no better than this counts as undetermined.
  Length open_sigma = mm(0.05);
  /// One in this number of observations is left out for the held-out check; 0: there is none.
  int held_out_every = 5;
};

/// What a machine builder asks of a table, from the map; means over its rectangle.
///
///   x error = scale_x x + ...          y error = scale_y y + ...          (1)
///   squareness: the angle between the axes is 90 degrees minus this       (rad)
///
/// Straightness and linearity are Legendre's polynomials of degree 2 and 3 along the axis, each by
/// its value at the axis' high end.
struct TableGeometry {
  enum Index {
    ScaleX,
    ScaleY,
    Squareness,
    LinearityX2,  ///< x error along x, mm
    LinearityX3,
    LinearityY2,  ///< y error along y
    LinearityY3,
    StraightnessX2,  ///< y error along x
    StraightnessX3,
    StraightnessY2,  ///< x error along y
    StraightnessY3,
  };
  static constexpr int kSize = 11;
  Eigen::Matrix<double, kSize, 1> value = Eigen::Matrix<double, kSize, 1>::Zero();
  Eigen::Matrix<double, kSize, kSize> cov = Eigen::Matrix<double, kSize, kSize>::Zero();
  static std::string_view name(Index index);
};

/// A fitted table, and what the data say about it.
struct TableFit {
  TableMap map;
  Eigen::MatrixXd covariance;  ///< of the map's coefficients, x and y by turns, mm^2
  TableGeometry geometry;
  /// Errors that these data cannot show, in words; the map has none of them. Where the table lies
  /// and how it is turned is convention and not among them: no shift, x axis straight along x.
  std::vector<std::string> undetermined;
  std::vector<PlatePose> poses;
  std::vector<Displacement<frame::Plate>> dot_errors;  ///< of places as given; 0 if certified
  std::vector<Displacement<frame::Table>> residuals;   ///< as TableData::seen
  double chi_square = 0;
  double parameters = 0;  ///< effective number: d fitted / d seen, summed
  /// What chi square is to be compared with if the warp has no detail that was smoothed away: the
  /// number of residuals less the trace of 2 H - H^2, H being d fitted / d seen. If it has, of the
  /// size that the smoothing stands for, the number less `parameters`, which is more.
  double degrees_of_freedom = 0;
  double smoothing = 0;  ///< weight of the bending energy, 1/mm^2
  double rms_mm = 0;     ///< of the residuals' lengths
  std::optional<double>
      held_out_rms_mm;  ///< the same of observations that a second fit did not see
  std::size_t n_held_out = 0;

  /// Of the map's error at a place, mm^2.
  Eigen::Matrix2d covariance_at(const Position<frame::Machine>& commanded) const;
  std::string summary() const;  ///< one line
};

/// The grid that a fit of all the data has: the options' own, or the rectangle of commanded places.
///
/// Fails  calibration-data (data or options that fit_table refuses; all looks from one line)
Expected<TableGrid> table_grid(const TableData& data, const TableFitOptions& options);

/// Fits the map of a table from looks at a plate.
///
///   c_i + E(c_i) + seen_ij = R(angle_k) (dot_j + error_j) + shift_k + e_ij
///
/// view i from commanded place c_i, dot j, pose k. Unknown are the table's error E (TableMap), the
/// poses, and the errors of dots that are not certified. Everything is linear but the angles, so
/// the normal equations are solved directly, dots and poses eliminated, twice.
///
/// E is as smooth as the data ask for: the energy of a thin plate is weighted by the restricted
/// likelihood (REML), a Gaussian process to which affine errors are free. Its covariance is the
/// posterior's and so counts what lies between the looks.
///
/// Self-calibration: with no dot certified and one plate in three poses, as it is, turned by 90
/// degrees, and shifted by a dot, table and plate separate all but the scale (Raugh 1985; Ye et al.
/// 1997). What the poses at hand leave open is read from the information on polynomial errors up to
/// the third degree after plate and poses are eliminated, and named; errors that repeat with the
/// shift are beyond polynomials and left to the smoothness.
///
/// In     seen: mm from the axis, covariance mm^2
/// Out    map, covariance, geometry, residuals, held-out check
/// Fails  calibration-data (an index out of range, a number that is not finite, a covariance that
///        is not positive definite; too few observations; nothing about the table determined)
/// Cost   15 x 15 looks, 10 steps: 0.3 s; grows with the sixth power of the steps
/// Source Wahba 1990; Harville 1974 (REML); Raugh 1985; Ye, Takac, Berglund, Owen, Pease 1997
/// See    tests/calib/table/fit_test.cc, tests/calib/table/self_calibration_test.cc
Expected<TableFit> fit_table(const TableData& data, const TableFitOptions& options);

}  // namespace panelcal
