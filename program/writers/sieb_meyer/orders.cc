// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER's orders instead of the other language's settings, functions, patterns and vision
// commands.
#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "program/model/tool_links.h"
#include "program/sieb_meyer/text/lexer.h"
#include "program/writers/foreign_settings.h"
#include "program/writers/pattern_copies.h"
#include "program/writers/sieb_meyer/writer.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// The word of a line that probes, which is executed before the output is.
constexpr std::string_view kDummyTool = "TD";

/// Storage locations (G39,SAVEn): copies have theirs by their numbers from 1, the board the last.
constexpr std::size_t kLocations = 1000;

/// Command that has to stand before a function's text, which is not always a command by itself.
std::string_view command_before(const Function& function) {
  if (function.kind == FunctionKind::TextForDevice) return "M76,";
  if (function.kind != FunctionKind::MachineFunction) return "";
  const bool has_code = sieb_meyer::command_of({'M', 0, function.text.substr(1)}).has_value();
  return has_code ? "" : "M49,";
}

}  // namespace

// --- functions and settings --------------------------------------------------------------------

void SiebMeyerWriter::write(const Function& function) {
  if (function.text.empty()) return;  // the control does it by itself
  if (!is_foreign()) {
    if (function.text == kDummyTool) {
      probing_tool_ = kDummyTool;
      return;
    }
    if (function.is_at_place && function.text == "M21") {
      place_words().has_output = true;
      return;
    }
    note_pecking(function.kind);
    if (function.kind == FunctionKind::FinishRouting) {
      rout_words_ = function.text;
      return;
    }
    return line(std::string(command_before(function)) + std::string(function.text));
  }
  switch (function.kind) {
    case FunctionKind::ScalingOn:
      return refuse("reference scaling (" + std::string(function.text) + ")",
                    "[reference_scaling] in machine.toml and `panelcal run`");
    case FunctionKind::ScalingOff:
    case FunctionKind::ToolExpired:
      return;
    default:
      return lose(fmt::format("{} ({})", quoted(function.text), name(function.kind)));
  }
}

void SiebMeyerWriter::note_pecking(FunctionKind kind) {
  if (kind == FunctionKind::PeckOn) pecks_ = true;
  if (kind == FunctionKind::PeckOff) pecks_ = false;
  if (kind == FunctionKind::PulseOn) pulses_ = true;
  if (kind == FunctionKind::PulseOff) pulses_ = false;
}

void SiebMeyerWriter::write(const Setting& setting) {
  if (is_foreign()) return write_foreign(setting);
  if (setting.kind == SettingKind::Vision && !options().keeps_vision) {
    // The others were executed.
    if (setting.text.starts_with("M75")) lose(quoted(setting.text));
    return;
  }
  constexpr std::string_view kCommand = "M49,";
  constexpr std::string_view kAxes = "M49,FV";
  if (setting.text.starts_with(kAxes)) {
    const int version = parse_count(setting.text.substr(kAxes.size())).value_or(1);
    if (!states_control_) return state_control(version);
    line(setting.text);
    return write_in_axes(version);
  }
  if (setting.text.starts_with(kCommand) && is_obeyed(setting.text.substr(kCommand.size()))) return;
  line(setting.text);
}

void SiebMeyerWriter::write_foreign(const Setting& setting) {
  const std::string_view key = setting_key(setting.text);
  if (is_spelling(key)) return;
  if (setting.kind == SettingKind::Vision) {
    if (!options().keeps_vision || setting.text.starts_with("$uvis,alg,")) return;
    if (key == "G34") return refuse(quoted(setting.text), "G34,# with one vision tool");
  }
  if (is_tool_link(setting.text) || setting.text == "/") return lose_once("a link of tools");
  if (decides_places(key)) return refuse(quoted(setting.text));
  lose(quoted(setting.text));
}

// --- patterns ----------------------------------------------------------------------------------

/// The control does not know at the begin of a copy what it was told before the pattern.
void SiebMeyerWriter::write(const PatternBegin&) {
  say_tool();
  line("M31");
  ++n_open_patterns_;
  pattern_ = {};
  up_at_.reset();
  feed_.reset();
  begin_depths_of_copy();
  pattern_mode_.reset();
}

/// Source SIEB & MEYER CNC 8x.00 Command Set, 5.3, 5.5
void SiebMeyerWriter::write(const PatternEnd& end) {
  say_tool();
  finish_line();
  end_depths_of_copy();
  const Placement in_place;
  const std::span<const Placement> copies =
      end.copies.empty() ? std::span<const Placement>(&in_place, 1) : end.copies;
  const Eigen::Matrix2d back = written_from_work().transpose();
  for (const Placement& copy : copies) {
    const std::string_view command = offset_command(written_from_work() * copy.linear() * back);
    if (command.empty()) {
      refuse("a copy turned by other than quarter turns");
      continue;
    }
    finish_line();
    append_point(copy.translation(), "XY");
    line_ += command;
  }
  line_ += "M30";
  finish_line();
  --n_open_patterns_;
  up_at_.reset();
  feed_.reset();
  pattern_mode_.reset();
  refuse_uneven_copies(copies.size());
  keeps_copies_ = false;
  if (std::exchange(pattern_, {}).has_offset) {
    // It ends with the copy; Excellon's goes on until it is cancelled.
    if (nested_ == Nested::InForce) nested_ = Nested::Ended;
    if (nested_ == Nested::Cancelled) nested_ = Nested::None;
  }
}

/// What the second copy would not do as the first does.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9, G39 (1000 storage locations)
void SiebMeyerWriter::refuse_uneven_copies(std::size_t n_copies) {
  const bool leaves_offset = pattern_.has_offset && nested_ == Nested::InForce;
  if (leaves_offset && pattern_.works_ahead && n_copies > 1) {
    refuse("a place in a copy under the nested correction of the copy before",
           "G47 at the pattern's end");
  }
  if (!pattern_.has_kept) return;
  n_kept_copies_ = n_copies;
  const std::size_t most = kLocations - (uses_board_location_ ? 1 : 0);
  if (n_copies > most) {
    refuse(fmt::format("a pattern of {} copies that store corrections", n_copies),
           fmt::format("at most {}", most));
  }
}

// --- vision ------------------------------------------------------------------------------------

/// Targets are looked for where they are nominally, so a correction in force is cleared first.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9, G31 to G34
void SiebMeyerWriter::write(const VisionSeries& series) {
  if (series.level == CorrectionLevel::Nested) return write_nested(series);
  if (n_open_patterns_ > 0 && pattern_.restores_board) {
    refuse("a base series behind G47 in its pattern", "G47 before the pattern");
  }
  if (has_base_ || n_open_patterns_ > 0 || is_replaced_) clear_corrections();
  measure_targets(series);
  n_board_targets_ = series.targets.size();
  has_base_ = true;
  is_board_saved_ = is_replaced_ = false;
}

/// Also what is nested; but an offset from outside of patterns comes back behind the copy.
void SiebMeyerWriter::clear_corrections() {
  line("G34");
  if (n_open_patterns_ > 0) return;
  has_outer_offset_ = false;
  pattern_.n_nested_targets = 0;
}

void SiebMeyerWriter::measure_targets(const VisionSeries& series) {
  for (const Position<frame::Nominal>& target : series.targets) {
    finish_line();
    append_point(target.in_mm(), "XY");
    line_ += "G32";
  }
  line("G31");
  nested_ = Nested::None;
  up_at_.reset();
}

/// Two targets give no stretch, so that they cannot repeat what a board of three has.
bool SiebMeyerWriter::may_be_whole(const VisionSeries& series) const {
  const std::size_t n_board = has_base_ ? n_board_targets_ : 0;
  return series.targets.size() > 2 || (series.targets.size() == 2 && n_board <= 2);
}

/// A nested series of several targets whose correction the copy keeps. This control nests no more
/// than an offset, but what it fits to the same targets, from where they are nominally, is the
/// copy's whole correction. The board's is in force before, so that targets are found.
void SiebMeyerWriter::write_whole(const VisionSeries& series) {
  if (pattern_.cancels_ahead) refuse_cancel_ahead();
  switch_pattern_mode(false);
  is_replaced_ = true;
  restore_board();
  measure_targets(series);
  is_replaced_ = true;
  ++pattern_.n_nested_targets;
}

/// In the first copy there may be nothing to cancel, in the second there is.
void SiebMeyerWriter::refuse_cancel_ahead() {
  refuse("G47 ahead of the targets in a pattern that stores its corrections",
         "G47 before the pattern, or at its end");
}

/// Puts the base correction in force where that of a copy has replaced it.
void SiebMeyerWriter::restore_board() {
  if (!std::exchange(is_replaced_, false)) return;
  line(has_base_ ? fmt::format("G39,LOAD{}", kLocations) : "G34");
  up_at_.reset();
  pattern_.restores_board = n_open_patterns_ > 0;
}

/// The control takes a second target of one copy, or of the program outside of patterns, together
/// with the first, and an offset from outside comes back behind a copy that has its own.
bool SiebMeyerWriter::refuse_second_nested() {
  const bool is_executed = is_foreign() || nested_ == Nested::Cancelled;
  if (!is_executed || (pattern_.n_nested_targets == 0 && !has_outer_offset_)) return false;
  refuse("a second nested correction", "one for each copy of a pattern");
  return true;
}

/// All targets of a copy give one offset, so that a second series would change the first.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9, G36 (CAMA)
void SiebMeyerWriter::write_nested(const VisionSeries& series) {
  if (has_outer_offset_ && refuse_second_nested()) return;
  if (keeps_copies_ && pattern_.n_nested_targets == 0 && may_be_whole(series)) {
    return write_whole(series);
  }
  if (is_foreign() && series.targets.size() > 1) {
    return refuse(fmt::format("a nested series of {} targets", series.targets.size()),
                  "one target (G45): the offset of a pattern is all that SIEB & MEYER nests");
  }
  if (refuse_second_nested()) return;
  restore_board();
  switch_pattern_mode(true);
  for (const Position<frame::Nominal>& target : series.targets) {
    finish_line();
    append_point(target.in_mm(), "XY");
    line_ += "G36";
    ++pattern_.n_nested_targets;
  }
  finish_line();
  pattern_.has_offset = n_open_patterns_ > 0;
  has_outer_offset_ |= n_open_patterns_ == 0;
  nested_ = Nested::InForce;
  up_at_.reset();
}

void SiebMeyerWriter::write(const TargetHole& hole) {
  switch_pattern_mode(false);
  drill_line(hole.nominal.in_mm(), hole.cut, "");
  line_ += "G36";
  finish_line();
}

void SiebMeyerWriter::write(const CancelCorrection& cancel) {
  if (cancel.level == CorrectionLevel::Base) {
    clear_corrections();
    has_base_ = is_board_saved_ = is_replaced_ = false;
    nested_ = Nested::None;
  } else if (nested_ == Nested::InForce && n_open_patterns_ > 0 && !pattern_.has_offset) {
    refuse("G47 in a pattern, of a nested correction from outside of it", "G37");
    nested_ = Nested::None;
  } else if (keeps_copies_ && n_open_patterns_ > 0 && !pattern_.has_kept) {
    pattern_.cancels_ahead = true;
    nested_ = Nested::None;
    if (is_replaced_) refuse_cancel_ahead();
  } else if (nested_ == Nested::InForce) {
    nested_ = Nested::Cancelled;
  } else if (is_replaced_) {
    restore_board();
  } else {
    nested_ = Nested::None;
  }
}

/// A copy keeps its correction, board's and pattern's together, in the location of its own number.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9, G39
void SiebMeyerWriter::write(const StoredCorrection& stored) {
  switch (stored.kind) {
    case StoredCorrectionKind::RecordNext:
      keeps_copies_ = true;
      return save_board();
    case StoredCorrectionKind::RewindNext:
      return;
    case StoredCorrectionKind::Keep:
      pattern_.has_kept = true;
      kept_label_ = stored.label;
      return line("G39,SAVE");
    case StoredCorrectionKind::Use:
      return use_stored(stored);
  }
}

/// In the last location, where the last of 1000 copies has its own.
void SiebMeyerWriter::save_board() {
  if (!has_base_ || is_replaced_ || std::exchange(is_board_saved_, true)) return;
  line(fmt::format("G39,SAVE{}", kLocations));
  uses_board_location_ = true;
  if (n_kept_copies_ == kLocations) kept_label_.reset();
}

void SiebMeyerWriter::use_stored(const StoredCorrection& stored) {
  if (kept_label_ != stored.label) {
    return refuse(fmt::format("a use of the corrections of M50,{} behind those of another label",
                              stored.label),
                  "one label at a time: each copy has one storage location");
  }
  const bool is_nested = stored.level == CorrectionLevel::Nested;
  if (is_nested && has_outer_offset_ && refuse_second_nested()) return;
  const bool is_offset = is_nested && stored.n_targets == 1;
  if (is_foreign()) switch_pattern_mode(is_offset);
  line("G39,LOAD");
  up_at_.reset();
  nested_ = is_offset ? Nested::InForce : Nested::None;
  pattern_.has_offset = is_offset;
  if (is_nested) {
    is_replaced_ = !is_offset;
  } else {
    n_board_targets_ = static_cast<std::size_t>(stored.n_targets);
    has_base_ = true;
    is_board_saved_ = is_replaced_ = false;
  }
}

void SiebMeyerWriter::write(const VisionTool& tool) {
  constexpr int kMostByte = 255;
  if (tool.number > kMostByte)
    return refuse(fmt::format("vision tool {}", tool.number), "0 to 255");
  line(fmt::format("G35,{}", tool.number));
}

void SiebMeyerWriter::switch_pattern_mode(bool is_on) {
  if (std::exchange(pattern_mode_, is_on) != is_on) line(is_on ? "M49,CAMA" : "M49,NOCAMA");
}

/// A place is worked at. An offset of a pattern holds for the rest of its copy and no longer.
void SiebMeyerWriter::note_work() {
  if (!pattern_.has_offset) pattern_.works_ahead = true;
  if (nested_ == Nested::Cancelled && !pattern_.has_offset) {
    refuse("a place behind G47 of a nested correction from outside of patterns", "G37");
    nested_ = Nested::None;
  } else if (nested_ == Nested::Cancelled) {
    refuse("a place behind G47 in the pattern of its nested correction",
           "G47 at the pattern's end");
    nested_ = Nested::None;
  } else if (nested_ == Nested::Ended) {
    refuse("a place behind a pattern under the nested correction of its last copy",
           "G47 at the pattern's end");
    nested_ = Nested::None;
  }
}

}  // namespace panelcal
