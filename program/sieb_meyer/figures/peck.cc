// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/figures/peck.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include "program/sieb_meyer/figures/refusal.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

constexpr std::size_t kMaxStrokes = 100000;
constexpr double kNoise_um = 1e-6;  // what subtracted and converted lengths may be off

tl::unexpected<std::string> too_many_strokes() {
  return refusal(fmt::format("too many partial strokes; expected at most {}", kMaxStrokes));
}

std::optional<std::string> peck_fault(double distance_mm, double stroke_mm, double third) {
  if (!all_finite({distance_mm, stroke_mm, third})) {
    return "a number is not finite; expected lengths in mm and a factor";
  }
  if (distance_mm < 0) {
    return fmt::format(
        "the lowering value is {:.6g} mm below the target plane; expected at or above it",
        -distance_mm);
  }
  if (!(stroke_mm > 0)) {
    return fmt::format("the partial stroke is {:.6g} mm; expected above 0", stroke_mm);
  }
  return std::nullopt;
}

}  // namespace

tl::expected<PeckStrokes, std::string> peck_strokes(double distance_mm,
                                                    double first_stroke_mm,
                                                    double factor_permille) {
  if (const auto fault = peck_fault(distance_mm, first_stroke_mm, factor_permille)) {
    return refusal(*fault);
  }
  if (factor_permille < 0 || factor_permille > 1000) {
    return refusal(
        fmt::format("the peck drill factor W is {:.6g}; expected 0 to 1000", factor_permille));
  }
  PeckStrokes out;
  double remaining_um = 1000 * distance_mm;
  while (remaining_um > kNoise_um) {
    const double exponent = static_cast<double>(out.strokes_mm.size());
    const double full_um = 1000 * first_stroke_mm * std::pow(0.001 * factor_permille, exponent);
    const double stroke_um = std::floor(full_um + kNoise_um);
    if (stroke_um < 1) break;
    if (out.strokes_mm.size() == kMaxStrokes) return too_many_strokes();
    if (stroke_um >= remaining_um) {
      out.strokes_mm.push_back(0.001 * remaining_um);
      remaining_um = 0;
    } else {
      out.strokes_mm.push_back(0.001 * stroke_um);
      remaining_um -= stroke_um;
    }
  }
  out.reaches_target = remaining_um <= kNoise_um;
  out.remaining_mm = out.reaches_target ? 0 : 0.001 * remaining_um;
  return out;
}

}  // namespace panelcal::sieb_meyer
