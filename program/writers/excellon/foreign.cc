// SPDX-License-Identifier: Apache-2.0
// A SIEB & MEYER program's own orders in Excellon.
#include <string>
#include <string_view>
#include <utility>

#include "program/writers/excellon/writer.h"
#include "program/writers/foreign_settings.h"
#include <fmt/format.h>

namespace panelcal {

/// The axis version, which the source states in its body, and the diameters that it compensates
/// for.
void ExcellonWriter::put_foreign_header() {
  lose_tool_table();
  line(fmt::format("VER,{}", info().axis_version));
  for (const auto& [number, tool] : info().tools) {
    if (!tool.diameter) continue;
    text() += fmt::format("CP,{}", number);
    append_length(',', *tool.diameter);
    text() += '\n';
  }
}

/// The manual's depths are those of the machine's set-up and offsets from them. H is a setting of
/// its own, which is lost where it stands.
void ExcellonWriter::refuse_cut(const DepthOfCut& cut) {
  if (cut.is_controlled() && !cut.depth) {
    refuse(fmt::format("a depth below the board's surface that the operator sets ({} without K#)",
                       cut.control == DepthControl::Slm ? "G71" : "G83"));
  } else if (cut.is_controlled()) {
    refuse(fmt::format("a depth of {:g} mm below the board's surface", cut.depth->in_mm()));
  } else if (cut.z) {
    refuse(fmt::format("the working plane Z{:g}", cut.z->in_mm()),
           "depth offsets of tools (Z in the $ table)");
  }
}

/// What this language says is in other operations as well.
void ExcellonWriter::write(const OpticalOrder& order) {
  if (!is_foreign() || order.remedy.empty()) return;
  refuse(order.problem.empty() ? quoted(order.text) : std::string(order.problem),
         std::string(order.remedy));
}

/// Where structure is not kept, strokes have what the orders lead to. Strokes below a probed
/// surface are refused, but the planes of others go on without the grid that moves them.
void ExcellonWriter::write(const SurfaceOrder& order) {
  if (!options().keeps_vision) return;
  switch (order.kind) {
    case SurfaceOrderKind::Switch:
    case SurfaceOrderKind::Skip:
      return;
    case SurfaceOrderKind::GridReference:
    case SurfaceOrderKind::GridPoint:
      if (std::exchange(has_grid_, true)) return;
      return refuse("a measured grid that moves the working plane (G78, G79)",
                    "`panelcal run`, or a board without it");
    default:
      return lose_once("probing of the surface (G72 to G76, L#)");
  }
}

/// M47 shows 20 characters.
void ExcellonWriter::put_foreign_message(std::string_view message) {
  constexpr std::size_t kShown = 20;
  std::string shown = printable(words_of(message));
  if (shown.ends_with('\\')) shown.back() = '/';
  line((shown.size() > kShown ? "M45," : "M47,") + shown);
}

void ExcellonWriter::put_foreign_setting(const Setting& setting) {
  if (setting.kind == SettingKind::Vision && !options().keeps_vision) {
    return lose_vision(setting);
  }
  constexpr std::string_view kCommand = "M49,";
  if (setting.text.starts_with(kCommand)) {
    const std::string_view command = setting.text.substr(kCommand.size());
    // The walk has obeyed them, or the header states them.
    if (command.starts_with("FV") || command == "CAMA" || command == "NOCAMA") return;
    if (is_initial(command, setting.unit)) return;
  }
  lose(quoted(setting.text));
}

}  // namespace panelcal
