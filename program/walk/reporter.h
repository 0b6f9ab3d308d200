// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/diagnostic.h"
#include "program/text/mark.h"
#include "program/text/number_format.h"
#include "program/text/source_text.h"
#include "program/text/word.h"

namespace panelcal {

/// Puts problems of one file into the log, each once: the copies of a pattern would only repeat it.
class Reporter {
 public:
  enum class Level : std::uint8_t { All, ErrorsOnly };

  /// ErrorsOnly is for a second walk: the first has given all warnings.
  ///
  /// In     working: where problems go that only a working walk finds; null: into the log as well
  Reporter(std::string file,
           DiagnosticLog& log,
           Level level = Level::All,
           DiagnosticLog* working = nullptr)
      : file_(std::move(file)),
        log_(&log),
        working_(working == nullptr ? &log : working),
        level_(level) {}

  void report(Code code, int line, int column, std::string what, std::string expected = "") const {
    add({code, {file_, line, column}, std::move(what), std::move(expected)}, level_, *log_);
  }

  /// The same of words of the program.
  void report(Code code, const Mark& mark, std::string expected = "") const {
    report(code, mark.line, mark.column, mark.what, std::move(expected));
  }
  /// The same, with `about` behind what the words are.
  void report(Code code, const Mark& mark, const std::string& about, std::string expected) const {
    report(code, mark.line, mark.column, mark.what + about, std::move(expected));
  }
  /// The same of what begins where a line does.
  void report(Code code, int line, std::string what, std::string expected = "") const {
    report(code, line, 1, std::move(what), std::move(expected));
  }
  /// Reports a line that is no block.
  void report_syntax(int line, const LexFault& fault) const {
    report(Code::BlockSyntax, line, fault.column, quoted(fault.text), std::string(fault.expected));
  }

  /// The same for an error that only a working walk finds.
  void report_working(
      Code code, int line, int column, std::string what, std::string expected = "") const {
    add({code, {file_, line, column}, std::move(what), std::move(expected)},
        Level::ErrorsOnly,
        *working_);
  }

  /// Reports a number that parse_length refused.
  void report_number(NumberFault fault,
                     std::string_view text,
                     int line,
                     int column,
                     const NumberFormat& format) const {
    if (fault == NumberFault::TooManyDigits) {
      const int digits = format.integer_digits + format.decimal_digits;
      report(Code::NumberTooLong,
             line,
             column,
             quoted(text),
             "at most " + std::to_string(digits) + " digits (" + format.summary() + ")");
    } else {
      report(Code::NumberMalformed,
             line,
             column,
             quoted(text),
             "a sign, digits and at most one decimal point");
    }
  }

  /// Warns of a number with zeros beyond the digits of its format, which parse_length reads.
  void report_padded(std::string_view word,
                     int line,
                     int column,
                     const NumberFormat& format) const {
    const int digits = format.integer_digits + format.decimal_digits;
    report(Code::NotationAccepted,
           line,
           column,
           quoted(word) + " has zeros beyond " + format.summary(),
           "at most " + std::to_string(digits) + " digits");
  }

  /// Reports a text that stops before its end, where `expected` should stand.
  void report_end_missing(std::string_view text, std::string expected) const {
    const SourceLine last = last_line(text);
    if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
      report(Code::EndMissing, 1, 0, "the file is empty", std::move(expected));
    } else if (ends_in_line_end(text)) {
      report(Code::EndMissing,
             last.number + 1,
             0,
             quoted(last.text) + " is the last line",
             std::move(expected));
    } else {
      report(Code::EndMissing,
             last.number,
             0,
             quoted(last.text) + " has no line end",
             std::move(expected));
    }
  }

  /// Errors of the input, also those that were reported before.
  std::int64_t n_refused() const { return n_refused_; }
  const std::string& file() const { return file_; }
  /// Problems belong to another file from here on.
  void set_file(std::string file) { file_ = std::move(file); }

 private:
  void add(Diagnostic diagnostic, Level level, DiagnosticLog& log) const {
    const CodeInfo& code = info(diagnostic.code);
    if (code.severity == Severity::Error && code.fault == Fault::Input) ++n_refused_;
    if (level == Level::ErrorsOnly && diagnostic.severity() != Severity::Error) return;
    if (reported_.size() < DiagnosticLog::kKept && !reported_.insert(diagnostic.text()).second) {
      return;
    }
    log.add(std::move(diagnostic));
  }

  std::string file_;
  DiagnosticLog* log_;
  DiagnosticLog* working_;
  Level level_;
  mutable std::int64_t n_refused_ = 0;
  mutable std::set<std::string> reported_;
};

}  // namespace panelcal
