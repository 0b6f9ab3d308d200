// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "program/excellon/text/lexer.h"
#include "program/model/placement.h"
#include "program/text/source_text.h"
#include "program/walk/reporter.h"

namespace panelcal::excellon {

/// Equally spaced copies, and the tool that an M02 block may take for them.
struct Copies {
  CopyRun run;
  std::optional<Word> tool;
  int line = 0;
};

/// The settings that decide how the lines of a section are read.
struct SectionContext {
  const NumberFormat& format;
  ProgramSet set = ProgramSet::FormatTwo;
  bool deletes_blocks = false;
  int line_of_open_count = 0;  ///< line_of_open_count of the section before
};

/// A step and repeat section, from M25 to M08.
struct RepeatSection {
  int line = 0;                             ///< of M25
  LineCursor pattern;                       ///< stands on the pattern's first line
  std::size_t pattern_end;                  ///< offset of the M01 that ends it
  std::vector<std::vector<Copies>> levels;  ///< one per M01, innermost first
  LineCursor after;                         ///< stands behind M08
  Block closing;                            ///< the M08 block; M30 or M00 may follow in it
  bool changes_tools = false;               ///< in the pattern or in an M02 block
  /// The pattern measures, calibrates, or moves through stored corrections.
  bool has_vision = false;
  /// The last M02 block with X or Y, if no M02 alone has ended its offsets; else 0. Those of R#M02
  /// end by themselves: the manual's sample program has none behind.
  int line_of_open_count = 0;
  /// The first M02 block that counts anew behind such offsets, and the line of those.
  std::optional<std::pair<Block, int>> count_behind_open_one;
  /// The first M02 block with M70 ahead of a mirror.
  std::optional<Block> swap_before_mirror;
};

inline constexpr std::size_t kMaxLevels = 64;

/// Reads the structure of a section ahead of its execution. `from` stands behind M25.
///
/// Fails  into the log: repeat-unclosed, command-misplaced, argument-invalid, nesting-too-deep
/// Source CNC-7 manual, Step and Repeat Commands; Nested Step and Repeat Commands
std::optional<RepeatSection> scan_section(LineCursor from,
                                          int line,
                                          const SectionContext& context,
                                          const Reporter& reporter);

}  // namespace panelcal::excellon
