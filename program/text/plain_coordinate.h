// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "program/text/number_format.h"

namespace panelcal {

/// A block of nothing but X and Y, as nearly every block is.
struct PlainCoordinate {
  std::array<std::optional<double>, 2> xy_mm;  ///< an axis that the block leaves out is absent
  bool has_point = true;  ///< every number has a decimal point or no digits: any format reads it
};

/// Reads plain coordinate blocks fast, eight characters at a time.
///
/// What it reads, it reads bit for bit as parse_length does. What it leaves alone (blanks, other
/// letters, Y before X, more than eight digits in a row, every fault) is no error: the general
/// reader must judge it.
class PlainReader {
 public:
  /// Precondition: the format's digit counts are 0 to 15.
  explicit PlainReader(const NumberFormat& format);

  /// False: not plain, and `out` has no meaning. `line` is one line without its line end.
  bool read(std::string_view line, PlainCoordinate& out) const;

 private:
  static constexpr int kMaxRun = 8;
  /// mantissa * times / per; one of the two is 1, so that only one operation rounds.
  struct Scale {
    double times = 1;
    double per = 1;
  };

  double unit_mm_;
  int n_most_digits_;                        ///< without a decimal point
  std::array<Scale, kMaxRun + 1> of_count_;  ///< by the number of digits, without a decimal point
};

}  // namespace panelcal
