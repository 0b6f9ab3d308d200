// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "program/excellon/text/format_choice.h"
#include "program/excellon/text/header.h"
#include "program/excellon/text/header_words.h"
#include "program/text/number_format.h"
#include "program/text/source_text.h"
#include "program/walk/options.h"
#include "program/walk/reporter.h"

namespace panelcal::excellon {

/// The number format of a header while it is read: what its lines and comments state, in which
/// order they rule over each other, and what rules over them all.
class HeaderFormat {
 public:
  /// All of them must outlive it.
  HeaderFormat(Header& header,
               const Reporter& reporter,
               const FormatStart& start,
               const ReadOptions& reading);

  /// INCH or METRIC with LZ, TZ and digits behind the comma.
  void read_unit(int line, int column, HeaderCommand command);
  /// CAM systems say in comments what their header does not. INCH and METRIC with LZ, TZ and digits
  /// rule over a comment.
  void read_comment(int line, std::string_view text);
  /// Looks for a unit that only the body states; to be called behind the whole header.
  void read_body(LineCursor body);

 private:
  void take_unit(int line, LengthUnit unit, std::string_view comment);
  void take_digits(int line, const std::pair<int, int>& digits, std::string_view comment);
  void take_options(int line, int column, std::string_view options, bool is_late);
  void impose(int line, int column, std::string_view text);
  void add_evidence_of_start();
  void report_late(int line, int column, const std::string& what, std::string_view stated);
  void invalid(int line, int column, std::string what, std::string expected);

  Header& header_;
  const Reporter& reporter_;
  const PartialFormat& forced_;  ///< --format
  PartialFormat setting_;        ///< digits of a unit where the header states none
  const FormatStart& start_;
  std::optional<LengthUnit> hint_unit_;  ///< of the comment that states the digits
  bool digits_from_hint_ = false;
  bool has_zeros_word_ = false;
  bool has_digit_mask_ = false;
  bool is_overridden_ = false;
  std::string unit_word_;
};

}  // namespace panelcal::excellon
