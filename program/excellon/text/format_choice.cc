// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/format_choice.h"

#include <algorithm>
#include <array>
#include <vector>

#include "program/excellon/text/body_unit.h"
#include "program/excellon/text/number_census.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

constexpr double kLeastJob_mm = 1;
constexpr double kMostJob_mm = 1000;
constexpr double kLeastDrill_mm = 0.03;
constexpr double kMostDrill_mm = 20;
/// Numbers that keep zeros which a reading would leave off: one may be a slip.
constexpr int kTellingZeros = 2;

constexpr std::string_view kRemedy =
    "INCH or METRIC with LZ or TZ in the header, --format, or [program] units and zeros";

/// A format the program may be in; why not, if it cannot.
struct Reading {
  NumberFormat format;
  std::string against;
};

/// "x 25.4 to 76.2, y 50.8 to 101.6 mm".
std::string spread(const NumberCensus& census, const NumberFormat& format) {
  std::string text;
  const auto append = [&](std::string_view axis, const WrittenNumbers& numbers) {
    if (numbers.is_empty()) return;
    const WrittenNumbers::Extent extent = numbers.in(format);
    text += fmt::format(
        "{}{} {:.4g} to {:.4g}", text.empty() ? "" : ", ", axis, extent.least_mm, extent.most_mm);
  };
  append("x", census.x);
  append("y", census.y);
  if (text.empty()) append("drills", census.diameters);
  return text + " mm";
}

bool fit(const NumberCensus& census, const NumberFormat& format) {
  return std::ranges::all_of(std::array{&census.x, &census.y, &census.diameters},
                             [&](const WrittenNumbers* numbers) { return numbers->fit(format); });
}

/// Why a drill cannot have these diameters; empty: it can.
std::string against_diameters(const WrittenNumbers& diameters, const NumberFormat& format) {
  if (diameters.is_empty()) return "";
  const WrittenNumbers::Extent extent = diameters.in(format);
  if (extent.least_mm < kLeastDrill_mm) {
    return fmt::format("a drill would have {:.3g} mm", extent.least_mm);
  }
  if (extent.most_mm > kMostDrill_mm) {
    return fmt::format("a drill would have {:.4g} mm", extent.most_mm);
  }
  return "";
}

std::string against_places(const NumberCensus& census,
                           const NumberFormat& format,
                           const std::optional<Eigen::Vector2d>& travel_mm) {
  double most_size_mm = 0;
  bool is_far = false;
  int axis = 0;
  for (const WrittenNumbers* numbers : {&census.x, &census.y}) {
    const double limit_mm = travel_mm ? (*travel_mm)[axis++] : kMostJob_mm;
    if (numbers->is_empty()) continue;
    const WrittenNumbers::Extent extent = numbers->in(format);
    most_size_mm = std::max(most_size_mm, extent.size_mm());
    is_far |= extent.size_mm() > limit_mm || (!travel_mm && extent.farthest_mm() > limit_mm);
  }
  if (is_far) {
    return fmt::format("coordinates would be {}", spread(census, format));
  }
  if (census.is_incremental || most_size_mm == 0) return "";
  double least_mm = kLeastJob_mm;
  if (!census.diameters.is_empty()) {
    least_mm = std::max(least_mm, census.diameters.in(format).most_mm);
  }
  if (most_size_mm >= least_mm) return "";
  return fmt::format("all coordinates would be {}", spread(census, format));
}

/// The zeros that numbers keep, and no writer would.
std::string against_zeros(const NumberCensus& census, const NumberFormat& format) {
  int n_leading = 0;
  int n_trailing = 0;
  for (const WrittenNumbers* numbers : {&census.x, &census.y}) {
    n_leading += numbers->n_short_with_leading_zero(format);
    n_trailing += numbers->n_short_with_trailing_zero(format);
  }
  if (format.zeros == Zeros::LeadingKept && n_trailing >= kTellingZeros && n_leading == 0) {
    return fmt::format("{} numbers end with zeros that it would leave off", n_trailing);
  }
  if (format.zeros == Zeros::TrailingKept && n_leading >= kTellingZeros && n_trailing == 0) {
    return fmt::format("{} numbers begin with zeros that it would leave off", n_leading);
  }
  return "";
}

std::string against(const NumberCensus& census,
                    const NumberFormat& format,
                    const std::optional<Eigen::Vector2d>& travel_mm) {
  if (!fit(census, format)) return "a number has more digits";
  std::string reason = against_diameters(census.diameters, format);
  if (reason.empty()) reason = against_zeros(census, format);
  if (reason.empty()) reason = against_places(census, format, travel_mm);
  return reason;
}

bool are_alike(const NumberCensus& census, const NumberFormat& a, const NumberFormat& b) {
  return std::ranges::all_of(
      std::array{&census.x, &census.y, &census.diameters},
      [&](const WrittenNumbers* numbers) { return numbers->mean_the_same_in(a, b); });
}

/// What the program itself states, in its header or its body.
struct Known {
  std::optional<LengthUnit> unit;
  std::optional<Zeros> zeros;
  /// Only the body states the unit, behind numbers of the header.
  bool is_late = false;
};

Known known_of(std::string_view program, const Header& draft, const FormatStart& start) {
  Known known;
  const bool has_unit = draft.states_format || start.knows_unit;
  if (has_unit) known.unit = draft.format.unit;
  if (draft.states_zeros || start.knows_zeros) known.zeros = draft.format.zeros;
  if (draft.states_format && known.zeros) return known;
  const auto body = find_body_unit(LineCursor(program, draft.body), draft.set);
  if (!body) return known;
  if (!draft.states_format) known.unit = body->unit;
  if (!known.zeros) known.zeros = body->zeros;
  known.is_late = !has_unit && draft.has_dimension;
  return known;
}

NumberFormat with_unit(const Header& draft, LengthUnit unit, const ReadOptions& reading) {
  NumberFormat format = draft.format;
  if (unit == format.unit) return format;
  format.unit = unit;
  if (draft.states_digits) return format;
  format.states_digits = false;
  format.take_digits(reading.unstated_format());
  return format;
}

/// In the order in which they are preferred where they mean the same: as the manual has it.
std::vector<Reading> readings_of(const Known& known,
                                 const Header& draft,
                                 const ReadOptions& reading) {
  std::vector<Reading> readings;
  for (const LengthUnit unit : {LengthUnit::Inch, LengthUnit::Millimeter}) {
    if (known.unit.value_or(unit) != unit) continue;
    for (const Zeros zeros : {Zeros::LeadingKept, Zeros::TrailingKept}) {
      if (known.zeros.value_or(zeros) != zeros) continue;
      readings.push_back({with_unit(draft, unit, reading), ""});
      readings.back().format.zeros = zeros;
    }
  }
  return readings;
}

/// A unit that only the body states is the header's too, if no drill has these diameters in the
/// other one.
bool holds_for_header(const NumberCensus& census,
                      const Header& draft,
                      LengthUnit unit,
                      const ReadOptions& reading) {
  const LengthUnit other = unit == LengthUnit::Inch ? LengthUnit::Millimeter : LengthUnit::Inch;
  const auto reason = [&](LengthUnit of) {
    return against_diameters(census.diameters, with_unit(draft, of, reading));
  };
  return reason(unit).empty() && !reason(other).empty();
}

}  // namespace

FormatStart stated_start(const ReadOptions& reading) {
  PartialFormat stated = reading.forced_format;
  stated.fill_from(reading.unstated_format());
  FormatStart start;
  stated.apply_to(start.format);
  start.knows_unit = stated.unit.has_value();
  start.knows_zeros = stated.zeros.has_value();
  start.evidence = stated.from;
  return start;
}

FormatStart choose_format(std::string_view program,
                          const Header& draft,
                          FormatStart start,
                          const ReadOptions& reading,
                          const Reporter& reporter) {
  const Known known = known_of(program, draft, start);
  if (known.unit && known.zeros && !known.is_late) return start;
  if (known.unit && !known.is_late && !has_bare_number(program, draft.set)) return start;
  const NumberCensus census = take_census(program, draft.set);
  if (known.is_late && holds_for_header(census, draft, *known.unit, reading)) {
    start.format = with_unit(draft, *known.unit, reading);
  }
  std::vector<Reading> readings = readings_of(known, draft, reading);
  const auto differs_from = [&](const Reading& one) {
    return [&](const Reading& two) { return !are_alike(census, one.format, two.format); };
  };
  const auto fits = [&](const Reading& one) { return fit(census, one.format); };
  if (std::ranges::none_of(readings, differs_from(readings.front()))) return start;
  // The first number that is too long is named where it stands.
  if (std::ranges::none_of(readings, fits)) return start;
  for (Reading& one : readings) one.against = against(census, one.format, reading.travel_mm);
  // Those that are possible first, each kind in the order of preference.
  std::ranges::stable_partition(readings, &std::string::empty, &Reading::against);
  const Reading& best = readings.front();
  const Reading& other = *std::ranges::find_if(readings, differs_from(best));
  if (best.against.empty() != other.against.empty()) {
    start.format.zeros = best.format.zeros;
    if (!known.unit) start.format = best.format;
    start.evidence = fmt::format("not stated; in {}, {}", other.format.summary(), other.against);
    reporter.report(Code::FormatAssumed,
                    census.first_line,
                    census.first_column,
                    fmt::format("{} is read as {}; in {}, {}",
                                quoted(census.first),
                                best.format.summary(),
                                other.format.summary(),
                                other.against),
                    std::string(kRemedy));
    return start;
  }
  // Where lines are no blocks, they are what is wrong first of all.
  if (census.has_faults) return start;
  const auto text = [&](const Reading& one) {
    const std::string reason = one.against.empty() ? "" : ", but " + one.against;
    return fmt::format("{} ({}{})", one.format.summary(), spread(census, one.format), reason);
  };
  reporter.report(Code::FormatAmbiguous,
                  census.first_line,
                  census.first_column,
                  fmt::format("{} is {} or {}", quoted(census.first), text(best), text(other)),
                  std::string(kRemedy));
  start.is_open = true;
  return start;
}

}  // namespace panelcal::excellon
