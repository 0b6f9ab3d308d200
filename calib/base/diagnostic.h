// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace panelcal {

enum class Severity : std::uint8_t { Warning, Error };

/// Party at fault: this decides the exit code (docs: contract, "Exit codes").
enum class Fault : std::uint8_t { Input, Gate, Device, Internal };

/// Every problem panelcal can report; the catalogue is diagnostic_codes.def.
enum class Code : std::uint8_t {
#define PANELCAL_DIAGNOSTIC(name, slug, severity, fault, summary, advice) name,
#include "calib/base/diagnostic_codes.def"
};

struct CodeInfo {
  Code code;
  std::string_view slug;
  Severity severity;
  Fault fault;
  std::string_view summary;
  std::string_view advice;
};

/// The catalogue, in the order of the .def file.
std::span<const CodeInfo> diagnostic_catalogue();
const CodeInfo& info(Code code);

/// A place in a text; line and column count from 1, 0 means that there is none.
struct Place {
  std::string file;
  int line = 0;
  int column = 0;
};

/// One problem: its place, its kind, the offending text, and the remedy.
struct Diagnostic {
  Code code;
  Place place;
  std::string what;  ///< the offending text, in quotes, or its facts; empty: the summary says all
  std::string expected;  ///< the remedy; may be empty

  Severity severity() const { return info(code).severity; }

  /// `FILE:LINE:COLUMN: error[CODE]: SUMMARY: WHAT; expected REMEDY`, as a compiler prints it. A
  /// line or column of 0 is left out, and so is an empty part.
  std::string text() const;
  /// `SUMMARY: WHAT`, for a sentence that has its own place.
  std::string message() const;
};

/// Collects the diagnostics of one pass. Keeps the first `kKept` of each severity and counts the
/// rest, so that a damaged file of a million lines cannot fill the memory, and a flood of warnings
/// cannot hide an error.
class DiagnosticLog {
 public:
  static constexpr std::size_t kKept = 200;

  void add(Diagnostic diagnostic);
  std::span<const Diagnostic> kept() const { return kept_; }
  bool has_errors() const { return n_errors_ > 0; }
  std::size_t n_errors() const { return n_errors_; }
  std::size_t n_warnings() const { return n_warnings_; }
  std::size_t n_dropped() const { return n_errors_ + n_warnings_ - kept_.size(); }

 private:
  std::vector<Diagnostic> kept_;
  std::size_t n_errors_ = 0;
  std::size_t n_warnings_ = 0;
};

/// The word of `known` nearest to `word` by edit distance, empty if none is near enough to be
/// meant: one letter differs, or at most a third of them.
std::string_view nearest_word(std::string_view word, std::span<const std::string_view> known);

/// `text` without what could steer a terminal: control characters but those of `kept` as \xNN, also
/// U+0080 to U+009F of UTF-8. Other bytes stay, so that names in any language can be read.
std::string escaped_controls(std::string_view text, std::string_view kept = {});

/// `text` as it can stand in a message: control and non-ASCII bytes as \xNN, cut at `max_length`.
std::string quoted(std::string_view text, std::size_t max_length = 60);
/// Without these, argument-dependent look-up would take std::quoted for a std::string.
inline std::string quoted(const std::string& text, std::size_t max_length = 60) {
  return quoted(std::string_view(text), max_length);
}
inline std::string quoted(std::string& text, std::size_t max_length = 60) {
  return quoted(std::string_view(text), max_length);
}
inline std::string quoted(const char* text, std::size_t max_length = 60) {
  return quoted(std::string_view(text), max_length);
}

}  // namespace panelcal
