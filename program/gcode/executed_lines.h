// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "program/text/source_text.h"

namespace panelcal::gcode {

/// A line in the order of execution.
struct ExecutedLine {
  SourceLine line;
  bool is_order = false;   ///< of a subprogram or a repetition, `o100 call`: obeyed already
  bool is_inside = false;  ///< of a subprogram, whose variables are its own
};

/// Walks over the lines of a program as they are executed: subprograms where they are called,
/// repeated lines as often as they are repeated.
///
/// Understood: `sub`, `endsub`, `return`, `call` without arguments of a subprogram that stands
/// above in the file, `repeat [#]` with a number, `endrepeat`.
///
/// Source LinuxCNC, O Codes
/// See    tests/program/gcode/executed_lines_test.cc
class ExecutedLines {
 public:
  /// Precondition: the program outlives this.
  explicit ExecutedLines(const SourceText& program) : program_(program), cursor_(program.bytes) {}

  /// The next line; absent at the end.
  ///
  /// Fails  not-supported: other words of O, arguments, numbers that are computed, a subprogram
  ///        that does not stand above, more than a million lines; command-unknown: an end without
  ///        a begin, or the other way round; subprogram-recursive
  Expected<std::optional<ExecutedLine>> next();

 private:
  /// `o100 repeat [3]`: name, keyword, and what follows without comments.
  struct Order {
    std::string name;
    std::string keyword;
    std::string argument;
  };
  /// A subprogram or a repetition that is being executed.
  struct Frame {
    std::string name;
    bool is_call = false;
    LinePlace back;      ///< call: behind it; repetition: its first line
    long n_further = 0;  ///< of a repetition
  };

  std::optional<Order> read_order(std::string_view text) const;
  Expected<void> obey(const SourceLine& line, const Order& order);
  Expected<void> define(const SourceLine& line, const Order& order);
  Expected<void> call(const SourceLine& line, const Order& order);
  Expected<void> return_from(const SourceLine& line, const Order& order);
  Expected<void> repeat(const SourceLine& line, const Order& order);
  Expected<void> repeat_again(const SourceLine& line, const Order& order);
  Expected<void> skip_to(const SourceLine& line, const Order& order, std::string_view keyword);
  tl::unexpected<Diagnostic> problem(const SourceLine& line, Code code, std::string expected) const;

  const SourceText& program_;
  LineCursor cursor_;
  std::map<std::string, LinePlace> subprograms_;  ///< the places of their first lines
  std::vector<Frame> frames_;
  long n_lines_ = 0;
};

}  // namespace panelcal::gcode
