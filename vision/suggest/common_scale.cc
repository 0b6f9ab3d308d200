// SPDX-License-Identifier: Apache-2.0
#include "vision/suggest/common_scale.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::size_t kMinSeen = 3;
/// Etching moves rims by that much.
constexpr double kMinDeviation = 0.01;
/// Sizes agree if the middle two thirds differ by less than this part of their deviation.
constexpr double kMaxSpread = 0.25;

double quantile(const std::vector<double>& sorted, double part) {
  return sorted[static_cast<std::size_t>(
      std::lround(part * static_cast<double>(sorted.size() - 1)))];
}

}  // namespace

void CommonScale::add(const Detection& detection) {
  if (detection.size_ratio) ratios_.push_back(*detection.size_ratio);
}

std::optional<std::string> CommonScale::problem() const {
  if (ratios_.size() < kMinSeen) return std::nullopt;
  std::vector<double> sorted = ratios_;
  std::ranges::sort(sorted);
  const double deviation = quantile(sorted, 0.5) - 1;
  const double spread = (quantile(sorted, 5.0 / 6) - quantile(sorted, 1.0 / 6)) / 2;
  const bool is_common =
      std::abs(deviation) >= kMinDeviation && spread <= kMaxSpread * std::abs(deviation);
  if (!is_common) return std::nullopt;
  return fmt::format("all {} targets measure {:.1f} % {} than stated (they differ by {:.1f} %)",
                     sorted.size(),
                     100 * std::abs(deviation),
                     deviation > 0 ? "larger" : "smaller",
                     100 * spread);
}

std::optional<std::string> CommonScale::words() const {
  std::optional<std::string> out = problem();
  if (out) *out += ": the vision tool's size or the camera's scale is wrong";
  return out;
}

std::optional<Diagnostic> CommonScale::warning(const std::string& machine) const {
  const std::optional<std::string> what = problem();
  if (!what) return std::nullopt;
  Diagnostic out;
  out.code = Code::ScaleSuspicious;
  out.place.file = machine;
  out.what = *what;
  out.expected = "the size of the vision tool and the scale of the camera as they are";
  return out;
}

}  // namespace panelcal
