// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "program/sieb_meyer/sections/copies.h"
#include "program/sieb_meyer/text/numbers.h"
#include "program/text/source_text.h"
#include "program/walk/reporter.h"

namespace panelcal::sieb_meyer {

/// The sections of a text, and which of them no other one holds.
struct SectionTree {
  std::vector<Section> sections;
  std::vector<int> roots;
  bool is_sound = true;  ///< no error was reported
};

/// The offset lines of a subprogram that has nothing else, from its own zero point.
struct Layout {
  std::vector<CopyRow> rows;
  bool is_sound = true;  ///< no error was reported
};

/// A subprogram of offset lines alone, by its name; null if it works, or if there is none. The
/// second argument: lines that begin with / are left out.
using FindLayout = std::function<const Layout*(std::string_view name, bool deletes_blocks)>;

struct SectionRules {
  ProgramFormat format;
  bool deletes_blocks = false;
  bool in_subprogram = false;
  int depth = 0;  ///< levels that are open where the text is called
  FindLayout find_layout = {};
};

inline constexpr int kMostLevels = 6;

/// Finds all sections between two places of a text.
///
/// Fails  into the reporter: section-unbalanced (at the bracket that is open), section-mixed,
///        nesting-too-deep, argument-invalid, command-format, number-malformed
/// Source SIEB & MEYER CNC 8x.00 Command Set, chapter 5
/// See    tests/program/sieb_meyer/sections/sections_test.cc, section_refusals_test.cc
SectionTree scan_sections(std::string_view bytes,
                          LinePlace begin,
                          std::size_t end,
                          const SectionRules& rules,
                          const Reporter& reporter);

/// Finds the offset lines of a subprogram between two places of a text; absent if it has others.
///
/// Fails  into the reporter: section-mixed (a bracket), argument-invalid, number-malformed
/// Source SIEB & MEYER CNC 8x.00 Command Set, 6 Subprograms: "Mixing working blocks and offset
///        blocks in subroutines is not allowed", so that either may stand alone
std::optional<Layout> scan_layout(std::string_view bytes,
                                  LinePlace begin,
                                  std::size_t end,
                                  const SectionRules& rules,
                                  const Reporter& reporter);

}  // namespace panelcal::sieb_meyer
