// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

namespace panelcal::batch {

/// A field of a line of CSV, without its quotes and the blanks around it.
struct CsvField {
  std::string text;
  int column = 1;  ///< of its beginning, in bytes from 1
};

/// Splits a line at commas; "a, ""b""" is one field (RFC 4180).
///
/// Fails  with the column of a quote that is not closed, or that has text beside it
tl::expected<std::vector<CsvField>, int> split_csv(std::string_view line);

}  // namespace panelcal::batch
