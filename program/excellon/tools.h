// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "panelcal/program/excellon/lexer.h"
#include "panelcal/program/excellon/reporter.h"
#include "panelcal/program/operation.h"

namespace panelcal::excellon {

/// `#/#/#` links tools (CNC-7 manual, Link Tools for Automatic Tool Changers).
bool is_tool_link(std::string_view text);

/// Adds the tools of a link to `used` if one of them is in it: spares are used too.
void add_linked_tools(std::string_view text, std::set<int>& used);

/// Takes from `other` what `tool` does not say.
void fill_missing(Tool& tool, const Tool& other);

/// A block that begins with T, read.
struct ToolBlock {
  Tool tool;
  std::optional<int> compensation_index;
  bool turns_hits_off = false;  ///< H without a number
};

/// What decides how a tool block is read.
struct ToolContext {
  const NumberFormat& format;
  const std::map<int, Tool>* defined;      ///< by the header; null while the header is read
  const std::vector<Tool>& diameter_page;  ///< the machine's tool data by diameter
};

/// Reads `T#(#)(C#)(F#)(S#)(B#)(H#)(Z#)` from left to right: a diameter loads the data of the
/// diameter page over what stands to its left.
///
/// A number of three or four digits is a tool and a compensation index, unless `defined` holds that
/// very number (CAM output beyond T99); without `defined`, in a header, it is always the number.
///
/// Fails  into the log: number-malformed, number-too-long, argument-invalid, block-not-alone
/// Source CNC-7 manual, Tool Commands; Hierarchy of Tool Commands
std::optional<ToolBlock> read_tool_block(const Block& block,
                                         const ToolContext& context,
                                         const Reporter& reporter);

/// Reads the F# or B# of a block of its own into `tool`; `routing` says which range F has.
bool read_rate(const Block& block,
               const Word& word,
               const NumberFormat& format,
               bool routing,
               const Reporter& reporter,
               std::optional<Feed>& out);

/// Which tool takes over when one is used up (CNC-7 manual, Link Tools).
class ToolLinks {
 public:
  /// Precondition: is_tool_link(text).
  void link(std::string_view text);
  void clear() { groups_.clear(); }
  /// The tool right of `tool` in its group, counting round.
  std::optional<int> next(int tool) const;

 private:
  std::vector<std::vector<int>> groups_;
};

}  // namespace panelcal::excellon
