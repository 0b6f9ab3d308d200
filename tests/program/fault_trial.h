// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "calib/base/units.h"

namespace panelcal::test {

/// The faults of a job. The panel's own faults are true of its holes as well.
enum class JobFault : std::uint8_t {
  Moved,            ///< a target is seen 3 um to 3 mm beside its place
  Swapped,          ///< two targets are taken for each other
  Mirrored,         ///< the panel lies with its other side up
  Scaled,           ///< the panel is larger or smaller by 1e-4 to 0.1, or 25.4 times
  Turned,           ///< the panel lies turned by quarters, or by 1 mrad to half a turn
  WrongPad,         ///< a target is a pad 0.5 to 6 mm away
  WrongCovariance,  ///< noise is 2 to 10 times the stated one, or a part of it
  Warped,           ///< the panel is bent by 40 um: in no random job, only where it is asked for
};
inline constexpr int kRandomFaults = 7;
std::string_view name(JobFault fault);

/// Simulated jobs under default gates, with a tolerance of 10 to 100 um, a machine whose terms are
/// stated, and 20 holes on a panel of 300 x 250 mm. Every job is a part program of its own that is
/// surveyed, executed and judged like any other.
struct FaultTrial {
  int n_jobs = 400;
  std::uint64_t seed = 1;
  int n_faults_most = 0;         ///< 1 to so many faults of random kind a job; 0: healthy jobs
  std::optional<JobFault> only;  ///< one fault, of this kind
  std::optional<double> noise_factor;  ///< true noise over the stated one; no other fault
  int n_targets_least = 4;             ///< of the model that the manual prescribes for the number
  int n_targets_most = 12;
  double nested_share = 0.3;  ///< of jobs with a board of 4 to 6 targets on the panel
};

struct FaultTrialResult {
  int n_jobs = 0;
  int n_gated = 0;             ///< held by gates or chi square, or without a fit
  int n_held = 0;              ///< by the tolerance, those that gates let pass
  int n_released = 0;          ///< all others
  int n_sure = 0;              ///< released with a stated risk below 1e-3 at every hole
  int n_broken = 0;            ///< released with a hole out of tolerance
  int n_broken_sure = 0;       ///< the same, where the stated risk is below 1e-3 at every hole
  double least_told = 1;       ///< smallest of the jobs' largest stated risks
  double least_hole_told = 1;  ///< smallest stated risk of any hole
  std::int64_t n_holes = 0;    ///< of all jobs that could be executed, held or not
  std::int64_t n_in_ellipse = 0;
  std::vector<std::uint64_t> broken_sure;  ///< numbers of those jobs

  double coverage() const {
    return n_holes == 0 ? 0 : static_cast<double>(n_in_ellipse) / static_cast<double>(n_holes);
  }
};

FaultTrialResult run(const FaultTrial& trial);

}  // namespace panelcal::test
