// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/format_choice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "program/excellon/text/lexer.h"
#include "program/excellon/text/number_census.h"
#include "program/excellon/text/stated_format.h"
#include "program/text/gaps.h"
#include "program/text/source_text.h"
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
        header_(program.header),
        stated_(header_.whole),
        log_(log),
        reporter_(program.file, log),
        rules_{header_.set,
               header_.block_delete.value_or(program.reading.block_delete.value_or(false))} {}

  FormatChoice choose() {
    const bool is_late = header_.has_dimension && !header_.stated.knows_unit() &&
                         stated_.source_of_unit() == StatedFormat::Source::Word;
    const FormatBeside& beside = program_.reading.format_beside;
    if (beside.steps && !states_steps()) return refuse(*beside.steps);
    const Diagnostic* const trouble = beside.fault ? &*beside.fault : nullptr;
    const bool is_known = stated_.knows_unit() && stated_.knows_zeros() && !is_late;
    if (is_known && (stated_.states_all() ||
                     (trouble == nullptr && !has_foreign_digits() && !has_foreign_zeros()))) {
      return {};
    }
    read_texts();
    if (!is_late && !bare_ &&
        (stated_.states_unit() || (trouble == nullptr && stated_.knows_unit()))) {
      return {};
    }
    if (trouble != nullptr && needs_file()) return refuse(*trouble);
    if (!is_known) {
      take_whole_census();
      if (is_late && is_cut_off()) return refuse_evidence("the unit stands in the body alone");
      if (is_late) take_late_unit();
      leave_out_diameters_of_another_unit();
      if (!choose_reading()) return choice_;
      stated_.add(StatedFormat::Source::Numbers, choice_.numbers);
    }
    if (has_foreign_digits() && bare_) warn_of_digits();
    if (has_foreign_zeros() && bare_) warn_of_zeros();
    return choice_;
  }

 private:
  /// Whether coordinates are steps is stated, or the operator has left the file beside the program
  /// out with a whole format.
  bool states_steps() const {
    const PartialFormat& forced = program_.reading.forced_format;
    return header_.states_incremental || program_.body.states_steps ||
           (forced.unit && forced.zeros && forced.digits);
  }

  /// True where a number has another value if the file states what the program does not.
  bool needs_file() {
    if (stated_.states_unit()) return bare_.has_value();
    take_whole_census();
    return !are_alike(census_, {.unit = LengthUnit::Inch}, {.unit = LengthUnit::Millimeter});
  }

  FormatChoice refuse(const Diagnostic& trouble) {
    log_.add(trouble);
    choice_.is_open = true;
    return choice_;
  }

  /// The file may have lost its end, and the operator accepts that: its numbers are not all there
  /// are, and of another part they are other evidence.
  bool is_cut_off() const {
    if (!program_.reading.accepts_unterminated) return false;
    std::string_view last;
    for (LineCursor cursor(program_.text); !cursor.at_end();) {
      const SourceLine line = cursor.next();
      if (kind_of(line.text) != LineKind::Empty) last = trimmed(line.text);
    }
    const auto has_end = [&](std::string_view end) {
      return last.starts_with(end) || last.ends_with(end);
    };
    return !has_end("M30") && !has_end("M00");
  }

  FormatChoice refuse_evidence(const std::string& what) {
    report(Code::FormatAmbiguous, what + "; a file without its end does not show all its numbers");
    choice_.is_open = true;
    return choice_;
  }

  /// The unit is stated without its digits, and elsewhere digits that give numbers other values.
  bool has_foreign_digits() const {
    NumberFormat usual = stated_.format();
    usual.take_usual_digits();
    return stated_.states_unit() && stated_.knows_digits() && !stated_.states_digits() &&
           !are_scaled_alike(stated_.format(), usual);
  }

  /// The zeros are those of [program] in another unit than the program's.
  bool has_foreign_zeros() const {
    const std::optional<LengthUnit> unit = program_.reading.last_format.unit;
    return stated_.source_of_zeros() == StatedFormat::Source::Setting && unit &&
           *unit != stated_.format().unit;
  }

  /// The program and the patterns that it calls.
  void read_texts() {
    if (program_.read_patterns) patterns_ = program_.read_patterns(program_.text);
    texts_.assign(patterns_.begin(), patterns_.end());
    texts_.insert(texts_.begin(), program_.text);
    bare_ = find_bare_number(program_.text, rules_);
    for (std::size_t i = 1; i < texts_.size() && !bare_; ++i) {
      bare_ = find_bare_number(texts_[i], rules_);
      if (bare_) bare_->line = bare_->column = 0;  // a line of another file
    }
  }

  void take_whole_census() {
    if (std::exchange(has_census_, true)) return;
    for (const std::string_view text : texts_) take_census(text, rules_, census_);
    census_.is_incremental |= header_.incremental;
  }

  /// A unit that only the body states is the header's too, if no drill has these diameters in the
  /// other one.
  void take_late_unit() {
    const LengthUnit unit = stated_.format().unit;
    StatedFormat other = header_.stated;
    other.add(StatedFormat::Source::Word,
              {.unit = unit == LengthUnit::Inch ? LengthUnit::Millimeter : LengthUnit::Inch});
    const std::string reason = against_diameters(census_.diameters, other.format());
    if (reason.empty() || !against_diameters(census_.diameters, stated_.format()).empty()) return;
    choice_.numbers.unit = unit;
    const BodyUnit& said = *std::ranges::find_if(
        program_.body.units, [&](const BodyUnit& of) { return of.format.unit == unit; });
    reporter_.report(Code::FormatAssumed,
                     said.line,
                     fmt::format("{} holds for the tools before it; in {}, {}",
                                 quoted(said.text),
                                 other.format().summary(),
                                 reason),
                     std::string(kRemedy));
  }

  /// Where INCH or METRIC of the header and M71 or M72 of the body differ, tools are in another
  /// unit than coordinates, and are no evidence of what these mean.
  void leave_out_diameters_of_another_unit() {
    const StatedFormat& header = header_.stated;
    if (!header.states_unit() || header.format().unit == stated_.format().unit) return;
    census_.has_other_bare_lengths |= census_.diameters.lengths() != 0;
    census_.diameters = {};
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
    if (best.against.empty() && !other.against.empty()) {
      if (is_cut_off()) {
        refuse_evidence(fmt::format("is {}, unless what is missing says {}",
                                    best.format.summary(),
                                    other.format.summary()));
        return false;
      }
      take(best, other);
      return true;
    }
    report(Code::FormatAmbiguous, fmt::format("is {} or {}", text_of(best), text_of(other)));
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
  void warn_of_digits() const {
    const NumberFormat& format = stated_.format();
    NumberFormat usual = format;
    usual.take_usual_digits();
    reporter_.report(
        Code::FormatAssumed,
        *bare_,
        fmt::format(" is read as {} ({}); the usual digits are {}",
                    format.summary(),
                    stated_.evidence_of_digits(),
                    usual.summary()),
        fmt::format("digits behind INCH or METRIC, such as {}, or --format", usual.header_word()));
  }

  /// Numbers that have all digits mean the same under either zeros.
  void warn_of_zeros() {
    const NumberFormat& format = stated_.format();
    NumberFormat other = format;
    const bool is_leading = format.zeros == Zeros::LeadingKept;
    other.zeros = is_leading ? Zeros::TrailingKept : Zeros::LeadingKept;
    take_whole_census();
    if (are_alike(census_, format, other)) return;
    const PartialFormat& setting = program_.reading.last_format;
    reporter_.report(Code::FormatAssumed,
                     *bare_,
                     fmt::format(" is read as {}; the zeros are those of {}, in {}",
                                 format.summary(),
                                 setting.from,
                                 *setting.unit == LengthUnit::Inch ? "inch" : "metric"),
                     "LZ or TZ behind INCH or METRIC, or --format");
  }

  std::string text_of(const Reading& one) const {
    const std::string reason = one.against.empty() ? "" : ", but " + one.against;
    return fmt::format("{} ({}{})", one.format.summary(), spread(census_, one.format), reason);
  }

  /// At the program's first number.
  void report(Code code, const std::string& what) const {
    reporter_.report(code, census_.first, " " + what, std::string(kRemedy));
  }

  const DraftedProgram& program_;
  const Header& header_;
  StatedFormat stated_;  ///< by the body and by the numbers as well
  DiagnosticLog& log_;
  Reporter reporter_;
  LineRules rules_;
  std::vector<std::string> patterns_;
  std::vector<std::string_view> texts_;  ///< the program and its patterns
  std::optional<NumberPlace> bare_;
  NumberCensus census_;
  bool has_census_ = false;
  FormatChoice choice_;
};

}  // namespace

FormatChoice choose_format(const DraftedProgram& program, DiagnosticLog& log) {
  return FormatChooser(program, log).choose();
}

}  // namespace panelcal::excellon
