// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/correction/table_map.h"

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

/// The Gaussian process that a table's error is taken for, but for what is linear in the place.
enum class TableProcess : std::uint8_t {
  ThinPlate,  ///< of a plate's bending energy: waves of every length
  Matern,     ///< Matern's covariance, 5/2: bent everywhere, without a jump
};

struct TableSmoothness {
  TableProcess process = TableProcess::ThinPlate;
  double length = 0;  ///< of the covariance, in longer sides of the grid; a thin plate has none
  double weight = 0;  ///< of the energies of its waves (waves.h), 1/mm^2
};

struct TableFitOptions {
  /// Of the grid along its longer side. More follow a rougher warp and cost the cube; what the
  /// data do not ask for is smoothed away in any case.
  int steps = 10;
  /// The grid; by default the rectangle of commanded places.
  std::optional<TableGrid> grid;
  /// A polynomial error whose mean size is known no better than this counts as undetermined: a map
  /// with it would be worse than none.
  Length open_sigma = mm(0.01);
  /// One in this number of observations is left out for the held-out check; 0: there is none.
  int held_out_every = 5;
};

}  // namespace panelcal
