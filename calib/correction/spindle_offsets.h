// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>

#include "calib/base/frames.h"
#include "calib/correction/spindle_camera.h"
#include <Eigen/Core>

namespace panelcal {

/// A spindle, and the work station at which it drills; both count from 1.
struct SpindleAt {
  int spindle = 1;
  int station = 1;
  friend auto operator<=>(const SpindleAt&, const SpindleAt&) = default;
};

/// SIEB & MEYER: G39,SPOFs has 1 to 12 ("independent from the setting of the machine parameters").
inline constexpr int kMostSpindles = 12;
/// G39,SPOP1 and G39,SPOP2.
inline constexpr int kMostStations = 2;

/// The kinds of offset that G39,SPOP.. stores a measured deviation as.
struct OffsetOrder {
  enum class Of : std::uint8_t {
    Station,          ///< SPOP, SPOP1, SPOP2: every spindle at station `number`
    Spindle,          ///< SPOFs: spindle `number` at every station
    SpindleToSpindle  ///< SPISPI: every spindle but the first, at every station
  };
  Of of = Of::Station;
  int number = 1;
};

/// Place of one spindle's point as seen from another's.
struct SpindleDistance {
  Displacement<frame::Machine> distance;
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();
};

/// The spindle-camera offsets of a machine, one for each spindle at each station.
/// See    tests/calib/correction/spindle_offsets_test.cc
class SpindleOffsets {
 public:
  /// False, and nothing is changed, if there is no such spindle or station, or no such offset.
  bool set(SpindleAt at, const SpindleCameraOffset& offset);
  /// nullptr if it is not calibrated: the offset of another spindle is no substitute.
  const SpindleCameraOffset* find(SpindleAt at) const;
  bool empty() const { return offsets_.empty(); }
  const std::map<SpindleAt, SpindleCameraOffset>& all() const { return offsets_; }

  /// From the point under spindle `from` to that under spindle `to`, at one station.
  ///
  ///   q_to - q_from = d_from - d_to
  ///
  /// with the covariance of two offsets that were found from holes of their own. Both come with the
  /// same camera calibration, whose error is in neither (SpindleCameraFit::by_camera).
  /// Out    empty unless both are calibrated
  std::optional<SpindleDistance> between(int from, int to, int station) const;

  /// Takes a deviation as the new truth: a hole drilled at p and then measured at p + deviation
  /// tells that the camera stands elsewhere than was thought.
  ///
  ///   d_new = d - deviation,   covariance: that of the deviation (it replaces, it does not add)
  ///
  /// In     deviation: measured minus nominal, machine directions, measured with the offsets as
  ///        they are
  /// Out    how many offsets it moved; 0 and nothing changed if the order names no calibrated one
  ///        or the deviation is not finite
  /// Source SIEB & MEYER, G39: Organize Correction Values; docs: semantics
  int correct(const OffsetOrder& order,
              const Displacement<frame::Machine>& deviation,
              const Eigen::Matrix2d& cov_mm2);

 private:
  std::map<SpindleAt, SpindleCameraOffset> offsets_;
};

}  // namespace panelcal
