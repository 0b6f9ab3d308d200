// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "surface/fit/area.h"

namespace panelcal {

/// Area in which a probe does not touch the panel's surface: a hole, a rout, a clamp, beyond the
/// edge.
struct Void {
  Area area;
  std::string name;  ///< for messages: `hole of tool 3`
  Place from;        ///< place of the reading in a file, for messages
};

/// `"hole of tool 3" (panel.exc:40)`
std::string text_of(const Void& hole);

/// Many voids, and which of them holds a place.
class Voids {
 public:
  Voids() = default;
  /// In     margin: how near to a void no probe is believed, the radius of its tip for instance
  /// Fails  config-value: as check_area(); a margin below 0 or above 1000 mm; polygons of more than
  ///        10,000 corners together
  /// Cost   O(n); a second for 500,000 holes
  static Expected<Voids> make(std::vector<Void> all, Length margin = mm(0));

  /// The first one, in the order given, that holds the place; nullptr if none does.
  ///
  /// Cost   of the voids about the place, and of those that are as large as a good part of all
  const Void* at(const Position<frame::Nominal>& place) const;
  /// The first one that holds the place or is nearer to it than the margin: a probe there may have
  /// touched it.
  const Void* touched_at(const Position<frame::Nominal>& place) const;
  std::span<const Void> all() const { return all_; }
  Length margin() const { return margin_; }

 private:
  /// Of a bin, by row and column, -1 outside.
  std::ptrdiff_t bin_of(const Eigen::Vector2d& p_mm) const;
  std::vector<std::size_t> bins_of(std::size_t i_void, const AreaBox& box) const;
  const Void* first_within(const Position<frame::Nominal>& place, Length margin) const;

  std::vector<Void> all_;
  Length margin_;
  Eigen::Vector2d low_mm_ = Eigen::Vector2d::Zero();
  double bin_mm_ = 1;
  std::ptrdiff_t n_columns_ = 0, n_rows_ = 0;
  std::vector<std::vector<std::size_t>> bins_;  ///< indices, rising
  std::vector<std::size_t> large_;              ///< of too many bins to be in each
};

}  // namespace panelcal
