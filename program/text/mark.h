// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "calib/base/diagnostic.h"
#include "program/text/source_text.h"

namespace panelcal {

/// Words of a program and where they stand, as a diagnostic names them.
struct Mark {
  Mark(int at_line, int at_column, std::string words)
      : line(at_line), column(at_column), what(std::move(words)) {}
  /// The line as it is written.
  Mark(const SourceLine& source)  // NOLINT(google-explicit-constructor): a line is its own mark
      : Mark(source.number, source.column, quoted(source.text)) {}

  int line;
  int column;
  std::string what;  ///< "X1" in "X1Y2"
};

}  // namespace panelcal
