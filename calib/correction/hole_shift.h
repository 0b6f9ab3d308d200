// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/correction/spindle_camera.h"
#include "calib/correction/stack.h"

namespace panelcal {

/// By how much a hole moves if one calibration takes the place of another; after minus before.
using HoleShift = std::function<Displacement<frame::Actual>(const Position<frame::Nominal>&)>;

/// Between two spindle-camera offsets. A target is measured at (axis + offset + what is seen), so a
/// change of the offset moves every measured place, and with it every corrected hole, by itself.
/// Actual lies in the machine's directions; the distance of their origins drops out.
HoleShift shift_between(const SpindleCameraOffset& before, const SpindleCameraOffset& after);

/// Between two corrections of one panel, each measured or worked out with its own calibrations.
HoleShift shift_between(const CorrectionStack& before, const CorrectionStack& after);

/// The effect of a change of calibration on a job.
struct HoleShiftSummary {
  std::size_t n_holes = 0;
  Length max;                           ///< the longest shift
  Position<frame::Nominal> worst_hole;  ///< the first hole that has it
  Displacement<frame::Actual> worst_shift;
  Length p95;  ///< 95 % of the holes (at least) move by no more than this: nearest rank
  /// Greatest relative error of p95: 0 up to kMaxExactHoles.
  double p95_relative_error = 0;
  Length mean;  ///< of the lengths
  Length rms;
  Displacement<frame::Actual> mean_shift;  ///< a change of work zero alone would undo it
};

/// Gathers the shifts of a stream of holes.
///
/// Up to kMaxExactHoles lengths are kept and the quantile is exact. From then on a histogram takes
/// them, whose bins grow by a constant factor, so that the quantile's relative error is bounded for
/// shifts from 1 pm to 1 km; shorter ones count as none, and longer ones are refused.
///
/// Cost   O(1) a hole; 8 MB at most
/// See    tests/calib/correction/hole_shift_test.cc
class HoleShiftStatistics {
 public:
  static constexpr std::size_t kMaxExactHoles = 1000000;
  static constexpr double kHistogramRelativeError = 5e-4;

  /// `max_exact` is for tests.
  explicit HoleShiftStatistics(std::size_t max_exact = kMaxExactHoles);

  /// Fails  calibration-invalid (the shift is not finite, or above 1 km): such a hole cannot be
  ///        left out of a statement about all holes
  Expected<void> add(const Position<frame::Nominal>& hole,
                     const Displacement<frame::Actual>& shift);
  /// Empty without holes.
  std::optional<HoleShiftSummary> summary() const;

 private:
  void count(double length_mm);
  double quantile_mm(std::size_t rank) const;

  std::size_t max_exact_;
  std::vector<double> lengths_mm_;
  std::vector<std::uint64_t> bins_;
  std::size_t n_ = 0;
  double max_mm_ = -1;
  Position<frame::Nominal> worst_hole_;
  Displacement<frame::Actual> worst_shift_;
  double sum_mm_ = 0;
  double sum_mm2_ = 0;
  Displacement<frame::Actual> sum_;
};

}  // namespace panelcal
