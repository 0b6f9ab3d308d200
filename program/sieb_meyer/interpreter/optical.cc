// SPDX-License-Identifier: Apache-2.0
// The optical orders of a line: G30 to G36, G39, M75.
#include <algorithm>
#include <utility>

#include "program/sieb_meyer/interpreter/interpreter.h"

namespace panelcal::sieb_meyer {

TargetPlace Interpreter::target_place(const Block& block, Command command) {
  std::vector<std::int64_t> copies;
  for (const auto& [n, i] : steps_) copies.push_back(n);
  return {command,
          block.line,
          std::string(place_.pattern.path),
          std::string(place_.pattern.sha256),
          place_.path,
          place_.placement(position_mm<frame::Programmed>(modal_.at_mm)),
          place_.placement,
          place_.work_zero,
          std::move(copies)};
}

void Interpreter::optical_order(const Block& block, const Order& order) {
  const Command command = *order.camera;
  if (modal_.motion || is_routing()) {
    return report(Code::ContourUnclosed, block, quoted(block.text), "a T0 line before it");
  }
  if (pattern_) {
    return report(
        Code::CycleUnfinished, block, panelcal::quoted(pattern_->text), "its second point");
  }
  const bool measures = command == Command::Measure || command == Command::FinishMeasure ||
                        command == Command::MeasureOffset;
  if (measures != order.has_xy()) {
    return report(
        Code::CoordinateMissing,
        block,
        quoted(block.text),
        measures ? "X#Y# of the target" : code_text(command) + " in a line without X and Y");
  }
  contour_ = Contour::None;
  machine_at_mm_.reset();
  move_to(order);
  if (measures && !emitter_.count_target(block.line)) return;
  if (measures && !is_decided(block.line)) return;
  if (keeps_structure()) return keep_optical_order(block, command);
  const TargetPlace target = target_place(block, command);
  switch (command) {
    case Command::Measure:
    case Command::FinishMeasure:
      return optical_.measure(target);
    case Command::MeasureOffset: {
      if (optical_.is_pattern_mode()) return optical_.measure_pattern(target);
      const auto seen = optical_.measure_hole(target);  // in both walks, whatever the tool
      emitter_.stop_after(trial_);
      if (seen && has_tool(block.line) && !is_forbidden(block.line, modal_.at_mm)) {
        emitter_.set_cut(cut_at(block.line, modal_.at_mm));
        emitter_.drill_at_target(block.line, modal_.at_mm, *seen);
        emitter_.set_cut(base_cut_);
      }
      return;
    }
    case Command::CorrectionOn:
      return optical_.calculate(target);
    case Command::CorrectionOff:
      return optical_.turn_off(n_blocks_);
    default:
      return optical_.clear();
  }
}

/// For translation: what is measured together, and where holes are drilled at targets.
void Interpreter::keep_optical_order(const Block& block, Command command) {
  const TargetPlace target = target_place(block, command);
  switch (command) {
    case Command::Measure:
      if (settings_.measurement_mode != 1) {
        report(Code::NotSupported,
               block,
               quoted(block.text) +
                   " measures in another mode than 1, which has no form in the "
                   "other language",
               "[vision] mode = 1, or `panelcal run`");
        ended_ = true;
        return;
      }
      [[fallthrough]];
    case Command::FinishMeasure:
      kept_targets_.push_back(target.nominal);
      return;
    case Command::MeasureOffset:
      if (optical_.is_pattern_mode()) {
        if (has_saved_) return refuse_kept(block);
        if (kept_offset_ == KeptOffset::Outer) {
          return refuse_kept(block, " under an offset from outside of its section");
        }
        const std::array targets = {target.nominal};
        kept_offset_ = KeptOffset::Own;
        return emitter_.put(block.line, VisionSeries{CorrectionLevel::Nested, targets});
      }
      if (has_tool(block.line)) {
        emitter_.put(block.line,
                     TargetHole{CorrectionLevel::Base,
                                target.nominal,
                                tool_->number,
                                emitter_.cut_at(target.line, target.nominal)});
      }
      return;
    case Command::CorrectionOn:
      // Excellon would store a second series of the copy as well.
      if (kept_targets_.empty() || has_saved_) return refuse_kept(block);
      if (n_kept_copies_ > 1 && std::exchange(n_waiting_ahead_, 0) > 0) {
        return refuse_kept(block, " with targets from ahead of its section, which one copy takes,");
      }
      emitter_.put(block.line, VisionSeries{CorrectionLevel::Base, kept_targets_});
      ++n_kept_series_;
      n_kept_targets_ = static_cast<int>(kept_targets_.size());
      kept_targets_.clear();
      return;
    default: {
      const auto last = std::exchange(kept_off_in_, n_blocks_);
      const bool is_second = command == Command::CorrectionOff && last && *last + 1 == n_blocks_;
      if (is_second || command != Command::CorrectionOff) {
        kept_targets_.clear();
        n_waiting_ahead_ = 0;
      }
      if (steps_.empty() && n_kept_copies_ == 0) kept_offset_ = KeptOffset::None;
      return emitter_.put(block.line, CancelCorrection{CorrectionLevel::Base});
    }
  }
}

/// For translation: the one copy that is passed on begins.
void Interpreter::begin_kept_copy(std::size_t n_copies) {
  // Else the numbers of its copies count through those of others.
  is_in_kept_section_ =
      std::ranges::all_of(steps_, [](const auto& step) { return step.first == 1; });
  n_kept_series_ = 0;
  n_kept_copies_ = n_copies;
  n_waiting_ahead_ = kept_targets_.size();
}

/// For translation: every copy of a section saves what it has calculated, or loads what the copy at
/// its place has saved. The copies of both sections are compared at the end of the second.
void Interpreter::keep_set(const Block& block) {
  const bool saves = block.argument == "SAVE";
  const bool loads = block.argument == "LOAD";
  const bool may_save =
      saves && n_kept_series_ == 1 && kept_targets_.empty() && kept_offset_ == KeptOffset::None;
  const bool may_load = loads && kept_sets_.label > 0 && n_kept_series_ == 0;
  if (!is_in_kept_section_ || has_saved_ || has_loaded_ || !(may_save || may_load)) {
    return refuse_kept(block);
  }
  if (saves) {
    kept_sets_ = {kept_sets_.label + 1, n_kept_targets_, {}};
  }
  has_saved_ = saves;
  has_loaded_ = loads;
  emitter_.put(block.line,
               StoredCorrection{saves ? StoredCorrectionKind::Keep : StoredCorrectionKind::Use,
                                kept_sets_.label,
                                CorrectionLevel::Base,
                                kept_sets_.n_targets});
}

/// False and an error if a section loads the corrections of other copies than its own, or if its
/// second copy would begin with targets that the first has left.
bool Interpreter::end_kept_sets(const Section& section, const std::vector<Placement>& copies) {
  n_kept_copies_ = 0;
  if (copies.size() > 1 && kept_targets_.size() > n_waiting_ahead_) {
    reporter_.report(Code::NotSupported,
                     section.closing.number,
                     1,
                     "a section that leaves targets to its next copy has no form in the other "
                     "language",
                     "G31 behind its last target");
    ended_ = true;
    return false;
  }
  n_waiting_ahead_ = 0;
  if (std::exchange(has_saved_, false)) kept_sets_.copies = copies;
  if (!std::exchange(has_loaded_, false)) return true;
  if (std::ranges::equal(copies, kept_sets_.copies, is_same_place)) return true;
  reporter_.report(Code::NotSupported,
                   section.begin.number,
                   1,
                   "a section that loads the corrections of other copies than its own has no form "
                   "in the other language",
                   "the copies of the section with G39,SAVE");
  ended_ = true;
  return false;
}

void Interpreter::refuse_kept(const Block& block, std::string_view why) {
  report(Code::NotSupported,
         block,
         quoted(block.text) + std::string(why) + " has no form in the other language",
         "`panelcal run`, which executes it");
  ended_ = true;
}

void Interpreter::camera_text(const Block& block, Command command) {
  if (block.n_words != 1) {
    return report(
        Code::BlockNotAlone, block, quoted(block.text), code_text(command) + " alone in its line");
  }
  contour_ = Contour::None;
  machine_at_mm_.reset();
  if (command == Command::CorrectionValues) {
    if (keeps_structure()) return keep_set(block);
    const bool is_passed =
        optical_.organize(block, step_number(), target_place(block, Command::CorrectionValues));
    if (is_passed) emitter_.put(block.line, Setting{block.text, SettingKind::Vision});
    return;
  }
  if (command == Command::CameraByte) {
    const auto byte = parse_count(block.argument);
    if (!byte || *byte > 255) {
      return reporter_.report(Code::ArgumentInvalid,
                              block.line,
                              block.argument_column,
                              quoted(block.argument),
                              "G35,# with a byte, 0 to 255");
    }
    optical_.select_tool(*byte);
    if (keeps_structure()) return emitter_.put(block.line, VisionTool{*byte});
  }
  emitter_.put(block.line, Setting{block.text, SettingKind::Vision});
}

}  // namespace panelcal::sieb_meyer
