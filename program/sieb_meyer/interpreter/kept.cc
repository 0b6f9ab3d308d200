// SPDX-License-Identifier: Apache-2.0
// For translation: sections that are passed on as such, and orders of optical measurement and of
// surface detection in both forms, that of the language itself and that of other ones.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "program/sieb_meyer/interpreter/parts.h"
#include "program/sieb_meyer/sections/carried_state.h"

namespace panelcal::sieb_meyer {
namespace {

/// A slot shows x of the program (G33) or its y (G32); in a copy that is written out turned by a
/// quarter, that is the other coordinate. `seen_axis` refuses other turns.
Command written_slot(Command command, const Placement& copy, const Placement& written) {
  const Eigen::Matrix2d turn = written.linear().transpose() * copy.linear();
  const bool is_swapped = std::abs(turn(1, 0)) > std::abs(turn(0, 0));
  if (!is_swapped) return command;
  return command == Command::Measure ? Command::FinishMeasure : Command::Measure;
}

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

constexpr std::string_view kOnAnother =
    "G39,LOAD of an offset (G36) under the correction that it was measured under";

bool has_offsets_inside(const Walk& walk, const Section& section) {
  return std::ranges::any_of(section.children, [&walk](int i) {
    const Section& child = walk.section(i);
    return child.is_offset() || has_offsets_inside(walk, child);
  });
}

/// A line of the section itself asks for a storage location of G39.
bool organizes(const Walk& walk, const Section& section) {
  LineCursor cursor(walk.text.bytes, section.begin);
  while (cursor.offset() < section.body_end) {
    if (cursor.next().text.find("G39") != std::string_view::npos) return true;
  }
  return false;
}

/// The number of a copy counts through the levels of sections.
bool is_repeated(const Walk& walk) {
  return std::ranges::any_of(walk.steps, [](const auto& step) { return step.first != 1; });
}

/// Its copies are not passed on as such.
bool has_executed_copy(const Walk& walk) {
  return !walk.steps.empty() && !walk.kept.section;
}

void pass_order(Walk& walk, int line, OpticalOrder order) {
  order.ends_with_copy &= has_executed_copy(walk);
  walk.emitter.put(line, order);
}

void end_kept_section(Walk& walk, const Section& section) {
  const KeptSection done = *std::exchange(walk.kept.section, std::nullopt);
  if (walk.has_ended()) return;
  if (done.n_copies > 1 && walk.kept.targets.size() > done.n_waiting) {
    pass_order(walk,
               section.closing.number,
               {.text = "",
                .remedy = "G31 behind its last target",
                .problem = "a section that leaves targets to its next copy"});
  }
  if (done.unsaved_offset) {
    pass_order(walk,
               *done.unsaved_offset,
               {.text = "",
                .remedy = "G39,SAVE again behind it, or G36 in a section behind its G39,LOAD",
                .problem = "G36 behind G39,SAVE of its section, with which Excellon stores it"});
  }
  if (done.uses_base && walk.kept.base != done.base && done.n_copies > 1) {
    pass_order(walk,
               section.closing.number,
               {.text = "",
                .remedy = "G30, G31, G34 and G39,LOAD# in a section of their own",
                .problem = "an offset (G36) in G39,SAVE or G39,LOAD, whose section changes the "
                           "correction that it stands on"});
  }
  for (int i = 1; done.saved && i <= done.n_copies; ++i) {
    KeptSet& set = walk.kept.sets[i];
    set.correction = *done.saved;
    set.correction.copy = i;
    set.base = set.is_offset_alone() ? std::optional(done.base) : std::nullopt;
  }
}

/// A slot (mode 5) shows one coordinate; layers (2 and 3) are several looks at one target.
void keep_measured_target(Walk& walk,
                          const Block& block,
                          Command command,
                          const TargetPlace& target) {
  const int mode = walk.settings.measurement_mode;
  const bool is_layer = (mode == 2 || mode == 3) && command == Command::Measure;
  // G39,REQCOMP needs mode 3.
  const std::string_view remedy =
      mode == 5               ? "targets that show both coordinates, and [vision] mode = 1"
      : is_layer && mode == 3 ? "one layer of each target: G33 alone"
      : is_layer              ? "one layer of each target: G33 alone, or [vision] mode = 1"
                              : "";
  const Command written = mode == 5 ? written_slot(command, target.placement, walk.frame) : command;
  const std::string text = code_text(written);
  pass_order(walk, block.line, {.text = text, .target = target.nominal, .remedy = remedy});
  if (remedy.empty()) walk.kept.targets.push_back(target.nominal);
}

/// G36 under CAMA.
void keep_pattern_target(Walk& walk, const Block& block, const Position<frame::Nominal>& nominal) {
  KeptOffsets& offsets = walk.kept.offsets;
  OpticalOrder order{.text = "G36", .target = nominal, .ends_with_copy = true};
  if (offsets.has_outer) {
    order.remedy = "G34 before the section";
    order.problem = "G36 under an offset from outside of its section";
  } else if (offsets.n_targets > 0) {
    order.remedy = "one G36 in each copy, or G34 before the second";
    order.problem = "one offset of a pattern from several targets (CAMA)";
  }
  pass_order(walk, block.line, order);
  offsets.has_own = true;
  ++offsets.n_targets;
  walk.kept.is_fit_in_force = false;
  if (!order.remedy.empty()) return;
  if (walk.kept.section) {
    ++walk.kept.section->n_targets;
    if (walk.kept.section->saved) walk.kept.section->unsaved_offset = block.line;
  }
  const std::array targets = {nominal};
  walk.emitter.put(block.line, VisionSeries{CorrectionLevel::Nested, targets});
}

/// G31, and G39,REQCOMP, which is answered by the same fit. Without targets since they would put in
/// force what is in force already, or what was before another order; Excellon cannot say that.
void keep_series(Walk& walk, int line, std::string_view text) {
  if (walk.kept.targets.empty() && walk.kept.is_fit_in_force)
    return pass_order(walk, line, {.text = text});
  const std::vector<Position<frame::Nominal>> targets = std::exchange(walk.kept.targets, {});
  KeptSection* const section = walk.kept.section ? &*walk.kept.section : nullptr;
  const bool takes_others =
      section != nullptr && section->n_copies > 1 && std::exchange(section->n_waiting, 0) > 0;
  OpticalOrder order{.text = text};
  if (targets.empty()) {
    order.remedy = "G34 and its targets (G33) once more before it";
    order.ends_with_copy = walk.kept.offsets.has_outer;
  } else if (section != nullptr && section->saved) {
    order.remedy = "it before G39,SAVE";
  } else if (takes_others) {
    order.remedy = "all targets in the section";
    order.problem = "a fit with targets from ahead of its section, which one copy takes";
  } else if (targets.size() == 2 && walk.options.sieb_meyer.fits_scale) {
    order.remedy = "three targets, or [vision] scale = false";
    order.problem = "a scale fitted to two targets";
  }
  pass_order(walk, line, order);
  walk.kept.n_of_last = 0;
  walk.kept.base = ++walk.kept.n_bases;
  walk.kept.is_fit_in_force = order.remedy.empty();
  if (!order.remedy.empty()) return;
  walk.kept.n_of_last = static_cast<int>(targets.size());
  if (section != nullptr) {
    section->has_series = true;
    section->has_late_series |= walk.kept.offsets.n_targets > 0;
    section->n_targets += walk.kept.n_of_last;
  }
  walk.kept.offsets.has_own = false;
  walk.emitter.put(line, VisionSeries{CorrectionLevel::Base, targets});
}

/// G30, which clears as well where it comes twice running, and G34.
void keep_end(Walk& walk, const Block& block, Command command) {
  const std::string text = code_text(command);
  const bool turns_off = command == Command::CorrectionOff;
  const bool is_second =
      turns_off && walk.kept.turned_off_in && *walk.kept.turned_off_in + 1 == walk.n_blocks;
  const bool clears = !turns_off || is_second;
  pass_order(walk,
             block.line,
             {.text = text, .ends_with_copy = clears && walk.kept.offsets.has_outer_targets});
  if (turns_off) walk.kept.turned_off_in = walk.n_blocks;
  if (clears) {
    walk.kept.targets.clear();
    walk.kept.n_of_last = 0;
    walk.kept.offsets.has_own = false;
    walk.kept.offsets.n_targets = 0;
    if (walk.kept.section) {
      walk.kept.section->n_waiting = 0;
      walk.kept.section->has_series = false;
    }
  }
  walk.kept.base = 0;
  walk.kept.is_fit_in_force = false;
  walk.emitter.put(block.line, CancelCorrection{CorrectionLevel::Base});
}

/// Every copy of the section keeps what it has measured: G31, an offset on top of it, or an offset
/// alone, on top of what is in force round the section. A second G39,SAVE may add the offset: both
/// mean the same location.
KeptOrder save_of_copies(Walk& walk, const std::optional<int>& location) {
  KeptSection& section = *walk.kept.section;
  if (location) {
    walk.kept.sets.erase(*location);  // the last copy's
    return {"G39,SAVE without a number in a section", {}};
  }
  const bool is_offset = walk.kept.offsets.has_own;
  const bool adds_offset = is_offset && section.saved && !section.saved->is_offset;
  if (section.saved && !adds_offset) return {"one G39,SAVE in a section", {}};
  if (section.has_loaded) return {"G39,SAVE and G39,LOAD in sections of their own", {}};
  const bool stands_on_outer = is_offset && walk.kept.base == section.base;
  if (!(section.has_series || stands_on_outer) || !walk.kept.targets.empty()) {
    return {"G32 and G31 before it in the same section", {}};
  }
  if (section.has_late_series) return {"G36 behind G31", {}};
  const CorrectionLevel level = is_offset ? CorrectionLevel::Nested : CorrectionLevel::Base;
  const int label = section.saved ? section.saved->label : ++walk.kept.n_labels;
  section.saved =
      StoredCorrection{StoredCorrectionKind::Keep, label, level, section.n_targets, is_offset};
  section.uses_base |= !section.has_series;
  section.unsaved_offset.reset();
  return {{}, section.saved};
}

/// The program itself keeps the series that it has measured last.
KeptOrder save_at(Walk& walk, const std::optional<int>& location) {
  if (!location) return {"G39,SAVE# with a number", {}};
  walk.kept.sets.erase(*location);
  const bool has_offset = walk.kept.offsets.has_own || walk.kept.offsets.has_outer;
  if (walk.kept.n_of_last == 0 || has_offset || !walk.kept.targets.empty()) {
    return {"G39,SAVE# right behind G31", {}};
  }
  const StoredCorrection keep{
      StoredCorrectionKind::Keep, ++walk.kept.n_labels, CorrectionLevel::Base, walk.kept.n_of_last};
  KeptSet& set = walk.kept.sets[*location];
  set = {keep, walk.kept.base};
  set.correction.copy = 1;
  return {{}, keep};
}

/// The base correction that comes into force with a set, but with an offset alone: Excellon puts
/// that on top of what is in force, G39,LOAD puts both in force. False: they are not the same.
bool take_base_of(Walk& walk, const KeptSet& set) {
  if (set.is_offset_alone()) {
    if (walk.kept.section) walk.kept.section->uses_base = true;
    return set.base == walk.kept.base;
  }
  walk.kept.base = set.base ? *set.base : ++walk.kept.n_bases;
  return true;
}

/// Each copy of the section takes what the copy with its number has kept.
KeptOrder load_of_copies(Walk& walk) {
  KeptSection& section = *walk.kept.section;
  if (section.saved) return {"G39,SAVE and G39,LOAD in sections of their own", {}};
  if (section.has_loaded) return {"one G39,LOAD without a number in a section", {}};
  for (int i = 1; i <= section.n_copies; ++i) {
    const auto set = walk.kept.sets.find(i);
    const bool is_own =
        set != walk.kept.sets.end() && set->second.correction.copy == i &&
        set->second.correction.label == walk.kept.sets.begin()->second.correction.label;
    if (!is_own) return {"a section that saves the corrections of these copies, by G39,SAVE", {}};
  }
  const KeptSet& first = walk.kept.sets.begin()->second;
  if (!take_base_of(walk, first)) return {kOnAnother, {}};
  section.has_loaded = true;
  StoredCorrection use = first.correction;
  use.kind = StoredCorrectionKind::Use;
  use.copy = 0;
  return {{}, use};
}

KeptOrder load_from(Walk& walk, const std::optional<int>& location) {
  const auto set = location ? walk.kept.sets.find(*location) : walk.kept.sets.end();
  if (set == walk.kept.sets.end()) return {"G39,SAVE# with that number, right behind G31", {}};
  if (!take_base_of(walk, set->second)) return {kOnAnother, {}};
  StoredCorrection use = set->second.correction;
  use.kind = StoredCorrectionKind::Use;
  return {{}, use};
}

/// A set replaces an offset too; but that from outside of a section comes back behind the copy if
/// the set is of the same base correction.
KeptOrder load_kept(Walk& walk, const std::optional<int>& location) {
  walk.kept.n_of_last = 0;
  walk.kept.is_fit_in_force = false;
  if (walk.kept.offsets.has_outer) {
    walk.kept.offsets.has_own = walk.kept.may_load_offset;
    return {"G34 before the section, which ends the offset (CAMA) from outside of it", {}};
  }
  KeptOrder kept =
      walk.kept.section && !location ? load_of_copies(walk) : load_from(walk, location);
  walk.kept.offsets.has_own = kept.stored ? kept.stored->is_offset : walk.kept.may_load_offset;
  if (!kept.stored) walk.kept.base = ++walk.kept.n_bases;
  return kept;
}

void clear_sets(Walk& walk, const std::optional<int>& location) {
  if (location) {
    walk.kept.sets.erase(*location);
  } else if (walk.kept.section) {
    for (int i = 1; i <= walk.kept.section->n_copies; ++i) walk.kept.sets.erase(i);
  }
}

void refuse_kept(Walk& walk, const Block& block) {
  walk.reporter.report(Code::NotSupported,
                       block,
                       " has no form in a translation",
                       "`panelcal run`, which executes it");
  walk.ended = true;
}

}  // namespace

// --- sections ----------------------------------------------------------------------------------

/// The innermost patterns are passed on as such; what repeats them is executed, and so is one whose
/// copies have other numbers in every repetition.
bool is_kept(const Walk& walk, const Section& section) {
  constexpr std::int64_t kMostCopies = 10'000;
  return walk.keeps_structure() && section.n_copies() <= kMostCopies &&
         !has_offsets_inside(walk, section) && !(is_repeated(walk) && organizes(walk, section)) &&
         !section.has.calls && !section.has.own_copies &&
         !(section.has.feeds && section.has.old_feed) &&
         copies_begin_alike(
             walk.text.bytes, section, {walk.optical.is_pattern_mode(), walk.deletes_blocks}) &&
         walk.calls.empty() && walk.areas.empty() && !walk.scaling.is_set() &&
         walk.rotation_rad == 0;
}

void run_kept(Walk& walk, int i_section) {
  const Section& section = walk.section(i_section);
  const Modal start = walk.modal;
  const Placement outer = walk.placement;
  const auto programmed_from_passed = walk.frame.inverse();
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
  place(walk, walk.frame);
  walk.emitter.put(section.begin.number, PatternBegin{});
  walk.repeats_tool = true;
  walk.kept.section = KeptSection{.n_copies = static_cast<int>(copies.size()),
                                  .n_waiting = walk.kept.targets.size(),
                                  .base = walk.kept.base};
  walk.kept.is_fit_in_force = false;  // the second copy may begin with another correction
  run_copy(walk, i_section, start);
  walk.repeats_tool = false;
  end_kept_section(walk, section);
  if (walk.has_ended()) return;
  walk.emitter.put(section.closing.number, PatternEnd{copies});
  place(walk, outer);
}

/// Gives the offsets that hold round the copy.
KeptOffsets begin_kept_copy(Walk& walk) {
  const KeptOffsets outer = walk.kept.offsets;
  walk.kept.offsets = {.has_outer = outer.has_own || outer.has_outer,
                       .has_outer_targets = outer.n_targets > 0 || outer.has_outer_targets};
  return outer;
}

void end_kept_copy(Walk& walk, int line, const KeptOffsets& outer) {
  if (std::exchange(walk.kept.offsets, outer).has_own) {
    walk.emitter.put(line, CancelCorrection{CorrectionLevel::Nested});
  }
}

// --- optical measurement -----------------------------------------------------------------------

void keep_optical_order(Walk& walk, const Block& block, Command command) {
  const TargetPlace target = target_place(walk, block, command);
  switch (command) {
    case Command::Measure:
    case Command::FinishMeasure:
      return keep_measured_target(walk, block, command, target);
    case Command::MeasureOffset:
      if (walk.optical.is_pattern_mode()) return keep_pattern_target(walk, block, target.nominal);
      // A hole that a forbidden area leaves out leaves no target: it would only be looked at.
      if (may_drill_target(walk, block.line)) {
        walk.emitter.put(block.line,
                         TargetHole{CorrectionLevel::Base,
                                    target.nominal,
                                    walk.tool->number,
                                    walk.emitter.cut_at(target.line, target.nominal)});
      }
      return;
    case Command::CorrectionOn:
      return keep_series(walk, block.line, "G31");
    default:
      return keep_end(walk, block, command);
  }
}

// --- sets of corrections (G39) -----------------------------------------------------------------

/// In the language itself the order goes on as it is. Without a number of its own it means that of
/// the copy, which has to be written where copies are executed one by one.
void keep_set(Walk& walk, const Block& block) {
  if (block.argument == "REQCOMP") return keep_series(walk, block.line, "G39,REQCOMP");
  const SetOrder order = set_order(block.argument);
  const bool has_location = order.kind == SetOrderKind::Save || order.kind == SetOrderKind::Load ||
                            order.kind == SetOrderKind::Clear;
  std::string text = "G39," + std::string(block.argument);
  std::optional<int> location = order.number;
  if (has_location && !location && !walk.kept.section && !walk.steps.empty()) {
    location = step_number(walk);
    text += std::to_string(*location);
  }
  KeptOrder kept;
  const bool loads = order.kind == SetOrderKind::Load;
  const bool ends_with_copy = loads && (walk.kept.offsets.has_outer || walk.kept.may_load_offset);
  switch (order.kind) {
    case SetOrderKind::Save:
      kept = walk.kept.section ? save_of_copies(walk, location) : save_at(walk, location);
      walk.kept.may_load_offset |= walk.kept.offsets.has_own || walk.kept.offsets.has_outer;
      break;
    case SetOrderKind::Load:
      kept = load_kept(walk, location);
      break;
    case SetOrderKind::Clear:
      clear_sets(walk, location);
      break;
    case SetOrderKind::ClearAll:
      walk.kept.sets.clear();
      break;
    case SetOrderKind::Other:
      walk.kept.targets.clear();  // it uses them up
      walk.kept.is_fit_in_force = false;
      kept.remedy = "the offset calibrated by the control that drills (G39X#Y#, $uvis,calib)";
      break;
  }
  pass_order(
      walk, block.line, {.text = text, .remedy = kept.remedy, .ends_with_copy = ends_with_copy});
  if (kept.stored) walk.emitter.put(block.line, *kept.stored);
}

// --- surface detection -------------------------------------------------------------------------

/// The control probes, and nothing is known of what it finds.
void keep_surface_order(Walk& walk, const Block& block, const Order& order, bool has_place) {
  const auto pass = [&](SurfaceOrderKind kind) {
    const std::optional<Eigen::Vector2d> at_mm =
        has_place ? std::optional(walk.modal.at_mm) : std::nullopt;
    walk.emitter.surface_order(block.line, kind, order.memory, at_mm, walk.base_cut);
  };
  switch (*order.surface) {
    case Command::SurfaceClear:
      walk.has_kept_grid = false;
      return pass(SurfaceOrderKind::ClearMemory);
    case Command::SurfaceDetect:
      return pass(has_place ? SurfaceOrderKind::Detect : SurfaceOrderKind::StoreLast);
    case Command::SurfaceAverage:
      return pass_average(walk, block, order);
    case Command::ProbeRetract:
      return function(walk, block.line, FunctionKind::RetractProbe, "G75");
    case Command::DepthRecord:
      return pass(SurfaceOrderKind::Record);
    case Command::GridReference:
      walk.has_kept_grid = true;
      return pass(SurfaceOrderKind::GridReference);
    default:
      walk.has_kept_grid = true;
      return pass(SurfaceOrderKind::GridPoint);
  }
}

/// G77 goes on with holes. Pieces of a contour are passed on behind the next line's orders.
void skip_kept_grid(Walk& walk, const Block& block, const Order& order) {
  const bool drills =
      !order.motion && !walk.modal.motion && !walk.pattern && parts_of(order) == kXy;
  if (!drills) return refuse_kept(walk, block);
  walk.emitter.put(block.line, SurfaceOrder{.kind = SurfaceOrderKind::Skip});
}

}  // namespace panelcal::sieb_meyer
