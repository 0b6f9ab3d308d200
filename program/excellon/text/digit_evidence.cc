// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/digit_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "program/excellon/text/number_census.h"
#include "program/excellon/text/stated_format.h"
#include "program/text/number_format.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

/// Enough to see how holes lie; the look at a program of millions stays short.
constexpr std::size_t kMostListedHoles = 5'000;
/// HoleSpread across the longest spread, as standard deviations: within a diameter a nibbled ring
/// of three diameters has 0.2, a row beside another one 0.5.
constexpr double kCrowdSpread = 0.35;
/// The same within this number of diameters, where a slot nibbled in two rows is a line again.
constexpr int kWideDiameters = 3;
/// Fewer crowded holes may be a pocket, or the corners of a nibbled contour.
constexpr int kManyCrowded = 20;
constexpr int kManyInLines = 3;
/// In the reading that explains the numbers the holes are apart, but for few.
constexpr double kFewShare = 0.1;
/// Without a travel of the machine; as where nothing states the format (format_choice.cc).
constexpr double kMostHoleSpread_mm = 1000;

using HoleCell = std::pair<std::int64_t, std::int64_t>;

struct HoleInCell {
  HoleCell cell;
  Eigen::Vector2d at_mm;
};

/// HoleSpread of places, as sums.
struct HoleSpread {
  int n = 0;
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares_mm2 = Eigen::Matrix2d::Zero();

  void add(const Eigen::Vector2d& offset_mm) {
    ++n;
    sum_mm += offset_mm;
    squares_mm2 += offset_mm * offset_mm.transpose();
  }

  /// Smaller over larger principal standard deviation.
  double breadth() const {
    const Eigen::Vector2d mean_mm = sum_mm / n;
    const Eigen::Matrix2d cov_mm2 = squares_mm2 / n - mean_mm * mean_mm.transpose();
    const double half_trace = (cov_mm2(0, 0) + cov_mm2(1, 1)) / 2;
    const double radius = std::hypot((cov_mm2(0, 0) - cov_mm2(1, 1)) / 2, cov_mm2(0, 1));
    return std::sqrt(std::max(0.0, half_trace - radius) / (half_trace + radius));
  }
};

HoleCell hole_cell_of(const Eigen::Vector2d& at_mm, double size_mm) {
  return {static_cast<std::int64_t>(std::floor(at_mm.x() / size_mm)),
          static_cast<std::int64_t>(std::floor(at_mm.y() / size_mm))};
}

/// Different places, sorted by cells of the diameter's size.
std::vector<HoleInCell> sorted_holes(std::span<const Eigen::Vector2d> places_mm,
                                     double diameter_mm) {
  std::vector<HoleInCell> out;
  out.reserve(places_mm.size());
  for (const Eigen::Vector2d& at_mm : places_mm) {
    out.push_back({hole_cell_of(at_mm, diameter_mm), at_mm});
  }
  const auto key = [](const HoleInCell& one) {
    return std::tuple(one.cell, one.at_mm.x(), one.at_mm.y());
  };
  std::ranges::sort(out, {}, key);
  const auto again = std::ranges::unique(out, {}, key);
  out.erase(again.begin(), again.end());
  return out;
}

/// The place and those nearer to it than a number of diameters, as offsets from it.
HoleSpread hole_spread_about(const HoleInCell& place,
                             const std::vector<HoleInCell>& places,
                             double diameter_mm,
                             int n_diameters) {
  // Holes that touch do not overlap, whatever rounding says.
  const double radius_mm = n_diameters * diameter_mm * (1 - 1e-9);
  HoleSpread spread;
  for (std::int64_t column = -n_diameters; column <= n_diameters; ++column) {
    const HoleCell first(place.cell.first + column, place.cell.second - n_diameters);
    const HoleCell last(first.first, place.cell.second + n_diameters);
    for (auto at = std::ranges::lower_bound(places, first, {}, &HoleInCell::cell);
         at != places.end() && at->cell <= last;
         ++at) {
      const Eigen::Vector2d offset_mm = at->at_mm - place.at_mm;
      if (offset_mm.norm() < radius_mm) spread.add(offset_mm);
    }
  }
  return spread;
}

/// The holes of a program in one format.
struct DigitLook {
  NumberFormat format;
  ListedHoles holes;
  std::vector<HoleOverlap> overlaps;  ///< of each tool

  double extent_mm(Eigen::Index axis, bool is_most) const {
    double found_mm = is_most ? -HUGE_VAL : HUGE_VAL;
    for (const ListedHoles::OfTool& tool : holes.tools) {
      for (const Eigen::Vector2d& at_mm : tool.at_mm) {
        found_mm = is_most ? std::max(found_mm, at_mm[axis]) : std::min(found_mm, at_mm[axis]);
      }
    }
    return found_mm;
  }

  bool fits(const std::optional<Eigen::Vector2d>& travel_mm) const {
    const double limit_mm = travel_mm ? travel_mm->maxCoeff() : kMostHoleSpread_mm;
    return extent_mm(0, true) - extent_mm(0, false) <= limit_mm &&
           extent_mm(1, true) - extent_mm(1, false) <= limit_mm;
  }

  std::string text(std::size_t i_tool) const {
    const HoleOverlap& overlap = overlaps[i_tool];
    return fmt::format(
        "{} (x {:.4g} to {:.4g}, y {:.4g} to {:.4g} mm; of tool {}, {:.4g} mm, {} of {} holes "
        "overlap)",
        format.summary(),
        extent_mm(0, false),
        extent_mm(0, true),
        extent_mm(1, false),
        extent_mm(1, true),
        holes.tools[i_tool].tool,
        holes.tools[i_tool].diameter_mm.value_or(0),
        overlap.n_overlapping,
        overlap.n_places);
  }
};

bool is_in_crowds(const HoleOverlap& overlap) {
  return overlap.n_crowded >= kManyCrowded && 2 * overlap.n_crowded >= overlap.n_places;
}

bool is_in_lines(const HoleOverlap& overlap) {
  return overlap.n_overlapping >= kManyInLines && 2 * overlap.n_overlapping >= overlap.n_places;
}

bool is_apart(const HoleOverlap& overlap) {
  return overlap.n_overlapping <= kFewShare * overlap.n_places;
}

/// Looks at a program in the digits that it may be in.
class DigitCheck {
 public:
  DigitCheck(std::string_view text, const Header& header, const ReadOptions& reading)
      : text_(text),
        header_(header),
        reading_(reading),
        rules_{header.set, header.block_delete.value_or(reading.block_delete.value_or(false))} {}

  bool check(const Reporter& reporter) const {
    const DigitLook usual = look(header_.whole.format());
    if (!usual.holes.is_readable || usual.holes.first_bare.text.empty()) return true;
    const auto by = [&](bool (*kind)(const HoleOverlap&)) {
      return std::ranges::any_of(usual.overlaps, kind);
    };
    if (!by(is_in_crowds) && !by(is_in_lines)) return true;
    for (const auto& [integer_digits, decimal_digits] : other_digits()) {
      NumberFormat format = usual.format;
      format.integer_digits = integer_digits;
      format.decimal_digits = decimal_digits;
      if (are_scaled_alike(format, usual.format)) continue;
      const DigitLook other = look(format);
      if (!other.holes.is_readable || !other.fits(reading_.travel_mm)) continue;
      if (const auto i_tool = first_explained(usual, other, is_in_crowds)) {
        report(reporter, Code::FormatAmbiguous, usual, "is", "or", other, *i_tool);
        return false;
      }
      if (const auto i_tool = first_explained(usual, other, is_in_lines)) {
        report(reporter, Code::FormatAssumed, usual, "is read as", "not", other, *i_tool);
        return true;
      }
    }
    return true;
  }

 private:
  DigitLook look(const NumberFormat& format) const {
    DigitLook out{format, list_holes(text_, rules_, format, kMostListedHoles), {}};
    for (const ListedHoles::OfTool& tool : out.holes.tools) {
      out.overlaps.push_back(tool.diameter_mm ? overlap_of(tool.at_mm, *tool.diameter_mm)
                                              : HoleOverlap{});
    }
    return out;
  }

  /// Of a control, and those that CAM systems write in inch.
  std::vector<std::pair<int, int>> other_digits() const {
    if (header_.whole.format().unit == LengthUnit::Inch) return {{2, 3}};
    return {{4, 2}, {3, 2}};
  }

  static std::optional<std::size_t> first_explained(const DigitLook& usual,
                                                    const DigitLook& other,
                                                    bool (*is_odd)(const HoleOverlap&)) {
    for (std::size_t i = 0; i < usual.overlaps.size(); ++i) {
      if (is_odd(usual.overlaps[i]) && is_apart(other.overlaps[i])) return i;
    }
    return std::nullopt;
  }

  static void report(const Reporter& reporter,
                     Code code,
                     const DigitLook& usual,
                     std::string_view is,
                     std::string_view separator,
                     const DigitLook& other,
                     std::size_t i_tool) {
    const NumberPlace& first = usual.holes.first_bare;
    reporter.report(
        code,
        first,
        fmt::format(" {} {} {} {}", is, usual.text(i_tool), separator, other.text(i_tool)),
        fmt::format("digits behind INCH or METRIC, such as {}, --format, or "
                    "[program] units and digits",
                    usual.format.header_word()));
  }

  std::string_view text_;
  const Header& header_;
  const ReadOptions& reading_;
  LineRules rules_;
};

}  // namespace

HoleOverlap overlap_of(std::span<const Eigen::Vector2d> places_mm, double diameter_mm) {
  HoleOverlap out;
  const std::vector<HoleInCell> places = sorted_holes(places_mm, diameter_mm);
  out.n_places = static_cast<int>(places.size());
  for (const HoleInCell& place : places) {
    const HoleSpread near = hole_spread_about(place, places, diameter_mm, 1);
    if (near.n < 2) continue;
    ++out.n_overlapping;
    const bool is_crowded =
        near.breadth() > kCrowdSpread &&
        hole_spread_about(place, places, diameter_mm, kWideDiameters).breadth() > kCrowdSpread;
    if (is_crowded) ++out.n_crowded;
  }
  return out;
}

bool check_digits(std::string_view text,
                  const Header& header,
                  const ReadOptions& reading,
                  const Reporter& reporter) {
  using Source = StatedFormat::Source;
  const StatedFormat& whole = header.whole;
  const Source digits = whole.source_of_digits().value_or(Source::Numbers);
  // Tools of a header in another unit than coordinates, and steps, are no evidence.
  const bool is_mixed = header.stated.format().unit != whole.format().unit;
  if (digits != Source::Numbers || is_mixed || header.incremental) return true;
  return DigitCheck(text, header, reading).check(reporter);
}

}  // namespace panelcal::excellon
