// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string_view>

#include "panelcal/program/excellon/lexer.h"
#include "panelcal/program/excellon/reporter.h"
#include "panelcal/program/operation.h"

namespace panelcal::excellon {

/// `#/#/#` links tools (CNC-7 manual, Link Tools for Automatic Tool Changers).
bool is_tool_link(std::string_view text);

/// A block that begins with T, read.
struct ToolBlock {
  Tool tool;
  std::optional<int> compensation_index;
};

/// Reads `T#(#)(C#)(F#)(S#)(B#)(H#)(Z#)`.
///
/// A number of three or four digits is a tool and a compensation index, unless `defined` holds that
/// very number (CAM output beyond T99); without `defined`, in a header, it is always the number.
///
/// Fails  into the log: number-malformed, number-too-long, argument-invalid, block-not-alone
/// Source CNC-7 manual, Tool Commands
std::optional<ToolBlock> read_tool_block(const Block& block,
                                         const NumberFormat& format,
                                         const std::map<int, Tool>* defined,
                                         const Reporter& reporter);

}  // namespace panelcal::excellon
