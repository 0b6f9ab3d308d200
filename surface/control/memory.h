// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "surface/control/reference_plane.h"
#include <tl/expected.hpp>

namespace panelcal {

/// Kind of average by which G74 makes one value of many: SPAV,A, SPAV,M, SPAV,O and SPAV,T.
enum class AverageKind : std::uint8_t {
  Mean,         ///< A: of all values
  Median,       ///< M: the middle value, or the mean of the two in the middle
  MidRange,     ///< O: the mean of the smallest and the greatest
  TrimmedMean,  ///< T: of all but the smallest and the greatest
};

/// The probed heights of one work station: values `L n` and the area where values to be averaged
/// gather.
///
/// Every value has one height per Z axis, the first axis first. The first value to come says how
/// many Z axes there are, from then on and for all values. Failures are texts that say what was
/// expected; a call that fails changes nothing.
///
/// Source SIEB & MEYER CNC 8x.00, G72, G73, G74 and L; semantics page, Surface
/// See    tests/surface/control/memory_test.cc
class SurfaceMemory {
 public:
  /// The capacity of the averaging area, G73.
  static constexpr std::size_t kAveragingCapacity = 100;

  /// G73Ln and G74Ln: an older value `L n` is replaced.
  ///
  /// Fails  n < 0; no heights, or another number of Z axes than before; a height or a sigma that is
  ///        not finite; a sigma below 0
  tl::expected<void, std::string> store(int n, std::vector<HeightEstimate> heights);

  /// `L n` in a line of its own.
  ///
  /// Fails  nothing was stored there
  tl::expected<std::vector<HeightEstimate>, std::string> load(int n) const;

  /// G72: forgets all values `L n`. The averaging area stays as it is.
  void clear() { by_number_.clear(); }
  /// A program begins: forgets everything, the averaging area too.
  void reset() { *this = SurfaceMemory(); }

  /// G73 without L: one more value to be averaged.
  ///
  /// Fails  the area is full; otherwise as store()
  tl::expected<void, std::string> add(std::vector<HeightEstimate> heights);
  std::size_t n_to_average() const { return to_average_.size(); }

  /// G74: the average of each Z axis for itself; the averaging area is empty afterwards.
  ///
  /// Sigmas are propagated through the values that enter the result, as independent errors: exact
  /// for the mean. Median, mid-range and trimmed mean choose their values by size, which the
  /// propagation does not see: it is right where the heights differ by more than their sigmas, and
  /// too large where one and the same height was measured several times.
  ///
  /// Fails  nothing to average; fewer than three values for a trimmed mean
  tl::expected<std::vector<HeightEstimate>, std::string> take_average(AverageKind kind);

 private:
  tl::expected<void, std::string> check(std::span<const HeightEstimate> heights) const;

  std::size_t n_axes_ = 0;  // 0: not known yet
  std::map<int, std::vector<HeightEstimate>> by_number_;
  std::vector<std::vector<HeightEstimate>> to_average_;
};

}  // namespace panelcal
