// SPDX-License-Identifier: Apache-2.0
// Meaning of single lines for the structure of a program.
#pragma once

#include <optional>
#include <string_view>

#include "program/sieb_meyer/sections/copies.h"
#include "program/sieb_meyer/text/lexer.h"

namespace panelcal::sieb_meyer {

/// Meaning of a line for the structure.
struct LineRole {
  int n_open = 0;
  int n_close = 0;
  bool is_offset = false;
  bool moves = false;         ///< it has a coordinate or a call
  bool closes_first = false;  ///< an M30 stands before an M31
  bool works = false;         ///< it asks for something, besides what closes a section with it
  bool states_axes = false;   ///< M49,FV alone
  std::optional<bool> deletes_blocks;
  SectionContent has;
};

LineRole role_of(const Block& block);

/// The line has a coordinate, if it is one that may not matter.
bool has_coordinate(std::string_view line);

/// The line has a letter or sign that brackets, offsets, measurements or feeds begin with.
bool may_matter(std::string_view line);

}  // namespace panelcal::sieb_meyer
