// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "program/model/operation.h"
#include "program/text/number_format.h"

namespace panelcal {

/// The statements of a program before its first block, whatever its language: a header, a tool
/// table. Each language adds its own.
struct ProgramHead {
  ProgramHead() = default;
  ProgramHead(const ProgramHead&) = default;
  ProgramHead(ProgramHead&&) = default;
  ProgramHead& operator=(const ProgramHead&) = default;
  ProgramHead& operator=(ProgramHead&&) = default;
  virtual ~ProgramHead() = default;

  std::map<int, Tool> tools;
  std::map<int, int> tool_lines;     ///< line of each tool's definition
  std::optional<int> axis_version;   ///< VER
  std::optional<bool> block_delete;  ///< BLKD: blocks that begin with / are not executed
  bool body_rules = false;           ///< OM48: the body's tool data win
  /// The file beside the program that has decided how its numbers are read; empty: none has.
  std::string format_file;

  /// The format in which writers state numbers.
  virtual NumberFormat number_format() const { return {}; }
  /// Its digits are stated by the program or by the operator.
  virtual bool declares_digits() const { return true; }
  /// Reading of numbers: "inch 2.4, leading zeros kept".
  virtual std::string number_summary() const { return {}; }
  /// "Excellon, metric 3.3, trailing zeros kept (line 9: METRIC,TZ)": the language, how numbers are
  /// read, and why.
  virtual std::string reading() const { return {}; }
};

}  // namespace panelcal
