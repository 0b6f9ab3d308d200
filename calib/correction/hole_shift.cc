// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/hole_shift.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr double kShortest_mm = 1e-9;
constexpr double kLongest_mm = 1e6;
/// A bin stands for the geometric mean of its ends, so its width may be twice the error.
const double kLogWidth = 2 * std::log1p(HoleShiftStatistics::kHistogramRelativeError);
/// 95 % as a whole number, so that no rounding moves a rank.
constexpr std::size_t kPercent = 95;

std::size_t n_bins() {
  return static_cast<std::size_t>(std::ceil(std::log(kLongest_mm / kShortest_mm) / kLogWidth)) + 2;
}

/// Bin 0 holds what is shorter than the shortest.
std::size_t bin_of(double length_mm) {
  if (length_mm < kShortest_mm) return 0;
  return 1 + static_cast<std::size_t>(std::log(length_mm / kShortest_mm) / kLogWidth);
}

double middle_mm(std::size_t i_bin) {
  if (i_bin == 0) return 0;
  return kShortest_mm * std::exp((static_cast<double>(i_bin) - 0.5) * kLogWidth);
}

}  // namespace

HoleShift shift_between(const SpindleCameraOffset& before, const SpindleCameraOffset& after) {
  const Displacement<frame::Machine> change = after.offset - before.offset;
  const auto shift = displacement_mm<frame::Actual>(change.in_mm());
  return [shift](const Position<frame::Nominal>&) { return shift; };
}

HoleShift shift_between(const CorrectionStack& before, const CorrectionStack& after) {
  const auto from = before.actual_from_nominal().map;
  const auto to = after.actual_from_nominal().map;
  return [from, to](const Position<frame::Nominal>& hole) { return to(hole) - from(hole); };
}

HoleShiftStatistics::HoleShiftStatistics(std::size_t max_exact) : max_exact_(max_exact) {
}

Expected<void> HoleShiftStatistics::add(const Position<frame::Nominal>& hole,
                                        const Displacement<frame::Actual>& shift) {
  const double length_mm = shift.in_mm().norm();
  if (!(length_mm <= kLongest_mm)) {
    return failure({Code::CalibrationInvalid,
                    {},
                    fmt::format("the hole at ({}, {}) mm would move by ({}, {}) mm",
                                hole.in_mm().x(),
                                hole.in_mm().y(),
                                shift.in_mm().x(),
                                shift.in_mm().y()),
                    "a finite shift below 1 km"});
  }
  if (length_mm > max_mm_) {
    max_mm_ = length_mm;
    worst_hole_ = hole;
    worst_shift_ = shift;
  }
  sum_mm_ += length_mm;
  sum_mm2_ += length_mm * length_mm;
  sum_ = sum_ + shift;
  ++n_;
  count(length_mm);
  return {};
}

void HoleShiftStatistics::count(double length_mm) {
  if (bins_.empty() && lengths_mm_.size() < max_exact_) {
    lengths_mm_.push_back(length_mm);
    return;
  }
  if (bins_.empty()) {
    bins_.resize(n_bins());
    for (const double kept_mm : lengths_mm_) ++bins_[bin_of(kept_mm)];
    lengths_mm_ = {};
  }
  ++bins_[bin_of(length_mm)];
}

double HoleShiftStatistics::quantile_mm(std::size_t rank) const {
  if (bins_.empty()) {
    std::vector<double> sorted_mm = lengths_mm_;
    const auto at = sorted_mm.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(sorted_mm.begin(), at, sorted_mm.end());
    return *at;
  }
  std::size_t n_below = 0;
  std::size_t i = 0;
  while (n_below + bins_[i] < rank) n_below += bins_[i++];
  return std::min(middle_mm(i), max_mm_);
}

std::optional<HoleShiftSummary> HoleShiftStatistics::summary() const {
  if (n_ == 0) return std::nullopt;
  const auto n = static_cast<double>(n_);
  HoleShiftSummary s;
  s.n_holes = n_;
  s.max = mm(max_mm_);
  s.worst_hole = worst_hole_;
  s.worst_shift = worst_shift_;
  // The least rank of which 95 % of the holes are not above: 0.95 n, rounded up.
  s.p95 = mm(quantile_mm((n_ * kPercent + 99) / 100));
  s.p95_relative_error = bins_.empty() ? 0 : kHistogramRelativeError;
  s.mean = mm(sum_mm_ / n);
  s.rms = mm(std::sqrt(sum_mm2_ / n));
  s.mean_shift = (1 / n) * sum_;
  return s;
}

}  // namespace panelcal
