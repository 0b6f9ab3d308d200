// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/text/number_format.h"
#include "program/walk/reporter.h"

namespace panelcal {
struct ReadOptions;
}  // namespace panelcal

namespace panelcal::excellon {

/// The number format of a program: all statements about it, and what they make together.
///
/// The first source in the order of Source that states a part decides it: of several statements the
/// last one, of comments the first one. Digits count for the unit that they were stated with, and
/// so do the zeros of a comment and of a file beside the program. A part that no source states is
/// the manual's: inch, leading zeros, 00.0000 or 000.000.
///
/// Source CNC-7 manual, Leading and Trailing Zeros; Metric Measuring Mode: "the digit format you
///        last selected"
/// See    tests/program/excellon/text/stated_format_test.cc
class StatedFormat {
 public:
  enum class Source : std::uint8_t {
    Operator,  ///< --format
    Word,      ///< INCH, METRIC, M71, M72
    Comment,   ///< of a CAM system
    Beside,    ///< nc_param.txt beside the program
    Setting,   ///< [program], the control's last setting
    Numbers,   ///< the program's numbers (format_choice.h)
  };
  /// Statements of a body: INCH and METRIC, or the codes M71 and M72.
  enum class Form : std::uint8_t { Word, Code };

  StatedFormat() = default;
  /// All that is stated outside of the program. A file beside it that cannot be read might rule
  /// over [program], which is then left out.
  explicit StatedFormat(const ReadOptions& reading);

  /// Adds a statement, whose parts count where no other one rules over them.
  void add(Source source, const PartialFormat& statement);

  /// Adds a comment of the body that agrees with the format, for statements behind it. One without
  /// a unit is about the unit that is stated.
  void add_comment_of_body(const PartialFormat& comment);

  const NumberFormat& format() const { return format_; }
  /// Stated by the program or by the operator.
  bool states_unit() const { return is_stated(unit_); }
  bool states_zeros() const { return is_stated(zeros_); }
  bool states_digits() const { return is_stated(digits_); }
  bool states_all() const { return states_unit() && states_zeros() && states_digits(); }
  /// Stated anywhere.
  bool knows_unit() const { return unit_.has_value(); }
  bool knows_zeros() const { return zeros_.has_value(); }
  bool knows_digits() const { return digits_.has_value(); }
  /// Absent: the part is the manual's.
  std::optional<Source> source_of_unit() const { return source_of(unit_); }
  std::optional<Source> source_of_zeros() const { return source_of(zeros_); }
  std::optional<Source> source_of_digits() const { return source_of(digits_); }
  /// True if a part of the format is of this source.
  bool uses(Source source) const;
  /// The statements that decide a part, for people; empty: there is none.
  std::string evidence() const;
  /// The one that decides the digits.
  ///
  /// Precondition: knows_digits()
  const std::string& evidence_of_digits() const { return statements_[*digits_].parts.from; }

  /// The parts of a statement of the program that the operator does not rule over. Where its unit
  /// is another one than the operator's, its digits do not count, nor the zeros of a comment.
  PartialFormat obeyed(Source source, PartialFormat statement) const;
  /// True if the operator states a part otherwise.
  bool is_overruled(const PartialFormat& statement) const;
  /// The operator's statement, for people.
  std::string ruling() const;

  /// True if a statement of the body is not to be obeyed, since the program has stated another unit
  /// or other zeros before it. M71 and M72 may change a unit that INCH or METRIC states, not one
  /// that a comment states as well, or states digits or zeros for: it is about all numbers of the
  /// file.
  bool is_contradicted_by(const PartialFormat& statement, Form form) const;

 private:
  struct Statement {
    Source source;
    PartialFormat parts;
    std::optional<LengthUnit> unit_of_digits;  ///< absent: either
  };
  using Index = std::optional<std::size_t>;

  bool is_stated(Index part) const { return part && statements_[*part].source <= Source::Comment; }
  std::optional<Source> source_of(Index part) const {
    return part ? std::optional(statements_[*part].source) : std::nullopt;
  }
  template <class States>
  Index first_that(const States& states) const;
  void decide();

  std::vector<Statement> statements_;  ///< in the order of their sources
  Index unit_;
  Index zeros_;
  Index digits_;
  NumberFormat format_;
};

/// Warns of a statement of the program that the operator's contradicts (format-overridden).
void check_obeyed(const StatedFormat& stated,
                  const PartialFormat& statement,
                  std::string_view text,
                  int line,
                  int column,
                  const Reporter& reporter);

}  // namespace panelcal::excellon
