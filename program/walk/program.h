// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "program/model/operation.h"
#include "program/model/program_head.h"
#include "program/text/source_text.h"
#include "program/walk/options.h"

namespace panelcal {

/// A program that has been read as far as its header.
struct Program {
  SourceText source;
  Dialect dialect = Dialect::Excellon;
  std::shared_ptr<const ProgramHead> head = std::make_shared<ProgramHead>();  ///< never null
  /// The stored patterns or subprograms it names.
  std::map<std::string, SourceText, std::less<>> patterns;
  ReadOptions reading;

  bool deletes_blocks() const;  ///< blocks that begin with / are left out
  int axis_version() const { return head->axis_version.value_or(reading.axis_version); }
  const std::map<int, Tool>& tools() const { return head->tools; }
  const std::map<int, int>& tool_lines() const { return head->tool_lines; }
  /// Number format for people: "inch 2.4, leading zeros kept".
  std::string number_summary() const { return head->number_summary(); }
};

}  // namespace panelcal
