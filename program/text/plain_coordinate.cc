// SPDX-License-Identifier: Apache-2.0
#include "program/text/plain_coordinate.h"

#include <algorithm>

namespace panelcal {

PlainReader::PlainReader(const NumberFormat& format)
    : unit_mm_(format.one_unit().in_mm()),
      n_most_digits_(std::min(kMaxRun, format.integer_digits + format.decimal_digits)) {
  for (int n_digits = 0; n_digits <= kMaxRun; ++n_digits) {
    const int exponent = format.zeros == Zeros::TrailingKept ? format.decimal_digits
                                                             : n_digits - format.integer_digits;
    Scale& scale = of_count_[static_cast<std::size_t>(n_digits)];
    if (exponent >= 0) {
      scale.per = kPowersOfTen[static_cast<std::size_t>(exponent)];
    } else {
      scale.times = kPowersOfTen[static_cast<std::size_t>(-exponent)];
    }
  }
}

}  // namespace panelcal
