// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER's orders instead of the other language's settings, functions, patterns and vision
// commands.
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "program/model/setting_lengths.h"
#include "program/model/tool_links.h"
#include "program/sieb_meyer/text/cnc_commands.h"
#include "program/sieb_meyer/text/lexer.h"
#include "program/writers/foreign_settings.h"
#include "program/writers/pattern_copies.h"
#include "program/writers/sieb_meyer/writer.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// The word of a line that probes, which is executed before the output is.
constexpr std::string_view kDummyTool = "TD";

/// How G74 averages.
constexpr std::string_view kAveraging = "M49,SPAV,";

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
    return lose_vision(setting);
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
  if (setting.text.starts_with(kAveraging)) {
    note_average(setting.text.substr(kAveraging.size()));
    return line(setting.text);
  }
  const bool is_in_inch = info().format.unit == LengthUnit::Inch;
  if (is_in_inch || has_more_decimals(setting.text, digits().n_decimals)) {
    nibbling_ = {};
    return write_in_mm(setting.text, is_in_inch ? inch(1) : mm(1));
  }
  if (!was_nibbling_told(setting.text)) line(setting.text);
}

/// True for what the control was told last of how it nibbles. A copy of a pattern begins as the
/// copy before it ended, so that nothing is known there.
bool SiebMeyerWriter::was_nibbling_told(std::string_view setting) {
  constexpr std::string_view kRoughness = "M49,NIB";
  const bool is_order = setting == "M49,NIBO" || setting == "M49,NONIBO";
  if (!is_order && !setting.starts_with(kRoughness)) return false;
  std::string& told = nibbling_[is_order ? 0 : 1];
  if (told == setting) return true;
  told = n_open_patterns_ > 0 ? std::string_view() : setting;
  return false;
}

/// A copy of a pattern begins as the copy before it ended, so that nothing is known there.
void SiebMeyerWriter::note_average(std::string_view letter) {
  average_ = n_open_patterns_ > 0 ? std::string_view() : letter;
}

/// The control may be left with another one by the job before.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 10.1, G74
void SiebMeyerWriter::state_average(std::string_view letter) {
  if (average_ == letter) return;
  line(std::string(kAveraging) + std::string(letter));
  note_average(letter);
}

/// A CNC command of a source in another unit, or with more digits than this program has.
void SiebMeyerWriter::write_in_mm(std::string_view setting, Length unit) {
  sieb_meyer::Block block;
  const bool is_command = !sieb_meyer::lex({setting, 0, 1}, block) && block.n_words == 1 &&
                          block.words[0].letter == 'M' &&
                          sieb_meyer::command_of(block.words[0]) == sieb_meyer::Command::CncCommand;
  if (!is_command) return line(setting);
  const auto converted = sieb_meyer::command_in_mm(block.argument, unit, digits().n_decimals);
  if (!converted && unit == mm(1)) return line(setting);
  if (!converted) {
    return refuse(quoted(setting) + ", which may state lengths in inch",
                  "it without lengths, or a program in millimetres");
  }
  line("M49," + *converted);
}

void SiebMeyerWriter::write_foreign(const Setting& setting) {
  const std::string_view key = setting_key(setting.text);
  if (is_spelling(key)) return;
  if (setting.kind == SettingKind::Vision) {
    if (!options().keeps_vision) return lose_vision(setting);
    if (setting.text.starts_with("$uvis,alg,")) return;
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
  // A probe that stands without G71 in the source has switched it on.
  if (!is_switched_on_) say_surface_line({});
  line("M31");
  ++n_open_patterns_;
  pattern_ = {};
  up_at_.reset();
  feed_.reset();
  nibbling_ = {};
  average_.clear();
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

/// In the language itself the orders are passed on as they are.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9
void SiebMeyerWriter::write(const OpticalOrder& order) {
  if (is_foreign() || order.text.empty()) return;
  if (order.ends_with_copy && n_open_patterns_ == 0) {
    return refuse(
        fmt::format("{}, whose effect ends with a copy that is written out,", quoted(order.text)),
        "an innermost section without M58, M99, SA, RA and &R in it or round it, whose copies "
        "begin with the same tool, depth and modes");
  }
  up_at_.reset();
  if (!order.target) return line(order.text);
  if (order.text == "G36") switch_pattern_mode(true);
  finish_line();
  append_point(order.target->in_mm(), "XY");
  line_ += order.text;
  finish_line();
}

/// Targets are looked for where they are nominally, so a correction in force is cleared first.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9, G31 to G34
void SiebMeyerWriter::write(const VisionSeries& series) {
  if (!is_foreign()) return;
  if (series.level == CorrectionLevel::Nested) return write_nested(series);
  if (series.fits_otherwise) {
    refuse("a base series of two targets, without the scale that the control fits",
           "three targets, or [vision] scale = false");
  }
  if (n_open_patterns_ > 0 && pattern_.restores_board) {
    refuse("a base series behind G47 in its pattern", "G47 before the pattern");
  } else if (n_open_patterns_ > 0 && pattern_.has_whole) {
    refuse("a base series behind a nested one in its pattern", "the base series first");
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
  has_outer_offset_ = has_loaded_offset_ = false;
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

/// A nested series of several targets. This control nests no more than an offset, but what it fits
/// to the same targets, from where they are nominally, is the whole correction. The board's is in
/// force before, so that targets are found; in a pattern the copy before may have replaced it.
void SiebMeyerWriter::write_whole(const VisionSeries& series) {
  if (series.fits_otherwise) {
    return refuse("a nested series whose model is not the manual's",
                  "[vision] model = \"stretch\", scale = false");
  }
  if (pattern_.works_behind_cancel) refuse_cancel_ahead();
  switch_pattern_mode(false);
  save_board();
  is_replaced_ |= n_open_patterns_ > 0;
  restore_board();
  measure_targets(series);
  is_replaced_ = true;
  pattern_.has_whole = n_open_patterns_ > 0;
}

/// In the first copy there may be nothing to cancel, in the second there is, and places between it
/// and the targets need that.
void SiebMeyerWriter::refuse_cancel_ahead() {
  refuse("G47 ahead of the targets in a pattern whose copies have their own corrections",
         "G47 before the pattern, or at its end");
}

/// Keeps the base correction, once, while it is in force: in the last location, where the last of
/// 1000 copies has its own.
void SiebMeyerWriter::save_board() {
  if (!has_base_ || is_replaced_ || std::exchange(is_board_saved_, true)) return;
  is_saved_with_offset_ = nested_ == Nested::InForce;
  line(fmt::format("G39,SAVE{}", kLocations));
  uses_board_location_ = true;
  if (n_kept_copies_ == kLocations) kept_label_.reset();
}

/// Puts the base correction in force where that of a copy has replaced it.
void SiebMeyerWriter::restore_board() {
  if (!std::exchange(is_replaced_, false)) return;
  if (has_base_ && is_saved_with_offset_) {
    refuse("the base correction behind a nested one (G45) that was in force with it",
           "G47 ahead of other nested corrections");
  }
  line(has_base_ ? fmt::format("G39,LOAD{}", kLocations) : "G34");
  up_at_.reset();
  pattern_.restores_board = n_open_patterns_ > 0;
  if (n_open_patterns_ == 0) has_loaded_offset_ = false;
}

/// The control takes a second target of one copy, or of the program outside of patterns, together
/// with the first, and an offset from outside comes back behind a copy that has its own.
bool SiebMeyerWriter::refuse_second_nested() {
  const bool comes_back = has_outer_offset_ || (has_loaded_offset_ && n_open_patterns_ > 0);
  if (pattern_.n_nested_targets == 0 && !comes_back) return false;
  refuse("a second nested correction", "one for each copy of a pattern, and G37 between others");
  return true;
}

/// All targets of a copy give one offset, so that a second series would change the first.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9, G36 (CAMA)
void SiebMeyerWriter::write_nested(const VisionSeries& series) {
  if (has_outer_offset_ && refuse_second_nested()) return;
  const bool may_save = keeps_copies_ || n_open_patterns_ == 0;
  if (may_save && pattern_.n_nested_targets == 0 && may_be_whole(series)) {
    return write_whole(series);
  }
  if (series.targets.size() > 1) {
    return refuse(fmt::format("a nested series of {} targets", series.targets.size()),
                  "one target (G45): an offset is all that SIEB & MEYER nests");
  }
  if (refuse_second_nested()) return;
  restore_board();
  switch_pattern_mode(true);
  finish_line();
  append_point(series.targets.front().in_mm(), "XY");
  line_ += "G36";
  finish_line();
  pattern_.n_nested_targets = 1;
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
  if (!is_foreign()) return;
  if (cancel.level == CorrectionLevel::Base) {
    clear_corrections();
    has_base_ = is_board_saved_ = is_replaced_ = false;
    nested_ = Nested::None;
  } else if (nested_ == Nested::InForce && n_open_patterns_ > 0 && !pattern_.has_offset) {
    refuse("G47 in a pattern, of a nested correction from outside of it", "G37");
    nested_ = Nested::None;
  } else if (nested_ == Nested::InForce) {
    nested_ = Nested::Cancelled;
  } else if (keeps_copies_ && n_open_patterns_ > 0 && !pattern_.has_whole && !pattern_.has_kept) {
    pattern_.cancels_ahead = !is_replaced_;
    nested_ = Nested::None;
    restore_board();
  } else if (is_replaced_) {
    restore_board();
  } else {
    nested_ = Nested::None;
  }
}

/// A copy keeps its correction, board's and pattern's together, in the location of its own number.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9, G39
void SiebMeyerWriter::write(const StoredCorrection& stored) {
  if (!is_foreign()) return;
  switch (stored.kind) {
    case StoredCorrectionKind::RecordNext:
    case StoredCorrectionKind::NestNext:
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

/// Outside of patterns what is loaded replaces the board's correction until it is cancelled.
void SiebMeyerWriter::use_stored(const StoredCorrection& stored) {
  if (kept_label_ != stored.label) {
    return refuse(fmt::format("a use of the corrections of M50,{} behind those of another label",
                              stored.label),
                  "one label at a time: each copy has one storage location");
  }
  const bool is_nested = stored.level == CorrectionLevel::Nested;
  const int n_board = is_nested ? stored.n_targets - 1 : stored.n_targets;
  const bool has_board = !is_nested || (stored.is_offset && n_board > 0);
  const bool ends_with_copy = stored.is_offset && n_open_patterns_ > 0;
  if (is_nested && n_open_patterns_ > 0 && refuse_second_nested()) return;
  switch_pattern_mode(stored.is_offset);
  line("G39,LOAD" + (stored.copy > 0 ? std::to_string(stored.copy) : ""));
  up_at_.reset();
  const bool may_end = ends_with_copy || (stored.is_offset && has_board);
  nested_ = may_end ? Nested::InForce : Nested::None;
  is_replaced_ = !has_board && !ends_with_copy;
  pattern_.has_offset = ends_with_copy;
  if (n_open_patterns_ == 0) has_loaded_offset_ = stored.is_offset;
  if (!has_board) return;
  n_board_targets_ = static_cast<std::size_t>(n_board);
  has_base_ = true;
  is_board_saved_ = false;
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
  pattern_.works_ahead |= !pattern_.has_offset && !pattern_.has_whole;
  pattern_.works_behind_cancel |= pattern_.cancels_ahead;
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
