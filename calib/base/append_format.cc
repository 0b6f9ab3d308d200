// SPDX-License-Identifier: Apache-2.0
#include "calib/base/append_format.h"

#include <iterator>

namespace panelcal::internal {

void append_values(std::string& out, fmt::string_view text, fmt::format_args values) {
  fmt::vformat_to(std::back_inserter(out), text, values);
}

std::string joined(std::span<const double> numbers, std::string_view between) {
  return fmt::format("{}", fmt::join(numbers, between));
}

}  // namespace panelcal::internal
