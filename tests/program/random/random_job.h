// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/model/placement.h"
#include "program/text/number_format.h"
#include <rapidcheck.h>

namespace panelcal::test {

// Parts of the language that jobs leave out while panelcal has a known fault there. `true` turns a
// part on; the comment says what goes wrong.

/// M71 or M72 in the body, against the header's unit: the plain Excellon writer passes rates of the
/// body (`F020`) on as written, but states the header's unit.
inline constexpr bool kUnitOfTheBody = true;
/// F# in drill mode behind routs: the writer goes back to drill mode only with the next hole, so
/// that the tool's infeed becomes the table's feed.
inline constexpr bool kInfeedBehindRouts = true;
/// T#H, which ends a limit on hits that the body set: the writer has no word for it.
inline constexpr bool kHitLimitEnds = true;
/// G87 in step and repeat: where a copy begins with the control's own feed after one that set
/// another, the writer says F# in drill mode, so that it becomes the tool's infeed.
inline constexpr bool kStepSlotsInCopies = true;

/// Part of a job's spelling: a code, letters, or a letter with a length behind it.
struct Token {
  std::string text;             ///< as in Format Two
  std::optional<long> steps{};  ///< of the last digit of the job's format
  int style = 0;                ///< way to write the same number
};
using TokenLine = std::vector<Token>;

/// A random program, before it is decided how its numbers and codes are spelled.
struct Job {
  NumberFormat format;              ///< of the body
  NumberFormat header_format;       ///< another one where the body changes the unit
  std::vector<std::string> header;  ///< lines between the format and the end of the header
  std::string header_end;
  std::vector<TokenLine> preamble;  ///< lines that have to come before any target
  std::vector<TokenLine> body;      ///< begins with absolute X and Y, ends the program

  Length step() const;
};

struct Spelling {
  enum class Digits : std::uint8_t { LeadingZeros, TrailingZeros, Point };
  Digits digits = Digits::LeadingZeros;
  bool is_format_one = false;
};

/// The program; `targets` are lines that measure, in front of the body.
std::string text_of(const Job& job, const Spelling& spelling, std::string_view targets = {});
/// In leading zeros and Format Two.
std::ostream& operator<<(std::ostream& out, const Job& job);

/// A random valid job of everything but vision and stored patterns: holes, cycles, texts, contours
/// of lines and arcs, routed circles and step slots, tools, feeds, stops and events, alone and in
/// nested step and repeat. No arc is shorter than a few steps.
rc::Gen<Job> random_job();
/// The same with cycles that not every tool can do and copies that put the tool away, so that a
/// copy may fail where the pattern itself does not.
rc::Gen<Job> random_bold_job();

/// A pattern of contours without tool changes, and the copies that are made of it.
struct RoutedPattern {
  Job job;                                   ///< only the pattern, as a program
  std::vector<std::vector<CopyRun>> levels;  ///< innermost first; steps in steps of the format
  Job repeated;                              ///< the same pattern in step and repeat
};
rc::Gen<RoutedPattern> random_routed_pattern();
std::ostream& operator<<(std::ostream& out, const RoutedPattern& pattern);

}  // namespace panelcal::test
