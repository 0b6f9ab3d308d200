// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "program/text/number_format.h"
#include "program/walk/reporter.h"

namespace panelcal {
struct ReadOptions;
}  // namespace panelcal

namespace panelcal::excellon {

/// The number format of a program, each part with the source that states it.
///
/// The first source in the order of Source that states a part decides it; digits only where they
/// are of the unit that was decided. A part that no source states is the manual's: inch, leading
/// zeros, 00.0000 or 000.000.
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

  StatedFormat() = default;
  /// All that is stated outside of the program. A file beside it that cannot be read might rule
  /// over [program], which is then left out.
  explicit StatedFormat(const ReadOptions& reading);

  /// Adds parts to those that a source has; a later statement of it rules over an earlier one.
  void add(Source source, const PartialFormat& parts);

  const NumberFormat& format() const { return format_; }
  const PartialFormat& of(Source source) const { return parts_[static_cast<std::size_t>(source)]; }
  /// Stated by the program or by the operator.
  bool states_unit() const { return is_stated(unit_); }
  bool states_zeros() const { return is_stated(zeros_); }
  bool states_digits() const { return is_stated(digits_); }
  /// Stated anywhere.
  bool knows_unit() const { return unit_.has_value(); }
  bool knows_zeros() const { return zeros_.has_value(); }
  bool knows_digits() const { return digits_.has_value(); }
  /// The source of the digits; absent: they are the unit's usual ones.
  std::optional<Source> source_of_digits() const { return digits_; }
  /// True if a part of the format is of this source.
  bool uses(Source source) const {
    return unit_ == source || zeros_ == source || digits_ == source;
  }
  /// The sources of the parts, for people; empty: nothing states one.
  std::string evidence() const;

  /// Warns of a statement of the program that the operator's contradicts (format-overridden).
  void check_obeyed(const PartialFormat& statement,
                    std::string_view text,
                    int line,
                    int column,
                    const Reporter& reporter) const;

 private:
  static bool is_stated(std::optional<Source> source) {
    return source && *source <= Source::Comment;
  }
  void decide();

  static constexpr std::size_t kSources = 6;
  std::array<PartialFormat, kSources> parts_;
  std::optional<Source> unit_;
  std::optional<Source> zeros_;
  std::optional<Source> digits_;
  NumberFormat format_;
};

}  // namespace panelcal::excellon
