// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "program/excellon/text/lexer.h"
#include "program/model/operation.h"
#include "program/model/tool_links.h"
#include "program/walk/reporter.h"

namespace panelcal::excellon {

/// The tool has data that the program's unit measures: lengths, feeds.
bool has_dimension(const Tool& tool);

/// A block that begins with T, read.
struct ToolBlock {
  Tool tool;
  std::optional<int> compensation_index;
  bool turns_hits_off = false;  ///< H without a number
};

/// The settings that decide how a tool block is read.
struct ToolContext {
  const NumberFormat& format;
  const std::map<int, Tool>* defined;      ///< by the header; null while the header is read
  const std::vector<Tool>& diameter_page;  ///< the machine's tool data by diameter
};

/// Reads `T#(#)(C#)(F#)(S#)(B#)(H#)(Z#)` from left to right: a diameter loads the data of the
/// diameter page over what stands to its left.
///
/// A number of three or four digits is a tool and a compensation index, unless `defined` holds that
/// very number (CAM output beyond T99); without `defined`, in a header, it is always the number,
/// and T0100 to T0999 are refused: they are tools 1 to 9 in the body, and CAM systems may mean 100
/// to 999.
///
/// Fails  into the log: number-malformed, number-too-long, argument-invalid, block-not-alone
/// Source CNC-7 manual, Tool Commands; Hierarchy of Tool Commands
std::optional<ToolBlock> read_tool_block(const Block& block,
                                         const ToolContext& context,
                                         const Reporter& reporter);

/// The first length of a tool block that has zeros beyond the digits of the format; null: none has.
///
/// Precondition: read_tool_block() has read it
const Word* padded_length(const Block& block, const NumberFormat& format);

/// Reads the F# or B# of a block of its own into `tool`; `routing` says which range F has.
bool read_rate(const Block& block,
               const Word& word,
               const NumberFormat& format,
               bool routing,
               const Reporter& reporter,
               std::optional<Feed>& out);

}  // namespace panelcal::excellon
