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
#include "calib/table/fit_input.h"
#include "calib/table/geometry.h"
#include <Eigen/Core>

namespace panelcal {

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
  /// The reference for chi square if the warp has no detail that was smoothed away: the
  /// number of residuals less the trace of 2 H - H^2, H being d fitted / d seen. If it has, of the
  /// size that the smoothing stands for, the number less `parameters`, which is more.
  double degrees_of_freedom = 0;
  TableSmoothness smoothness;
  double rms_mm = 0;  ///< of the residuals' lengths
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
/// E is as smooth as the data ask for: a Gaussian process to which affine errors are free, whose
/// kind, length and weight are those of the greatest restricted likelihood (REML); other kinds than
/// a thin plate only where places of the table are looked at again, which tells scatter from short
/// waves. Its covariance is the posterior's and so counts what lies between the looks.
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
/// Cost   15 x 15 looks, 10 steps: 0.3 s, more where several processes are tried; grows with the
///        sixth power of the steps
/// Source Wahba 1990; Harville 1974 (REML); Raugh 1985; Ye, Takac, Berglund, Owen, Pease 1997
/// See    tests/calib/table/fit_test.cc, tests/calib/table/self_calibration_test.cc
Expected<TableFit> fit_table(const TableData& data, const TableFitOptions& options);

}  // namespace panelcal
