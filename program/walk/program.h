// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "program/excellon/header.h"
#include "program/model/operation.h"
#include "program/sieb_meyer/file_layout.h"
#include "program/text/source_text.h"
#include "program/walk/options.h"

namespace panelcal {

/// A program that has been read as far as its header.
struct Program {
  SourceText source;
  Dialect dialect = Dialect::Excellon;
  excellon::Header header;        ///< of an Excellon program
  sieb_meyer::FileLayout layout;  ///< of a SIEB & MEYER program
  /// The stored patterns or subprograms it names.
  std::map<std::string, SourceText, std::less<>> patterns;
  ReadOptions reading;

  bool deletes_blocks() const;  ///< blocks that begin with / are left out
  int axis_version() const { return header.axis_version.value_or(reading.axis_version); }
  const std::map<int, Tool>& tools() const {
    return dialect == Dialect::Excellon ? header.tools : layout.tools;
  }
  const std::map<int, int>& tool_lines() const {
    return dialect == Dialect::Excellon ? header.tool_lines : layout.tool_lines;
  }
  /// How numbers are read: "inch 2.4, leading zeros kept".
  std::string number_summary() const;
};

}  // namespace panelcal
