// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "program/excellon/text/header.h"
#include "program/excellon/text/header_words.h"
#include "program/text/number_format.h"
#include "program/walk/reporter.h"

namespace panelcal::excellon {

/// The remedy for a statement behind the numbers that it is about.
inline constexpr std::string_view kFormatFirst =
    "INCH or METRIC, with LZ or TZ, before all dimensions";

/// The number format of a header while it is read: takes what its lines and comments state.
class HeaderFormat {
 public:
  /// In     outside: what is stated outside of the program
  ///        header, reporter: must outlive it, and so must all texts
  HeaderFormat(Header& header, const StatedFormat& outside, const Reporter& reporter);

  /// INCH or METRIC with LZ, TZ and digits behind the comma.
  ///
  /// In     text: as written, M71 or M72 for the unit alone
  void read_unit(int line, int column, std::string_view text, const HeaderCommand& command);
  /// CAM systems say in comments what their header does not.
  void read_comment(int line, std::string_view text);
  /// Refuses comments that contradict each other in a part that comments decide. A comment of the
  /// header on numbers of another unit than INCH or METRIC has means nothing, ahead of these words
  /// and behind them; one of the body is refused (check_comment of the interpreter).
  void check_comments() const;

 private:
  using Source = StatedFormat::Source;
  struct Comment {
    int line = 0;
    std::string_view text;
    PartialFormat parts;
  };

  bool contradicts_words(const PartialFormat& parts) const;
  PartialFormat read_options(std::string_view word, int line, int column, std::string_view options);
  void take(Source source, int line, int column, std::string_view text, PartialFormat parts);
  void report_late(int line, int column, std::string_view text, std::string_view stated) const;
  void invalid(int line, int column, std::string what, std::string_view expected) const;

  Header& header_;
  const Reporter& reporter_;
  std::string unit_word_;
  PartialFormat of_words_;  ///< zeros and digits that INCH or METRIC have stated
  std::vector<Comment> comments_;
};

}  // namespace panelcal::excellon
