// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "calib/base/machine_uncertainty.h"
#include "calib/panel/fit.h"

namespace panelcal::test {

/// Simulated jobs of one kind, for asking whether predicted covariances are the real ones.
///
/// Every job is a part program of its own: 3 to 6 fiducials at random on a panel of 300 x 250 mm,
/// 12 holes within and 60 mm around it. It is surveyed and executed like any other. The panel moved
/// as `model` says; pixels, camera calibration, spindle-camera offset with its drift, stage, table
/// and drill err as MachineUncertainty says, the shared ones once for a job. The camera's error is
/// that of a mapping with other parameters, not of a derivative.
struct HonestyTrial {
  PanelModel model = PanelModel::Rigid;
  double detector_um = 3;  ///< sigma of the detector, up to twice and down to a tenth of it by axis
  bool has_nested = false;  ///< holes on a board of 60 x 50 mm that moved by itself, 3 to 5 targets
  int n_jobs = 400;
  std::uint64_t seed = 1;
  /// True if panelcal is told of another machine than that from which errors are drawn.
  bool hides_machine = false;
};

/// Machine from which errors are drawn.
MachineUncertainty trial_machine();

/// A share of holes, with the standard deviation that jobs leave it: holes of one job err together.
struct Coverage {
  double share = 0;
  double sigma = 0;
  std::int64_t n_holes = 0;
};

struct HonestyResult {
  Coverage all;           ///< holes inside their 95 % ellipse
  Coverage outside;       ///< of those outside the hull of the fiducials
  double chi_square = 0;  ///< of all fits, and their degrees of freedom
  std::int64_t degrees_of_freedom = 0;
  double mean_sigma_um = 0;  ///< predicted, largest direction
  int n_failed = 0;          ///< jobs without a result
};

HonestyResult run(const HonestyTrial& trial);

}  // namespace panelcal::test
