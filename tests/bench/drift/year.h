// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "calib/base/statistics/random.h"
#include "calib/charts/spread_monitor.h"
#include "calib/drift/series.h"

namespace panelcal::bench {

/// What a night's calibration tells: an offset, the scatter of its holes, the contrast of pictures.
enum class Channel : std::uint8_t { Offset, Scatter, Contrast };

enum class FaultShape : std::uint8_t {
  None,
  Step,   ///< by `size` from a night on; of a scatter to `size` times, of a contrast by a share
  Ramp,   ///< by `size` a day; a scatter by this share of it, a contrast ever faster
  Wild,   ///< `size` in one night only
  Loose,  ///< of every night anew, a standard deviation of `size` that no covariance states
  Temperature,  ///< the hall is warmer by `size` kelvin, and the offset follows it
};

/// Sizes in um, K, times.
struct Fault {
  std::string_view name;
  Channel channel = Channel::Offset;
  FaultShape shape = FaultShape::None;
  double size = 0;
};

inline constexpr int kNightsOfAYear = 365;

/// A machine of its own: drift, scatter and change with temperature are drawn for each year.
class Year {
 public:
  Year(std::uint64_t seed, double season_kelvin);

  struct Night {
    DriftPoint offset;    ///< mm
    SpreadPoint scatter;  ///< 16 degrees of freedom, mm^2
    DriftPoint contrast;  ///< logarithm
  };

  /// Night `i` with a fault that began with night `onset`. The same errors with every fault.
  ///
  /// Precondition: nights in their order, the healthy ones first
  Night night(int i, const Fault& fault, int onset);

  /// True where a fault of this age, 1 for its first night, has moved an offset by more than 10 um,
  /// doubled a scatter or halved a contrast; of those that never do, after 30 nights.
  static bool is_broken(const Fault& fault, int age);

 private:
  Random seed_;
  double season_kelvin_;
  double drift_um_;
  double repeatability_um_;
  double um_per_kelvin_;
  double turn_rad_;
  std::array<Eigen::Vector2d, kNightsOfAYear> walk_um_;
  std::array<double, kNightsOfAYear> walk_of_contrast_{};
};

}  // namespace panelcal::bench
