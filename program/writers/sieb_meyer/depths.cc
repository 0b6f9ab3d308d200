// SPDX-License-Identifier: Apache-2.0
// The depth state of the control: planes and limits (Z, K, H), G82 and G83, G71 with its surfaces.
#include <string>
#include <string_view>
#include <utility>

#include "program/writers/sieb_meyer/writer.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// The surface is one that the control has probed by itself, in the same program.
bool is_probed_by_control(const DepthOfCut& cut) {
  return cut.control == DepthControl::Slm && !cut.predicted;
}

std::string slm_line(const std::optional<std::string>& k) {
  return k ? "G71K" + *k : "G71";
}

}  // namespace

/// A depth below a surface of a map is a height that the control need not measure. Null after a
/// refusal; valid until the next call.
const DepthOfCut* SiebMeyerWriter::told_cut(const DepthOfCut& cut) {
  if (is_probed_by_control(cut)) return &cut;
  if (!serves_all_axes(cut)) return nullptr;
  if (cut.counts_from() != DepthReference::Plane) {
    if (cut.surface && !cut.z) {
      refuse("a measured grid under a working plane that the program leaves to the control",
             "Z# for every hole and contour");
      return nullptr;
    }
    // Nearly every hole is made with the tool of the one before.
    if (!cut.is_controlled() && std::exchange(plane_tool_, tool_) != tool_) {
      note_offset_use(plane_tools_, map_tools_);
    }
    return &cut;
  }
  if (!cut.depth) {
    refuse("a measured surface under a depth that the program leaves to the control",
           "K# for every hole and contour");
    return nullptr;
  }
  map_plane_ = {};
  map_plane_.z = *cut.surface - *cut.depth;
  return may_be_plane(cut, *map_plane_.z) ? &map_plane_ : nullptr;
}

bool SiebMeyerWriter::may_be_plane(const DepthOfCut& cut, Length z) {
  if (z < Length()) {
    refuse(fmt::format("a plane {:.4g} mm below the table: the surface is at {:.4g} mm",
                       -z.in_mm(),
                       cut.surface->in_mm()),
           "heights above the table plane Z0, and Z of zero or more");
    return false;
  }
  const auto tool = tools_.find(tool_);
  if (tool != tools_.end() && tool->second.depth_offset.value_or(Length()) != Length()) {
    refuse(fmt::format("a depth below a measured surface of tool {}, whose offset of {:.4g} mm the "
                       "control would add to the plane",
                       tool_,
                       tool->second.depth_offset->in_mm()),
           "a tool without Z in its data");
    return false;
  }
  if (pecks_ || pulses_) {
    refuse("peck or pulse drilling below a measured surface, whose I counts from the board",
           "drilling in one stroke, or depth control");
    return false;
  }
  zero_offset();
  return true;
}

/// The control adds the Z of its tool table "to absolute working plane", and a letter that the file
/// leaves out "remains unchanged" there: one of an earlier job would come to a plane that stands
/// for a depth below the board, to which the source's control adds nothing.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, A.7.1, Tool Parameters
void SiebMeyerWriter::zero_offset() {
  Tool& tool = tools_[tool_];
  tool.number = tool_;
  if (tool.zeroed.find('Z') == std::string::npos) {
    if (tool.depth_offset) return;
    tool.zeroed += 'Z';
  } else if (!map_tools_.contains(tool_)) {
    return;  // so the source has it
  }
  note_offset_use(map_tools_, plane_tools_);
}

void SiebMeyerWriter::note_offset_use(std::set<int>& tools, const std::set<int>& others) {
  if (!tools.insert(tool_).second || !others.contains(tool_)) return;
  lose_once(fmt::format("a Z offset of tool {} that the control's table may have (it becomes zero)",
                        tool_));
}

/// Surface detection is switched in lines of its own, and the control takes the surface of a
/// contour ahead of its T0 line. K under G71 is said with it: a residual web has no other form.
/// Where G71 holds round a section, no G71 may stand in it, so that K has its own word there.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 10.1, G70, G71, L
bool SiebMeyerWriter::needs_surface_line(const DepthOfCut& cut) const {
  if (cut.control != DepthControl::Slm) return depth_.is_slm;
  const bool has_word = is_bracketed_by_slm() && cut.depth && *cut.depth >= Length();
  return !depth_.is_slm || (cut.depth && depth_.k.told != plane_text(*cut.depth) && !has_word);
}

/// Behind G70 follows a "section without depth control" in the example, G83 "remains on" (11):
/// where both were said, G82 or G83 is said again.
void SiebMeyerWriter::say_surface_line(const DepthOfCut& cut) {
  if (!needs_surface_line(cut)) return;
  if (is_bracketed_by_slm()) {
    return refuse(
        "a change of surface detection (G70, G71, G77, G82) in a section that begins "
        "under G71",
        "G70 before the section, and G71 in it");
  }
  depth_.is_slm = cut.control == DepthControl::Slm;
  if (!depth_.is_slm) {
    line("G70");
    if (depth_.is_controlled == true) depth_.is_controlled.reset();
  } else {
    if (cut.depth) depth_.k.tell(plane_text(*cut.depth));
    line(slm_line(cut.depth ? depth_.k.told : std::nullopt));
  }
}

/// The same where the cutter is about to be lowered: a T0 line that begins a contour stands behind
/// it, one that ends a contour before it.
void SiebMeyerWriter::say_surface_line_of_contour(const DepthOfCut& cut) {
  if (!needs_surface_line(cut)) return;
  if (is_tool_up_line_ && !ends_contour_) {
    std::string begin = std::exchange(line_, {});
    say_surface_line(cut);
    line_ = std::move(begin);
    is_tool_up_line_ = true;
    return;
  }
  say_surface_line(cut);
  up_at_.reset();
}

/// In a ramp the tool goes to the new plane evenly (G6), else it is lowered to it.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 8.2, G6, G82, G83
void SiebMeyerWriter::say_depth(const DepthOfCut& cut, bool is_ramp) {
  if (needs_surface_line(cut)) {
    if (is_bracketed_by_slm()) return;  // refused before
    return refuse("a change of surface detection (G70, G71) inside a contour",
                  "it before a T0 line");
  }
  if (!depth_.is_slm) say_control(cut.control == DepthControl::Depth);
  if (cut.is_controlled()) {
    say_plane('K', cut.depth, depth_.k, "a depth (K)");
    say_plane('Z', cut.lower_limit, depth_.z, "a lower limit of the stroke (Z)");
  } else {
    const bool goes_evenly =
        is_ramp && cut.z && depth_.z.told && depth_.z.told != plane_text(*cut.z);
    if (goes_evenly) line_ += "G6";
    say_plane('Z', cut.z, depth_.z, "a depth");
  }
}

/// Standard control is what a program begins with, and unsaid until then.
void SiebMeyerWriter::say_control(bool is_controlled) {
  if (depth_.is_controlled == is_controlled) {
    relies_on_standard_ |= n_open_patterns_ > 0 && !is_controlled && !has_left_standard_;
    return;
  }
  line_ += is_controlled ? "G83" : "G82";
  depth_.is_controlled = is_controlled;
  has_left_standard_ |= is_controlled;
}

/// "During the execution the programmed values overwrite the manual settings" (8.2): once a number
/// is said there is no way back to the operator's.
void SiebMeyerWriter::say_plane(char letter,
                                const std::optional<Length>& value,
                                Plane& plane,
                                std::string_view what) {
  if (!value) {
    plane.is_left_open |= n_open_patterns_ > 0;
    if (!plane.was_told) return;
    return refuse(std::string(what) +
                      " that the program leaves to the control, behind one that it "
                      "states",
                  "Z# or K# for every hole and contour");
  }
  std::string wanted = plane_text(*value);
  if (plane.told == wanted) return;
  check_digits(wanted);
  line_ += letter;
  line_ += wanted;
  plane.tell(std::move(wanted));
}

/// The control does not know at the begin of a copy what it was told before the pattern.
void SiebMeyerWriter::begin_depths_of_copy() {
  begins_with_slm_ = depth_.is_slm;
  depth_.z.told.reset();
  depth_.k.told.reset();
  if (has_left_standard_) depth_.is_controlled.reset();
}

/// The second copy begins with what the first one ends with. "If surface detection is programmed
/// with Step-and-Repeat, it has to be activated and deactivated" (10.1).
void SiebMeyerWriter::end_depths_of_copy() {
  if (!begins_with_slm_ && std::exchange(depth_.is_slm, false)) line("G70");
  if (relies_on_standard_ && depth_.is_controlled != false) {
    line("G82");
    depth_.is_controlled = false;
  }
  for (Plane* plane : {&depth_.z, &depth_.k}) {
    if (plane->is_left_open && plane->was_told) {
      refuse("a depth that a pattern leaves to the control in its first copy, and states behind it",
             "Z# or K# where the pattern begins");
    }
    if (n_open_patterns_ == 1) plane->is_left_open = false;
  }
  if (n_open_patterns_ == 1) relies_on_standard_ = false;
  begin_depths_of_copy();
}

// --- surface detection -------------------------------------------------------------------------

/// The control probes again where panelcal has, and counts K from what it finds. G70 "deactivates
/// the function for detecting, using and storing a reference surface", so G71 stands before
/// them. A T0 line that begins a contour stands behind the order.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 10.1
void SiebMeyerWriter::write(const SurfaceOrder& order) {
  if (is_foreign()) return;
  up_at_.reset();
  if (order.kind == SurfaceOrderKind::Skip) {
    place_words().skips_grid = true;
    return;
  }
  if (order.kind == SurfaceOrderKind::Switch) {
    is_switched_on_ = order.cut.control == DepthControl::Slm;
    return say_surface_line(order.cut);
  }
  if (order.kind == SurfaceOrderKind::GridReference) return probe_grid(order, "G78");
  if (order.kind == SurfaceOrderKind::GridPoint) return probe_grid(order, "G79");
  const bool uses_surface =
      order.kind != SurfaceOrderKind::ClearMemory && order.kind != SurfaceOrderKind::StoreGrid;
  if (uses_surface && !std::exchange(depth_.is_slm, true)) line("G71");
  const std::string memory = order.memory ? fmt::format("L{}", *order.memory) : std::string();
  switch (order.kind) {
    case SurfaceOrderKind::Detect:
      return probe(order, "G73" + memory);
    case SurfaceOrderKind::Record:
      return probe(order, "G76");
    case SurfaceOrderKind::StoreLast:
      return line("G73" + memory);
    case SurfaceOrderKind::StoreGrid:
      return refuse("G73 without a place behind G78 or G79, whose heights are in the planes",
                    "X#Y#G73" + memory);
    case SurfaceOrderKind::Average:
      state_average(order.average);
      return line("G74" + memory);
    case SurfaceOrderKind::Take:
      return line(memory);
    case SurfaceOrderKind::ClearMemory:
      return line("G72");
    case SurfaceOrderKind::Switch:
    case SurfaceOrderKind::GridReference:
    case SurfaceOrderKind::GridPoint:
    case SurfaceOrderKind::Skip:
      return;  // above
  }
}

/// "Whether a through hole stroke or depth hole stroke is carried out" decides G83 with its K.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 10.2, G79
void SiebMeyerWriter::probe_grid(const SurfaceOrder& order, std::string_view command) {
  say_surface_line(order.cut);
  const std::string_view tool = std::exchange(probing_tool_, {});
  open_line(order.place->commanded.in_mm());
  line_ += tool;
  line_ += command;
  say_depth(order.cut, false);
  finish_line();
}

void SiebMeyerWriter::probe(const SurfaceOrder& order, std::string_view command) {
  note_work();
  const std::string_view tool = std::exchange(probing_tool_, {});
  open_line(order.place->commanded.in_mm());
  line_ += tool;
  line_ += command;
  finish_line();
}

}  // namespace panelcal
