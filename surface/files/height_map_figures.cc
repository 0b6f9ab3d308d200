// SPDX-License-Identifier: Apache-2.0
#include "surface/files/height_map_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Heights are rounded to three digits. The firmware computes in single precision, and the
/// deviation from a difference of squares.
constexpr double kHeightRounding = 0.001;
constexpr double kDeviationRounding = 0.003;

/// Half a unit of a number's last printed digit.
double rounding_of(std::string_view number) {
  const std::size_t point = number.find('.');
  const std::size_t n_digits = point == std::string_view::npos ? 0 : number.size() - point - 1;
  return 0.5 * std::pow(10.0, -static_cast<double>(n_digits));
}

}  // namespace

HeightFigures HeightFigures::of(std::span<const double> heights) {
  HeightFigures out{heights.front(), heights.front()};
  for (const double height : heights) {
    out.least = std::min(out.least, height);
    out.greatest = std::max(out.greatest, height);
    out.mean += height;
  }
  const auto n = static_cast<double>(heights.size());
  out.mean /= n;
  double squares = 0;
  for (const double height : heights) squares += (height - out.mean) * (height - out.mean);
  out.deviation = std::sqrt(squares / n);
  return out;
}

Expected<void> check_figures(const std::string& file,
                             const TextField& line,
                             std::span<const double> heights) {
  if (heights.empty()) return {};
  const HeightFigures right = HeightFigures::of(heights);
  const std::array<std::pair<std::string_view, double>, 5> known = {
      {{"min error ", right.least},
       {"max error ", right.greatest},
       {"mean error ", right.mean},
       {"mean ", right.mean},
       {"deviation ", right.deviation}}};
  for (const TextField& cell : cells_of(line)) {
    const auto found = std::ranges::find_if(
        known, [&](const auto& figure) { return cell.text.starts_with(figure.first); });
    if (found == known.end()) continue;
    TextField number = cell;
    number.text.remove_prefix(found->first.size());
    number.column += static_cast<int>(found->first.size());
    PANELCAL_TRY(const double value, number_of(file, number));
    const bool is_deviation = found->first == known.back().first;
    const double tolerance =
        rounding_of(number.text) + (is_deviation ? kDeviationRounding : kHeightRounding);
    if (std::abs(value - found->second) <= tolerance) continue;
    return failure({Code::MeasurementFile,
                    {file, cell.line, cell.column},
                    quoted(cell.text),
                    fmt::format("{:.3f}, of the heights below; if they were changed on purpose, "
                                "take the figures out",
                                found->second)});
  }
  return {};
}

}  // namespace panelcal::internal
