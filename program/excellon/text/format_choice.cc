// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/format_choice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "program/excellon/text/number_census.h"
#include "program/excellon/text/stated_format.h"
#include "program/walk/reporter.h"
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

/// Digits that a control can be set to (CNC-7 manual, Inch vs. Metric), the usual ones first.
constexpr std::array kMetricDigits = {std::pair(3, 3), std::pair(4, 2), std::pair(3, 2)};
constexpr std::array kInchDigits = {std::pair(2, 4)};

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

/// True if the two give every number without a decimal point the same value in their units.
bool are_scaled_alike(const NumberFormat& a, const NumberFormat& b) {
  if (a.zeros != b.zeros) return false;
  return a.zeros == Zeros::LeadingKept ? a.integer_digits == b.integer_digits
                                       : a.decimal_digits == b.decimal_digits;
}

bool are_alike(const NumberCensus& census, const NumberFormat& a, const NumberFormat& b) {
  if (a.unit != b.unit && census.has_other_lengths) return false;
  if (!are_scaled_alike(a, b) && census.has_other_bare_lengths) return false;
  return std::ranges::all_of(
      std::array{&census.x, &census.y, &census.diameters},
      [&](const WrittenNumbers* numbers) { return numbers->mean_the_same_in(a, b); });
}

/// The formats of the control that agree with what is stated, in the order in which they are
/// preferred where they mean the same: as the manual has it. A unit that is stated without digits
/// has its usual ones.
std::vector<Reading> readings_of(const StatedFormat& stated) {
  std::vector<Reading> readings;
  const auto add = [&](LengthUnit unit, Zeros zeros, std::pair<int, int> digits) {
    StatedFormat trial = stated;
    trial.add(StatedFormat::Source::Numbers, {unit, zeros, digits, ""});
    const NumberFormat& format = trial.format();
    if (format.unit != unit || format.zeros != zeros) return;
    if (std::ranges::find(readings, format, &Reading::format) != readings.end()) return;
    readings.push_back({format, ""});
  };
  for (const LengthUnit unit : {LengthUnit::Inch, LengthUnit::Millimeter}) {
    std::span<const std::pair<int, int>> digits = kMetricDigits;
    if (unit == LengthUnit::Inch) digits = kInchDigits;
    if (stated.knows_unit()) digits = digits.first(1);
    for (const auto& one : digits) {
      for (const Zeros zeros : {Zeros::LeadingKept, Zeros::TrailingKept}) add(unit, zeros, one);
    }
  }
  return readings;
}

class FormatChooser {
 public:
  FormatChooser(const DraftedProgram& program, DiagnosticLog& log)
      : program_(program),
        stated_(program.header.stated),
        log_(log),
        reporter_(program.file, log),
        rules_{program.header.set,
               program.header.block_delete.value_or(program.reading.block_delete.value_or(false))} {
    if (program.body) stated_.add(StatedFormat::Source::Word, program.body->format);
  }

  std::optional<FormatChoice> choose() {
    const bool is_known = stated_.knows_unit() && stated_.knows_zeros();
    const bool is_late =
        program_.body && program_.header.has_dimension && !program_.header.stated.knows_unit();
    if (is_known && !is_late && !has_foreign_digits()) return std::nullopt;
    std::vector<std::string> patterns;
    if (program_.read_patterns) patterns = program_.read_patterns(program_.text);
    std::vector<std::string_view> texts(patterns.begin(), patterns.end());
    texts.insert(texts.begin(), program_.text);
    const auto has_bare = [&](std::string_view text) { return has_bare_number(text, rules_); };
    if (stated_.knows_unit() && !is_late && std::ranges::none_of(texts, has_bare)) {
      return std::nullopt;
    }
    for (const std::string_view text : texts) take_census(text, rules_, census_);
    census_.is_incremental |= program_.header.incremental;
    if (is_late) take_late_unit();
    const bool is_decided = is_known || choose_reading();
    if (is_decided && has_foreign_digits()) warn_of_digits();
    return choice_;
  }

 private:
  /// The unit is stated without its digits, and they are stated elsewhere, or may be.
  bool has_foreign_digits() const {
    return stated_.states_unit() && !stated_.states_digits() &&
           (stated_.knows_digits() || program_.reading.format_beside.fault);
  }

  /// A unit that only the body states is the header's too, if no drill has these diameters in the
  /// other one.
  void take_late_unit() {
    const LengthUnit unit = *program_.body->format.unit;
    StatedFormat other = program_.header.stated;
    other.add(StatedFormat::Source::Word,
              {.unit = unit == LengthUnit::Inch ? LengthUnit::Millimeter : LengthUnit::Inch});
    const std::string reason = against_diameters(census_.diameters, other.format());
    if (reason.empty() || !against_diameters(census_.diameters, stated_.format()).empty()) return;
    choice_.numbers.unit = unit;
    reporter_.report(Code::FormatAssumed,
                     program_.body->line,
                     1,
                     fmt::format("{} holds for the tools before it; in {}, {}",
                                 quoted(program_.body->text),
                                 other.format().summary(),
                                 reason),
                     std::string(kRemedy));
  }

  /// False: the program is not to be executed, and the log says why.
  bool choose_reading() {
    std::vector<Reading> readings = readings_of(stated_);
    const auto differs_from = [&](const Reading& one) {
      return [&](const Reading& two) { return !are_alike(census_, one.format, two.format); };
    };
    if (std::ranges::none_of(readings, differs_from(readings.front()))) return true;
    for (Reading& one : readings) {
      one.against = against(census_, one.format, program_.reading.travel_mm);
    }
    // Those that are possible first, each kind in the order of preference.
    std::ranges::stable_partition(readings, &std::string::empty, &Reading::against);
    const Reading& best = readings.front();
    const Reading& other = *std::ranges::find_if(readings, differs_from(best));
    const auto& fault = program_.reading.format_beside.fault;
    if (!fault && best.against.empty() && !other.against.empty()) {
      take(best, other);
      return true;
    }
    if (fault) {
      log_.add(*fault);
    } else {
      report(Code::FormatAmbiguous, fmt::format("is {} or {}", text_of(best), text_of(other)));
    }
    // Lines that are no blocks, and numbers that no format has, are named as well where they stand.
    const auto fits = [&](const Reading& one) { return fit(census_, one.format); };
    choice_.is_open = !census_.has_faults && std::ranges::any_of(readings, fits);
    return false;
  }

  void take(const Reading& best, const Reading& other) {
    PartialFormat& numbers = choice_.numbers;
    numbers.zeros = best.format.zeros;
    if (!stated_.knows_unit()) {
      numbers.unit = best.format.unit;
      numbers.digits.emplace(best.format.integer_digits, best.format.decimal_digits);
    }
    const std::string reason = fmt::format("in {}, {}", other.format.summary(), other.against);
    numbers.from = "not stated: " + reason;
    report(Code::FormatAssumed, fmt::format("is read as {}; {}", best.format.summary(), reason));
  }

  /// The manual has a control take the digits that were selected last; the program may have been
  /// written for others.
  void warn_of_digits() {
    stated_.add(StatedFormat::Source::Numbers, choice_.numbers);
    const NumberFormat& format = stated_.format();
    const FormatBeside& beside = program_.reading.format_beside;
    NumberFormat usual = format;
    usual.take_usual_digits();
    std::string what = "is read as " + format.summary();
    if (beside.fault) {
      what += fmt::format(", whatever {} states: {}", beside.file, beside.fault->message());
    } else if (!are_alike(census_, format, usual)) {
      what += fmt::format(" ({}); {} alone stands for {}",
                          stated_.of(*stated_.source_of_digits()).from,
                          format.unit == LengthUnit::Inch ? "INCH" : "METRIC",
                          usual.summary());
    } else {
      return;
    }
    report(Code::FormatAssumed,
           what,
           "digits behind INCH or METRIC, such as METRIC,TZ,000.000, or --format");
  }

  std::string text_of(const Reading& one) const {
    const std::string reason = one.against.empty() ? "" : ", but " + one.against;
    return fmt::format("{} ({}{})", one.format.summary(), spread(census_, one.format), reason);
  }

  /// At the program's first number.
  void report(Code code, const std::string& what, std::string_view expected = kRemedy) const {
    reporter_.report(code,
                     census_.first_line,
                     census_.first_column,
                     quoted(census_.first) + " " + what,
                     std::string(expected));
  }

  const DraftedProgram& program_;
  StatedFormat stated_;  ///< by the body as well
  DiagnosticLog& log_;
  Reporter reporter_;
  LineRules rules_;
  NumberCensus census_;
  FormatChoice choice_;
};

}  // namespace

std::optional<FormatChoice> choose_format(const DraftedProgram& program, DiagnosticLog& log) {
  return FormatChooser(program, log).choose();
}

}  // namespace panelcal::excellon
