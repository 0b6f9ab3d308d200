// SPDX-License-Identifier: Apache-2.0
// For translation: sections that are passed on as such, and orders of optical measurement and of
// surface detection in both forms, that of the language itself and that of other ones.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "program/sieb_meyer/interpreter/interpreter.h"
#include "program/sieb_meyer/sections/carried_state.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {

// --- sections ----------------------------------------------------------------------------------

bool Interpreter::has_offsets_inside(const Section& section) const {
  return std::ranges::any_of(section.children, [this](int i) {
    const Section& child = text_.sections->sections[static_cast<std::size_t>(i)];
    return child.is_offset() || has_offsets_inside(child);
  });
}

/// A line of the section itself asks for a storage location of G39.
bool Interpreter::organizes(const Section& section) const {
  LineCursor cursor(text_.bytes, section.begin);
  while (cursor.offset() < section.body_end) {
    if (cursor.next().text.find("G39") != std::string_view::npos) return true;
  }
  return false;
}

/// The number of a copy counts through the levels of sections.
bool Interpreter::is_repeated() const {
  return std::ranges::any_of(steps_, [](const auto& step) { return step.first != 1; });
}

/// The innermost patterns are passed on as such; what repeats them is executed, and so is one whose
/// copies have other numbers in every repetition.
bool Interpreter::is_kept(const Section& section) const {
  constexpr std::int64_t kMostCopies = 10'000;
  return keeps_structure() && section.n_copies() <= kMostCopies && !has_offsets_inside(section) &&
         !(is_repeated() && organizes(section)) && !section.has.calls && !section.has.own_copies &&
         !(section.has.feeds && section.has.old_feed) &&
         copies_begin_alike(text_.bytes, section, {optical_.is_pattern_mode(), deletes_blocks_}) &&
         calls_.empty() && areas_.empty() && !scaling_.is_set() && rotation_rad_ == 0;
}

void Interpreter::run_kept(int i_section) {
  const Section& section = text_.sections->sections[static_cast<std::size_t>(i_section)];
  const Modal start = modal_;
  const Placement outer = placement_;
  const auto programmed_from_passed = frame_.inverse();
  std::vector<Placement> copies;
  for (const CopyRow& row : section.rows) {
    for (std::int64_t i = 0; i < row.count; ++i) {
      const Eigen::Vector2d offset_mm = row.offset_mm(i);
      const Placement copy =
          outer * Transform<frame::Programmed, frame::Programmed>(row.orientation, offset_mm);
      const auto whole = copy * programmed_from_passed;
      copies.emplace_back(whole.linear(), whole.translation());
    }
  }
  place(frame_);
  emitter_.put(section.begin.number, PatternBegin{});
  repeats_tool_ = true;
  kept_.section = KeptSection{.n_copies = static_cast<int>(copies.size()),
                              .n_waiting = kept_.targets.size(),
                              .base = kept_.base};
  kept_.is_fit_in_force = false;  // the second copy may begin with another correction
  run_copy(i_section, start);
  repeats_tool_ = false;
  end_kept_section(section);
  if (has_ended()) return;
  emitter_.put(section.closing.number, PatternEnd{copies});
  place(outer);
}

void Interpreter::end_kept_section(const Section& section) {
  const KeptSection done = *std::exchange(kept_.section, std::nullopt);
  if (has_ended()) return;
  if (done.n_copies > 1 && kept_.targets.size() > done.n_waiting) {
    pass_order(section.closing.number,
               {.text = "",
                .remedy = "G31 behind its last target",
                .problem = "a section that leaves targets to its next copy"});
  }
  if (done.unsaved_offset) {
    pass_order(*done.unsaved_offset,
               {.text = "",
                .remedy = "G39,SAVE again behind it, or G36 in a section behind its G39,LOAD",
                .problem = "G36 behind G39,SAVE of its section, with which Excellon stores it"});
  }
  if (done.uses_base && kept_.base != done.base && done.n_copies > 1) {
    pass_order(section.closing.number,
               {.text = "",
                .remedy = "G30, G31, G34 and G39,LOAD# in a section of their own",
                .problem = "an offset (G36) in G39,SAVE or G39,LOAD, whose section changes the "
                           "correction that it stands on"});
  }
  for (int i = 1; done.saved && i <= done.n_copies; ++i) {
    KeptSet& set = kept_.sets[i];
    set.correction = *done.saved;
    set.correction.copy = i;
    set.base = set.is_offset_alone() ? std::optional(done.base) : std::nullopt;
  }
}

/// Gives the offsets that hold round the copy.
Interpreter::KeptOffsets Interpreter::begin_kept_copy() {
  const KeptOffsets outer = kept_.offsets;
  kept_.offsets = {.has_outer = outer.has_own || outer.has_outer,
                   .has_outer_targets = outer.n_targets > 0 || outer.has_outer_targets};
  return outer;
}

void Interpreter::end_kept_copy(int line, const KeptOffsets& outer) {
  if (std::exchange(kept_.offsets, outer).has_own) {
    emitter_.put(line, CancelCorrection{CorrectionLevel::Nested});
  }
}

/// Its copies are not passed on as such.
bool Interpreter::has_executed_copy() const {
  return !steps_.empty() && !kept_.section;
}

// --- optical measurement -----------------------------------------------------------------------

void Interpreter::pass_order(int line, OpticalOrder order) {
  order.ends_with_copy &= has_executed_copy();
  emitter_.put(line, order);
}

void Interpreter::keep_optical_order(const Block& block, Command command) {
  const TargetPlace target = target_place(block, command);
  switch (command) {
    case Command::Measure:
    case Command::FinishMeasure:
      return keep_target(block, command, target);
    case Command::MeasureOffset:
      if (optical_.is_pattern_mode()) return keep_pattern_target(block, target.nominal);
      // A hole that a forbidden area leaves out leaves no target: it would only be looked at.
      if (may_drill_target(block.line)) {
        emitter_.put(block.line,
                     TargetHole{CorrectionLevel::Base,
                                target.nominal,
                                tool_->number,
                                emitter_.cut_at(target.line, target.nominal)});
      }
      return;
    case Command::CorrectionOn:
      return keep_series(block.line, "G31");
    default:
      return keep_end(block, command);
  }
}

namespace {

/// A slot shows x of the program (G33) or its y (G32); in a copy that is written out turned by a
/// quarter, that is the other coordinate. `seen_axis` refuses other turns.
Command written_slot(Command command, const Placement& copy, const Placement& written) {
  const Eigen::Matrix2d turn = written.linear().transpose() * copy.linear();
  const bool is_swapped = std::abs(turn(1, 0)) > std::abs(turn(0, 0));
  if (!is_swapped) return command;
  return command == Command::Measure ? Command::FinishMeasure : Command::Measure;
}

}  // namespace

/// A slot (mode 5) shows one coordinate; layers (2 and 3) are several looks at one target.
void Interpreter::keep_target(const Block& block, Command command, const TargetPlace& target) {
  const int mode = settings_.measurement_mode;
  const bool is_layer = (mode == 2 || mode == 3) && command == Command::Measure;
  // G39,REQCOMP needs mode 3.
  const std::string_view remedy =
      mode == 5               ? "targets that show both coordinates, and [vision] mode = 1"
      : is_layer && mode == 3 ? "one layer of each target: G33 alone"
      : is_layer              ? "one layer of each target: G33 alone, or [vision] mode = 1"
                              : "";
  const Command written = mode == 5 ? written_slot(command, target.placement, frame_) : command;
  const std::string text = code_text(written);
  pass_order(block.line, {.text = text, .target = target.nominal, .remedy = remedy});
  if (remedy.empty()) kept_.targets.push_back(target.nominal);
}

/// G36 under CAMA.
void Interpreter::keep_pattern_target(const Block& block, const Position<frame::Nominal>& nominal) {
  KeptOffsets& offsets = kept_.offsets;
  OpticalOrder order{.text = "G36", .target = nominal, .ends_with_copy = true};
  if (offsets.has_outer) {
    order.remedy = "G34 before the section";
    order.problem = "G36 under an offset from outside of its section";
  } else if (offsets.n_targets > 0) {
    order.remedy = "one G36 in each copy, or G34 before the second";
    order.problem = "one offset of a pattern from several targets (CAMA)";
  }
  pass_order(block.line, order);
  offsets.has_own = true;
  ++offsets.n_targets;
  kept_.is_fit_in_force = false;
  if (!order.remedy.empty()) return;
  if (kept_.section) {
    ++kept_.section->n_targets;
    if (kept_.section->saved) kept_.section->unsaved_offset = block.line;
  }
  const std::array targets = {nominal};
  emitter_.put(block.line, VisionSeries{CorrectionLevel::Nested, targets});
}

/// G31, and G39,REQCOMP, which is answered by the same fit. Without targets since they would put in
/// force what is in force already, or what was before another order; Excellon cannot say that.
void Interpreter::keep_series(int line, std::string_view text) {
  if (kept_.targets.empty() && kept_.is_fit_in_force) return pass_order(line, {.text = text});
  const std::vector<Position<frame::Nominal>> targets = std::exchange(kept_.targets, {});
  KeptSection* const section = kept_.section ? &*kept_.section : nullptr;
  const bool takes_others =
      section != nullptr && section->n_copies > 1 && std::exchange(section->n_waiting, 0) > 0;
  OpticalOrder order{.text = text};
  if (targets.empty()) {
    order.remedy = "G34 and its targets (G33) once more before it";
    order.ends_with_copy = kept_.offsets.has_outer;
  } else if (section != nullptr && section->saved) {
    order.remedy = "it before G39,SAVE";
  } else if (takes_others) {
    order.remedy = "all targets in the section";
    order.problem = "a fit with targets from ahead of its section, which one copy takes";
  } else if (targets.size() == 2 && options_.sieb_meyer.fits_scale) {
    order.remedy = "three targets, or [vision] scale = false";
    order.problem = "a scale fitted to two targets";
  }
  pass_order(line, order);
  kept_.n_of_last = 0;
  kept_.base = ++kept_.n_bases;
  kept_.is_fit_in_force = order.remedy.empty();
  if (!order.remedy.empty()) return;
  kept_.n_of_last = static_cast<int>(targets.size());
  if (section != nullptr) {
    section->has_series = true;
    section->has_late_series |= kept_.offsets.n_targets > 0;
    section->n_targets += kept_.n_of_last;
  }
  kept_.offsets.has_own = false;
  emitter_.put(line, VisionSeries{CorrectionLevel::Base, targets});
}

/// G30, which clears as well where it comes twice running, and G34.
void Interpreter::keep_end(const Block& block, Command command) {
  const std::string text = code_text(command);
  const bool turns_off = command == Command::CorrectionOff;
  const bool is_second = turns_off && kept_.turned_off_in && *kept_.turned_off_in + 1 == n_blocks_;
  const bool clears = !turns_off || is_second;
  pass_order(block.line,
             {.text = text, .ends_with_copy = clears && kept_.offsets.has_outer_targets});
  if (turns_off) kept_.turned_off_in = n_blocks_;
  if (clears) {
    kept_.targets.clear();
    kept_.n_of_last = 0;
    kept_.offsets.has_own = false;
    kept_.offsets.n_targets = 0;
    if (kept_.section) {
      kept_.section->n_waiting = 0;
      kept_.section->has_series = false;
    }
  }
  kept_.base = 0;
  kept_.is_fit_in_force = false;
  emitter_.put(block.line, CancelCorrection{CorrectionLevel::Base});
}

// --- sets of corrections (G39) -----------------------------------------------------------------

namespace {

enum class SetOrderKind : std::uint8_t { Save, Load, Clear, ClearAll, Other };

struct SetOrder {
  SetOrderKind kind = SetOrderKind::Other;
  std::optional<int> number;
};

SetOrder set_order(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, SetOrderKind>, 3> kWords = {
      {{"SAVE", SetOrderKind::Save}, {"LOAD", SetOrderKind::Load}, {"CLEAR", SetOrderKind::Clear}}};
  if (text == "DELALL") return {SetOrderKind::ClearAll, std::nullopt};
  for (const auto& [word, kind] : kWords) {
    if (text.starts_with(word)) return {kind, parse_count(text.substr(word.size()))};
  }
  return {};
}

}  // namespace

/// In the language itself the order goes on as it is. Without a number of its own it means that of
/// the copy, which has to be written where copies are executed one by one.
void Interpreter::keep_set(const Block& block) {
  if (block.argument == "REQCOMP") return keep_series(block.line, "G39,REQCOMP");
  const SetOrder order = set_order(block.argument);
  const bool has_location = order.kind == SetOrderKind::Save || order.kind == SetOrderKind::Load ||
                            order.kind == SetOrderKind::Clear;
  std::string text = "G39," + std::string(block.argument);
  std::optional<int> location = order.number;
  if (has_location && !location && !kept_.section && !steps_.empty()) {
    location = step_number();
    text += std::to_string(*location);
  }
  KeptOrder kept;
  const bool loads = order.kind == SetOrderKind::Load;
  const bool ends_with_copy = loads && (kept_.offsets.has_outer || kept_.may_load_offset);
  switch (order.kind) {
    case SetOrderKind::Save:
      kept = kept_.section ? save_of_copies(location) : save_at(location);
      kept_.may_load_offset |= kept_.offsets.has_own || kept_.offsets.has_outer;
      break;
    case SetOrderKind::Load:
      kept = load_kept(location);
      break;
    case SetOrderKind::Clear:
      clear_sets(location);
      break;
    case SetOrderKind::ClearAll:
      kept_.sets.clear();
      break;
    case SetOrderKind::Other:
      kept_.targets.clear();  // it uses them up
      kept_.is_fit_in_force = false;
      kept.remedy = "the offset calibrated by the control that drills (G39X#Y#, $uvis,calib)";
      break;
  }
  pass_order(block.line, {.text = text, .remedy = kept.remedy, .ends_with_copy = ends_with_copy});
  if (kept.stored) emitter_.put(block.line, *kept.stored);
}

/// Every copy of the section keeps what it has measured: G31, an offset on top of it, or an offset
/// alone, on top of what is in force round the section. A second G39,SAVE may add the offset: both
/// mean the same location.
Interpreter::KeptOrder Interpreter::save_of_copies(const std::optional<int>& location) {
  KeptSection& section = *kept_.section;
  if (location) {
    kept_.sets.erase(*location);  // the last copy's
    return {"G39,SAVE without a number in a section", {}};
  }
  const bool is_offset = kept_.offsets.has_own;
  const bool adds_offset = is_offset && section.saved && !section.saved->is_offset;
  if (section.saved && !adds_offset) return {"one G39,SAVE in a section", {}};
  if (section.has_loaded) return {"G39,SAVE and G39,LOAD in sections of their own", {}};
  const bool stands_on_outer = is_offset && kept_.base == section.base;
  if (!(section.has_series || stands_on_outer) || !kept_.targets.empty()) {
    return {"G32 and G31 before it in the same section", {}};
  }
  if (section.has_late_series) return {"G36 behind G31", {}};
  const CorrectionLevel level = is_offset ? CorrectionLevel::Nested : CorrectionLevel::Base;
  const int label = section.saved ? section.saved->label : ++kept_.n_labels;
  section.saved =
      StoredCorrection{StoredCorrectionKind::Keep, label, level, section.n_targets, is_offset};
  section.uses_base |= !section.has_series;
  section.unsaved_offset.reset();
  return {{}, section.saved};
}

/// The program itself keeps the series that it has measured last.
Interpreter::KeptOrder Interpreter::save_at(const std::optional<int>& location) {
  if (!location) return {"G39,SAVE# with a number", {}};
  kept_.sets.erase(*location);
  const bool has_offset = kept_.offsets.has_own || kept_.offsets.has_outer;
  if (kept_.n_of_last == 0 || has_offset || !kept_.targets.empty()) {
    return {"G39,SAVE# right behind G31", {}};
  }
  const StoredCorrection keep{
      StoredCorrectionKind::Keep, ++kept_.n_labels, CorrectionLevel::Base, kept_.n_of_last};
  KeptSet& set = kept_.sets[*location];
  set = {keep, kept_.base};
  set.correction.copy = 1;
  return {{}, keep};
}

/// A set replaces an offset too; but that from outside of a section comes back behind the copy if
/// the set is of the same base correction.
Interpreter::KeptOrder Interpreter::load_kept(const std::optional<int>& location) {
  kept_.n_of_last = 0;
  kept_.is_fit_in_force = false;
  if (kept_.offsets.has_outer) {
    kept_.offsets.has_own = kept_.may_load_offset;
    return {"G34 before the section, which ends the offset (CAMA) from outside of it", {}};
  }
  KeptOrder kept = kept_.section && !location ? load_of_copies() : load_from(location);
  kept_.offsets.has_own = kept.stored ? kept.stored->is_offset : kept_.may_load_offset;
  if (!kept.stored) kept_.base = ++kept_.n_bases;
  return kept;
}

/// The base correction that comes into force with a set, but with an offset alone: Excellon puts
/// that on top of what is in force, G39,LOAD puts both in force. False: they are not the same.
bool Interpreter::take_base_of(const KeptSet& set) {
  if (set.is_offset_alone()) {
    if (kept_.section) kept_.section->uses_base = true;
    return set.base == kept_.base;
  }
  kept_.base = set.base ? *set.base : ++kept_.n_bases;
  return true;
}

namespace {

constexpr std::string_view kOnAnother =
    "G39,LOAD of an offset (G36) under the correction that it was measured under";

}  // namespace

/// Each copy of the section takes what the copy with its number has kept.
Interpreter::KeptOrder Interpreter::load_of_copies() {
  KeptSection& section = *kept_.section;
  if (section.saved) return {"G39,SAVE and G39,LOAD in sections of their own", {}};
  if (section.has_loaded) return {"one G39,LOAD without a number in a section", {}};
  for (int i = 1; i <= section.n_copies; ++i) {
    const auto set = kept_.sets.find(i);
    const bool is_own = set != kept_.sets.end() && set->second.correction.copy == i &&
                        set->second.correction.label == kept_.sets.begin()->second.correction.label;
    if (!is_own) return {"a section that saves the corrections of these copies, by G39,SAVE", {}};
  }
  const KeptSet& first = kept_.sets.begin()->second;
  if (!take_base_of(first)) return {kOnAnother, {}};
  section.has_loaded = true;
  StoredCorrection use = first.correction;
  use.kind = StoredCorrectionKind::Use;
  use.copy = 0;
  return {{}, use};
}

Interpreter::KeptOrder Interpreter::load_from(const std::optional<int>& location) {
  const auto set = location ? kept_.sets.find(*location) : kept_.sets.end();
  if (set == kept_.sets.end()) return {"G39,SAVE# with that number, right behind G31", {}};
  if (!take_base_of(set->second)) return {kOnAnother, {}};
  StoredCorrection use = set->second.correction;
  use.kind = StoredCorrectionKind::Use;
  return {{}, use};
}

void Interpreter::clear_sets(const std::optional<int>& location) {
  if (location) {
    kept_.sets.erase(*location);
  } else if (kept_.section) {
    for (int i = 1; i <= kept_.section->n_copies; ++i) kept_.sets.erase(i);
  }
}

// --- surface detection -------------------------------------------------------------------------

/// The control probes, and nothing is known of what it finds.
void Interpreter::keep_surface_order(const Block& block, const Order& order, bool has_place) {
  const auto pass = [&](SurfaceOrderKind kind) {
    const std::optional<Eigen::Vector2d> at_mm =
        has_place ? std::optional(modal_.at_mm) : std::nullopt;
    emitter_.surface_order(block.line, kind, order.memory, at_mm, base_cut_);
  };
  switch (*order.surface) {
    case Command::SurfaceClear:
      has_kept_grid_ = false;
      return pass(SurfaceOrderKind::ClearMemory);
    case Command::SurfaceDetect:
      return pass(has_place ? SurfaceOrderKind::Detect : SurfaceOrderKind::StoreLast);
    case Command::SurfaceAverage:
      return pass_average(block, order);
    case Command::ProbeRetract:
      return function(block.line, FunctionKind::RetractProbe, "G75");
    case Command::DepthRecord:
      return pass(SurfaceOrderKind::Record);
    case Command::GridReference:
      has_kept_grid_ = true;
      return pass(SurfaceOrderKind::GridReference);
    default:
      has_kept_grid_ = true;
      return pass(SurfaceOrderKind::GridPoint);
  }
}

/// G77 goes on with holes. Pieces of a contour are passed on behind the next line's orders.
void Interpreter::skip_kept_grid(const Block& block, const Order& order) {
  const bool drills = !order.motion && !modal_.motion && !pattern_ && parts_of(order) == kXy;
  if (!drills) return refuse_kept(block);
  emitter_.put(block.line, SurfaceOrder{.kind = SurfaceOrderKind::Skip});
}

void Interpreter::refuse_kept(const Block& block) {
  report(Code::NotSupported,
         block,
         quoted(block.text) + " has no form in a translation",
         "`panelcal run`, which executes it");
  ended_ = true;
}

}  // namespace panelcal::sieb_meyer
