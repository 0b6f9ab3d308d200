// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/format_choice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <vector>

#include "program/excellon/text/body_unit.h"
#include "program/excellon/text/number_census.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

constexpr double kLeastJob_mm = 0.1;
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
  return text.empty() ? "other lengths" : text + " mm";
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

/// Axes may be swapped, so the longer side counts for both.
std::string against_places(const NumberCensus& census,
                           const NumberFormat& format,
                           const std::optional<Eigen::Vector2d>& travel_mm) {
  const double limit_mm = travel_mm ? travel_mm->maxCoeff() : kMostJob_mm;
  double most_size_mm = 0;
  bool is_far = false;
  for (const WrittenNumbers* numbers : {&census.x, &census.y}) {
    if (numbers->is_empty()) continue;
    const WrittenNumbers::Extent extent = numbers->in(format);
    most_size_mm = std::max(most_size_mm, extent.size_mm());
    is_far |= extent.size_mm() > limit_mm || (!travel_mm && extent.farthest_mm() > limit_mm);
  }
  const bool is_small = !census.is_incremental && most_size_mm > 0 && most_size_mm < kLeastJob_mm;
  return is_far || is_small ? "coordinates would be " + spread(census, format) : "";
}

/// The zeros that numbers keep, and no writer would.
std::string against_zeros(const NumberCensus& census, const NumberFormat& format) {
  int n_leading = 0;
  int n_trailing = 0;
  unsigned lengths = 0;
  for (const WrittenNumbers* numbers : {&census.x, &census.y}) {
    const WrittenNumbers::KeptZeros kept = numbers->short_with_zeros(format);
    n_leading += kept.n_leading;
    n_trailing += kept.n_trailing;
    lengths |= numbers->lengths();
  }
  // Where all numbers have one length, nothing is left off.
  if (std::popcount(lengths) < 2) return "";
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
  if (a.unit != b.unit && census.has_other_lengths) return false;
  if (a.zeros != b.zeros && census.has_other_bare_lengths) return false;
  return std::ranges::all_of(
      std::array{&census.x, &census.y, &census.diameters},
      [&](const WrittenNumbers* numbers) { return numbers->mean_the_same_in(a, b); });
}

/// What the program itself states, in its header or its body.
struct Known {
  std::optional<LengthUnit> unit;
  std::optional<Zeros> zeros;
  /// Only the body states the unit, here, behind numbers of the header.
  std::optional<BodyUnit> late;
};

Known known_of(std::string_view program, const Header& draft, const FormatStart& start) {
  Known known;
  if (draft.states_format || start.knows_unit) known.unit = draft.format.unit;
  if (draft.states_zeros || start.knows_zeros) known.zeros = draft.format.zeros;
  if (draft.states_format && known.zeros) return known;
  const auto body = find_body_unit(LineCursor(program, draft.body), draft.set);
  if (!body) return known;
  if (!draft.states_format) known.unit = body->unit;
  if (!known.zeros) known.zeros = body->zeros;
  if (!draft.states_format && draft.has_dimension) known.late = body;
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
std::optional<NumberFormat> late_format(const NumberCensus& census,
                                        const Header& draft,
                                        const BodyUnit& late,
                                        const ReadOptions& reading,
                                        const Reporter& reporter) {
  const bool is_inch = late.unit == LengthUnit::Inch;
  const NumberFormat stated = with_unit(draft, late.unit, reading);
  const NumberFormat other =
      with_unit(draft, is_inch ? LengthUnit::Millimeter : LengthUnit::Inch, reading);
  const std::string reason = against_diameters(census.diameters, other);
  if (reason.empty() || !against_diameters(census.diameters, stated).empty()) return std::nullopt;
  reporter.report(Code::FormatAssumed,
                  late.line,
                  1,
                  fmt::format("{} holds for the tools before it; in {}, {}",
                              quoted(late.text),
                              other.summary(),
                              reason),
                  std::string(kRemedy));
  return stated;
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

std::optional<FormatStart> choose_format(std::string_view program,
                                         const PatternTexts& read_patterns,
                                         const Header& draft,
                                         FormatStart start,
                                         const ReadOptions& reading,
                                         const Reporter& reporter) {
  const Known known = known_of(program, draft, start);
  if (known.unit && known.zeros && !known.late) return std::nullopt;
  std::vector<std::string> patterns;
  if (read_patterns) patterns = read_patterns(program);
  std::vector<std::string_view> texts(patterns.begin(), patterns.end());
  texts.insert(texts.begin(), program);
  const LineRules rules{draft.set,
                        draft.block_delete.value_or(reading.block_delete.value_or(false))};
  const auto has_bare = [&](std::string_view text) { return has_bare_number(text, rules); };
  if (known.unit && !known.late && std::ranges::none_of(texts, has_bare)) return std::nullopt;
  NumberCensus census;
  for (const std::string_view text : texts) take_census(text, rules, census);
  census.is_incremental |= draft.incremental;
  if (known.late) {
    if (const auto format = late_format(census, draft, *known.late, reading, reporter)) {
      start.format = *format;
    }
  }
  std::vector<Reading> readings = readings_of(known, draft, reading);
  const auto differs_from = [&](const Reading& one) {
    return [&](const Reading& two) { return !are_alike(census, one.format, two.format); };
  };
  if (std::ranges::none_of(readings, differs_from(readings.front()))) return start;
  for (Reading& one : readings) one.against = against(census, one.format, reading.travel_mm);
  // Those that are possible first, each kind in the order of preference.
  std::ranges::stable_partition(readings, &std::string::empty, &Reading::against);
  const Reading& best = readings.front();
  const Reading& other = *std::ranges::find_if(readings, differs_from(best));
  if (best.against.empty() && !other.against.empty()) {
    start.format.zeros = best.format.zeros;
    if (!known.unit) start.format = best.format;
    start.assumed = fmt::format("not stated: in {}, {}", other.format.summary(), other.against);
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
  const auto text = [&](const Reading& one) {
    const std::string reason = one.against.empty() ? "" : ", but " + one.against;
    return fmt::format("{} ({}{})", one.format.summary(), spread(census, one.format), reason);
  };
  reporter.report(Code::FormatAmbiguous,
                  census.first_line,
                  census.first_column,
                  fmt::format("{} is {} or {}", quoted(census.first), text(best), text(other)),
                  std::string(kRemedy));
  // Lines that are no blocks, and numbers that no format has, are named as well where they stand.
  const auto fits = [&](const Reading& one) { return fit(census, one.format); };
  start.is_open = !census.has_faults && std::ranges::any_of(readings, fits);
  return start;
}

}  // namespace panelcal::excellon
