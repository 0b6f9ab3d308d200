// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/faults/finder.h"

namespace panelcal::test {

/// Fault of a simulated job. "Seen": every target is seen itself, wherever it is. "Taken": the
/// camera takes the pad nearest to where it looks, within 3 mm.
enum class SimulatedFault : std::uint8_t {
  Healthy,
  WrongPad,     ///< one target is a pad 0.5 to 6 mm away
  Damaged,      ///< one is off by `size_mm` in any direction
  OutOfFocus,   ///< the same with 2.5 to 6 times the sigma and a score of 0.3 to 0.6
  QuarterSeen,  ///< about the panel's middle, to within 1 mm
  HalfSeen,
  MirroredSeen,
  ScaleSeen,  ///< 25.4, 10, 100 or the inverse of one
  QuarterTaken,
  HalfTaken,
  MirroredTaken,
  ScaleTaken,  ///< 25.4 or 10: of panels larger than programmed
  Revision,    ///< two, three or all targets are elsewhere by 0.5 to 5 mm each
};

std::string_view name(SimulatedFault fault);
/// Cause that the finder is to report; of Healthy nothing.
FaultCause cause_of(SimulatedFault fault);

struct FaultSettings {
  PanelModel model = PanelModel::Stretch;
  int n_targets = 4;
  double least_size_mm = 0.5;  ///< of Damaged and OutOfFocus, logarithmically uniform
  double greatest_size_mm = 3;
  GateLimits limits;
  bool has_pads = true;  ///< beside the fiducials
};

/// Limits as in many machine files: 2 mm, 10 mrad, 500 ppm; accusing one healthy series in 1000.
FaultSettings usual_settings();

/// A panel of 300 x 300 mm with a fiducial in each corner region (displaced by up to 40 mm, so that
/// it is not symmetric), or further ones anywhere, and pads on a third of it, one to a square of 1
/// to 5 mm and anywhere in it; work zero is anywhere on it. It lies off by a third of the limits
/// (one standard deviation), and is measured with errors of 2 to 10 um, their covariances known.
struct SimulatedJob {
  PanelModel model = PanelModel::Stretch;
  GateLimits limits;
  std::vector<internal::ExaminedTarget> targets;
  std::vector<KnownPad> pads;
  FaultCause cause = FaultCause::Unexplained;
  std::optional<std::size_t> i_outlier;
  std::string telling;  ///< words that tell the right cause from others of its kind; may be empty

  /// A gate refuses the fit, or it is mirrored.
  bool is_refused() const;
  std::optional<SeriesFault> examine() const;
};

/// Nothing if the fault cannot happen to the panel that was drawn (no pad where the camera looks).
std::optional<SimulatedJob> draw_job(Random& random,
                                     SimulatedFault fault,
                                     const FaultSettings& settings);

/// Answer of the finder about a job with a fault.
enum class Finding : std::uint8_t {
  /// The right target; where no single one lies, the right cause by itself, with its side or
  /// factor.
  Named,
  Listed,  ///< the data cannot tell, and the right one is among the suspicions
  Wrong,
  Missed,  ///< nothing was said
};
Finding finding_of(const SimulatedJob& job, const std::optional<SeriesFault>& fault);

}  // namespace panelcal::test
