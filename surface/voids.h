// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "panelcal/calib/base/diagnostic.h"
#include "panelcal/calib/base/expected.h"
#include "panelcal/surface/area.h"

namespace panelcal {

/// Where a probe does not touch the panel's surface: a hole, a rout, a clamp, beyond the edge.
struct Void {
  Area area;
  std::string name;  ///< for messages: `hole of tool 3, line 40`
  Place from;        ///< where it was read, for messages
};

/// Many voids, and which of them holds a place.
class Voids {
 public:
  Voids() = default;
  /// In     margin: how near to a void the surface is not believed either, the radius of the
  ///        probe's tip for instance
  /// Fails  config-value: as check_area(); a margin below 0 or above 1000 mm
  static Expected<Voids> make(std::vector<Void> all, Length margin = mm(0));

  /// The first one, in the order given, that holds the place or is nearer to it than the margin;
  /// nullptr if none does.
  ///
  /// Cost   of the voids about the place, and of those that are as large as a good part of all
  const Void* at(const Position<frame::Nominal>& place) const;
  std::span<const Void> all() const { return all_; }

 private:
  /// Of a bin, by row and column, -1 outside.
  std::ptrdiff_t bin_of(const Eigen::Vector2d& p_mm) const;

  std::vector<Void> all_;
  Length margin_;
  Eigen::Vector2d low_mm_ = Eigen::Vector2d::Zero();
  double bin_mm_ = 1;
  std::ptrdiff_t n_columns_ = 0, n_rows_ = 0;
  std::vector<std::vector<std::size_t>> bins_;  ///< indices, rising
  std::vector<std::size_t> large_;              ///< of too many bins to be in each
};

}  // namespace panelcal
