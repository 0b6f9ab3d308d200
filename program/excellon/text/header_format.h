// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "program/excellon/text/header.h"
#include "program/excellon/text/header_words.h"
#include "program/text/number_format.h"
#include "program/walk/reporter.h"

namespace panelcal::excellon {

/// The number format of a header while it is read: takes what its lines and comments state.
class HeaderFormat {
 public:
  /// In     outside: what is stated outside of the program
  ///        header, reporter: must outlive it
  HeaderFormat(Header& header, const StatedFormat& outside, const Reporter& reporter);

  /// INCH or METRIC with LZ, TZ and digits behind the comma.
  void read_unit(int line, int column, HeaderCommand command);
  /// CAM systems say in comments what their header does not.
  void read_comment(int line, std::string_view text);

 private:
  PartialFormat read_options(int line, int column, std::string_view options, bool is_late);
  void take(StatedFormat::Source source,
            int line,
            int column,
            std::string_view text,
            PartialFormat parts);
  /// True if the operator rules over all units that the program states.
  bool has_ruled_unit() const {
    return header_.stated.of(StatedFormat::Source::Operator).unit.has_value();
  }
  void report_late(int line, int column, const std::string& what, std::string_view stated);
  void invalid(int line, int column, std::string what, std::string expected);

  Header& header_;
  const Reporter& reporter_;
  std::string unit_word_;
};

}  // namespace panelcal::excellon
