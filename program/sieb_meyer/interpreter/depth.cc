// SPDX-License-Identifier: Apache-2.0
// Planes, depth control, peck drilling and measured surfaces.
#include <cmath>
#include <utility>

#include "program/sieb_meyer/figures/peck.h"
#include "program/sieb_meyer/interpreter/parts.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// "The depth control remains on until the execution is finished or until a G82 command is called"
/// (manual, 11), and G71 turns it on as well (10.1): so G82 turns off what G71 turned on, until G83
/// or another G71. What G71 keeps beside it the manual leaves open.
void suspend_surface(Walk& walk, const Block& block, const Order& order) {
  const bool was_suspended = std::exchange(walk.is_surface_suspended,
                                           walk.surface.is_on() && order.suspends_depth_control);
  if (!walk.is_surface_suspended || was_suspended) return;
  walk.reporter.report(Code::DepthControlAssumed,
                       block,
                       " turns it off, until G83 or G71",
                       "G70 before G82, or G71 behind it");
}

/// Depths are below a surface, not above the table.
bool is_depth_controlled(const Walk& walk) {
  return walk.depth_control || (walk.surface.is_on() && !walk.is_surface_suspended);
}

/// "Pulse drilling and peck drilling cannot be used at the same time" (manual, G81 and G89): what
/// ends is passed on before what begins, also where the program does not say that it ends, or a
/// control would be told of both at once.
void pass_peck_ends(Walk& walk, int line, const Order& order, const Peck& before) {
  const auto ends = [](const std::optional<bool>& said, bool was_on, bool is_on) {
    return !said.value_or(true) || (was_on && !is_on);
  };
  if (ends(order.pulse, before.is_pulsing, walk.peck.is_pulsing)) {
    function(walk, line, FunctionKind::PulseOff, "G88");
  }
  if (ends(order.peck, before.is_on, walk.peck.is_on)) {
    function(walk, line, FunctionKind::PeckOff, "G80");
  }
}

/// The peck numbers of a line as format 5000 writes them.
std::string parameter_text(const Order& order) {
  std::string text;
  const auto add = [&text](char letter, const std::optional<double>& value, bool is_length) {
    if (!value) return;
    // A length has the digits of format 5000.
    std::string number = fmt::format("{:.6g}", is_length ? std::round(*value * 1e3) / 1e3 : *value);
    if (is_length && number.find('.') == std::string::npos) number += '.';
    text += letter + number;
  };
  add('I', order.ij_mm[0], true);
  add('P', order.percent, false);
  add('J', order.ij_mm[1], true);
  add('W', order.permille, false);
  add('E', order.dwell_ms, false);
  if (order.parameters == ParameterKind::Pulse) add('R', order.r_mm, true);
  return text;
}

/// Says whether the partial strokes reach the working plane.
void check_peck(Walk& walk, int line) {
  const bool is_below_board = is_depth_controlled(walk);
  if (is_below_board ? !walk.k_mm : !walk.z_mm) return;
  // I is a height above the same surface that the working plane is measured from.
  const double distance_mm =
      is_below_board ? walk.peck.lowering_mm + *walk.k_mm : walk.peck.lowering_mm - *walk.z_mm;
  if (distance_mm < 0) return;
  const auto strokes =
      peck_strokes(distance_mm, walk.peck.first_stroke_mm, walk.peck.factor_permille);
  if (!strokes) {
    return walk.reporter.report(Code::CycleInvalid, line, "G81: " + strokes.error());
  }
  if (strokes->reaches_target || walk.peck.forces_target) return;
  walk.reporter.report(Code::PeckTargetMissed,
                       line,
                       fmt::format("{} partial strokes end {:.3f} mm above the working plane",
                                   strokes->strokes_mm.size(),
                                   strokes->remaining_mm),
                       "a larger J or W, or PEKM,D at the control");
}

ProbeRequest probe_request(Walk& walk, const Block& block, const Order& order) {
  ProbeRequest request;
  request.line = block.line;
  request.file = std::string(walk.place.pattern.path);
  request.file_sha256 = walk.place.pattern.sha256;
  request.command = code_text(*order.surface);
  request.nominal = walk.place.placement(position_mm<frame::Programmed>(walk.modal.at_mm));
  request.expected = walk.measuring.corrections().stack.actual_of(request.nominal);
  request.work_zero = walk.place.work_zero;
  request.path = walk.place.path;
  // "If a tool is programmed in a block with G79, this tool has priority over BOTL/TOPL."
  const bool is_own_tool = order.tool.has_value();
  request.tool = walk.tool ? walk.tool->number : 0;
  if (walk.probing_tool && !is_own_tool) request.tool = *walk.probing_tool;
  request.memory = order.memory;
  if (walk.depth_control && walk.k_mm) request.depth = mm(*walk.k_mm);
  if (walk.probing_depth) request.depth = walk.probing_depth;
  return request;
}

bool may_take_surface_order(Walk& walk, const Block& block, const Order& order, bool probes) {
  const auto refuse = [&](Code code, std::string what, std::string expected) {
    walk.reporter.report(code, block.with(std::move(what)), std::move(expected));
    return false;
  };
  if (refuse_in_contour(walk, block) || refuse_open_pattern(walk, block)) return false;
  if (!probes && (order.has_xy() || order.is_tool_up || order.is_dummy_tool)) {
    return refuse(Code::BlockNotAlone,
                  quoted(block.text),
                  code_text(*order.surface) + " in a line without X, Y and T");
  }
  const bool stores =
      *order.surface == Command::SurfaceDetect || *order.surface == Command::SurfaceAverage;
  if (order.memory && !stores) {
    return refuse(Code::ArgumentInvalid,
                  quoted(block.text),
                  code_text(*order.surface) + " without L#, which G73 and G74 store under");
  }
  return true;
}

/// H; false after a refusal.
bool set_upper_limit(Walk& walk, const Block& block, const Order& order) {
  const bool routs = (order.motion || walk.modal.motion) && !order.is_tool_up;
  if (routs) {
    walk.reporter.report(Code::ContourUnclosed, block, "H# before the contour");
    return false;
  }
  if (*order.h_mm < 0) {
    walk.reporter.report(Code::ArgumentInvalid, block, "H of zero or more");
    return false;
  }
  const std::string plane = fmt::format("H{:.3f}", *order.h_mm);
  walk.emitter.put(block.line, Setting{plane});
  walk.h_mm = order.h_mm;
  return true;
}

}  // namespace

void set_depths(Walk& walk, const Block& block, const Order& order) {
  walk.ramp_start = walk.base_cut;
  if (order.h_mm && !set_upper_limit(walk, block, order)) return;
  if (order.z_mm && *order.z_mm < 0) {
    return walk.reporter.report(Code::ArgumentInvalid, block, "Z of zero or more");
  }
  const bool is_slm = order.slm.value_or(walk.surface.is_on());
  const bool is_controlled = order.depth_control.value_or(walk.depth_control);
  const std::optional<double> k_mm = order.k_mm ? order.k_mm : walk.k_mm;
  const bool is_residual_web = !is_slm && k_mm && *k_mm < 0;
  if (is_residual_web && (order.k_mm || (is_controlled && (order.depth_control || order.slm)))) {
    return walk.reporter.report(Code::ArgumentInvalid,
                                block,
                                fmt::format(" works with K{:.4g}", *k_mm),
                                "K of zero or more, but under G71");
  }
  if (order.slm.value_or(false) && order.z_mm) {
    return walk.reporter.report(
        Code::ArgumentInvalid, block, "G71K#: depths are below the surface");
  }
  if (order.is_ramp && !walk.z_mm) {
    return walk.reporter.report(
        Code::CoordinateMissing, block, "Z# before it, where the ramp begins");
  }
  if (order.is_ramp && !order.z_mm) {
    return walk.reporter.report(Code::CoordinateMissing, block, "G6Z# with the plane at the end");
  }
  if (order.is_ramp && is_depth_controlled(walk)) {
    return walk.reporter.report(Code::CommandMisplaced,
                                block,
                                " ramps between heights above the table under depth control",
                                "G82, or G70, before the contour");
  }
  if (order.slm && walk.is_routing()) {
    return walk.reporter.report(Code::ContourUnclosed, block, "a T0 line before it");
  }
  if (order.z_mm) walk.z_mm = order.z_mm;
  if (order.k_mm) walk.k_mm = order.k_mm;
  if (order.depth_control) walk.depth_control = *order.depth_control;
  if (order.depth_control || order.slm) {
    walk.doubts_control =
        !order.depth_control && !*order.slm && walk.surface.is_on() && walk.depth_control;
  }
  if (order.slm) {
    *order.slm ? walk.surface.switch_on() : walk.surface.switch_off();
    walk.leaves_surface_on = *order.slm;
  }
  if (order.depth_control || order.slm) suspend_surface(walk, block, order);
  const bool changes = order.z_mm || order.k_mm || order.h_mm || order.depth_control || order.slm ||
                       order.skips_surface;
  if (!changes) return;
  if (order.skips_surface && walk.has_kept_grid) skip_kept_grid(walk, block, order);
  update_cut(walk);
  if (order.slm && walk.keeps_structure()) {
    walk.emitter.put(block.line,
                     SurfaceOrder{.kind = SurfaceOrderKind::Switch, .cut = walk.base_cut});
  }
  if (walk.peck.is_on) check_peck(walk, block.line);
}

/// G83 "remains on" until G82 (manual, 11), but what follows G70 is a "program section without
/// depth control" in the example of 10.1, where no G83 stands before.
void judge_control(Walk& walk, int line) {
  if (!std::exchange(walk.doubts_control, false)) return;
  walk.reporter.report(
      Code::DepthControlAssumed, line, "G83 from before G70 holds on", "G82 or G83 behind G70");
}

bool uses_surface(const Walk& walk) {
  return walk.surface.is_on() && !walk.skips_surface && !walk.is_surface_suspended;
}

/// Updates the cut of holes and contours from here on, but for what a grid adds at each place.
/// Numbers that the program does not state stay absent: they are those that were entered by hand.
void update_cut(Walk& walk) {
  const auto length = [](const std::optional<double>& value_mm) {
    return value_mm ? std::optional(mm(*value_mm)) : std::nullopt;
  };
  walk.base_cut = {};
  walk.base_cut.upper_limit = length(walk.h_mm);
  if (uses_surface(walk)) {
    walk.base_cut.control = DepthControl::Slm;
    const std::vector<Length> reference = walk.surface.reference();
    if (!reference.empty()) {
      walk.base_cut.surface = reference.front();
      walk.base_cut.other_surfaces.assign(reference.begin() + 1, reference.end());
    }
  } else if (walk.depth_control) {
    walk.base_cut.control = DepthControl::Depth;
  }
  if (walk.base_cut.is_controlled()) {
    walk.base_cut.depth = length(walk.k_mm);
    walk.base_cut.lower_limit = length(walk.z_mm);
  } else {
    walk.base_cut.z = length(walk.z_mm);
  }
  walk.emitter.set_cut(walk.base_cut);
}

/// "For the depth control (relative working plane) the Z-value is the minimum limit for lowering
/// the Z-axis" (manual, Z). On a board that is not probed the height says nothing.
bool is_below_limit(const Walk& walk) {
  const DepthOfCut& cut = walk.base_cut;
  if (!cut.surface || !cut.depth || !cut.lower_limit || !walk.surface.is_measured()) return false;
  return *cut.surface - *cut.depth < *cut.lower_limit;
}

bool uses_grid(const Walk& walk) {
  return walk.surface.has_grid() && !walk.skips_surface && !is_depth_controlled(walk);
}

/// The measured grid raises and lowers the working plane with the surface.
DepthOfCut grid_cut(Walk& walk, int line, const Eigen::Vector2d& at_mm, const DepthOfCut& cut) {
  const Eigen::Vector2d nominal_mm =
      walk.place.placement(position_mm<frame::Programmed>(at_mm)).in_mm();
  const auto surface = walk.surface.grid_surface_at(line, nominal_mm);
  if (!surface) return cut;
  DepthOfCut moved = cut;
  if (moved.z) *moved.z = *moved.z + surface->deviation;
  moved.surface = surface->heights.front();
  moved.other_surfaces.assign(surface->heights.begin() + 1, surface->heights.end());
  moved.reference = walk.surface.measured_reference();
  moved.predicted = surface->predicted;
  return moved;
}

DepthOfCut cut_at(Walk& walk, int line, const Eigen::Vector2d& at_mm) {
  return uses_grid(walk) ? grid_cut(walk, line, at_mm, walk.base_cut) : walk.base_cut;
}

// --- peck and pulse drilling -------------------------------------------------------------------

void set_peck(Walk& walk, const Block& block, const Order& order) {
  const bool pecks = order.parameters == ParameterKind::Peck;
  const bool pulses = order.parameters == ParameterKind::Pulse;
  const bool routs = (order.motion || walk.modal.motion) && !order.is_tool_up;
  if ((order.peck || order.pulse || pecks || pulses) && routs) {
    return walk.reporter.report(Code::ContourUnclosed, block, "peck drilling before the contour");
  }
  const bool says_numbers = order.ij_mm[0] || order.ij_mm[1] || order.percent || order.permille;
  if (pecks && says_numbers) {
    if (order.ij_mm[0]) walk.peck.lowering_mm = *order.ij_mm[0];
    if (order.ij_mm[1]) walk.peck.first_stroke_mm = *order.ij_mm[1];
    if (order.permille) walk.peck.factor_permille = *order.permille;
    const bool is_percent = !order.percent || (*order.percent >= 0 && *order.percent <= 100);
    if (!is_percent || walk.peck.factor_permille > 1000) {
      return walk.reporter.report(
          Code::ArgumentInvalid, block, "P of 0 to 100 %, W of 0 to 1000 permille");
    }
  }
  if (order.percent && !pecks) {
    return walk.reporter.report(Code::ArgumentInvalid, block, "P# with G81");
  }
  if (order.dwell_ms && !pulses) {
    return walk.reporter.report(Code::ArgumentInvalid, block, "E# with G89");
  }
  if (order.peck.value_or(false) && order.pulse.value_or(false)) {
    return walk.reporter.report(Code::CommandMisplaced, block, "G81 or G89 in a line");
  }
  if ((order.pulse.value_or(false) && walk.peck.is_on && order.peck.value_or(true)) ||
      (order.peck.value_or(false) && walk.peck.is_pulsing && order.pulse.value_or(true))) {
    walk.reporter.report(Code::PeckAndPulse,
                         block,
                         fmt::format(" while {} is on", walk.peck.is_on ? "G81" : "G89"),
                         walk.peck.is_on ? "G80 before it" : "G88 before it");
  }
  const bool says_pulse_numbers = pulses && (says_numbers || order.dwell_ms || order.r_mm);
  const Peck before = walk.peck;
  if (order.peck) {
    walk.peck.is_on = *order.peck;
    if (walk.peck.is_on) walk.peck.is_pulsing = false;
  }
  if (order.pulse) {
    walk.peck.is_pulsing = *order.pulse;
    if (walk.peck.is_pulsing) walk.peck.is_on = false;
  }
  pass_peck_ends(walk, block.line, order, before);
  if (walk.peck.is_on && (order.peck || (pecks && says_numbers))) {
    function(walk, block.line, FunctionKind::PeckOn, "G81" + (pecks ? parameter_text(order) : ""));
    check_peck(walk, block.line);
  }
  if (walk.peck.is_pulsing && (order.pulse || says_pulse_numbers)) {
    function(
        walk, block.line, FunctionKind::PulseOn, "G89" + (pulses ? parameter_text(order) : ""));
  }
}

// --- surface detection -------------------------------------------------------------------------

void take_surface(Walk& walk, const Block& block, const Order& order) {
  if (walk.is_routing()) {
    return walk.reporter.report(Code::ContourUnclosed, block, "a T0 line before it");
  }
  walk.takes_surface_late = walk.contour == Contour::Positioned;
  if (!walk.keeps_structure()) walk.surface.take_reference(block.line, *order.memory);
  if (walk.surface.must_stop()) return;
  walk.emitter.surface_order(block.line, SurfaceOrderKind::Take, order.memory, std::nullopt);
  update_cut(walk);
}

void pass_average(Walk& walk, const Block& block, const Order& order) {
  walk.emitter.put(block.line,
                   SurfaceOrder{.kind = SurfaceOrderKind::Average,
                                .memory = order.memory,
                                .average = walk.surface.average_letter()});
}

void surface_order(Walk& walk, const Block& block, const Order& order) {
  const bool probes =
      *order.surface == Command::SurfaceDetect || *order.surface == Command::GridReference ||
      *order.surface == Command::GridPoint || *order.surface == Command::DepthRecord;
  if (!may_take_surface_order(walk, block, order, probes)) return;
  // For probing the tool is put away, be it that of the job before, and the dummy tool comes in its
  // place.
  if (order.is_tool_up || (order.is_dummy_tool && walk.tool)) {
    walk.tool.reset();
    walk.emitter.take(block.line, {Tool{}, std::nullopt});
  }
  if (order.is_dummy_tool) function(walk, block.line, FunctionKind::MachineFunction, "TD");
  walk.contour = Contour::None;
  walk.machine_at_mm.reset();
  const bool has_place = move_to(walk, order);
  if (probes && !has_place && *order.surface != Command::SurfaceDetect) {
    return walk.reporter.report(Code::CoordinateMissing, block, "X#Y# of the place to probe");
  }
  if (has_place && !walk.emitter.count_target(block.line)) return;
  if (has_place) note_scaling(walk, block.line);
  if (walk.keeps_structure()) return keep_surface_order(walk, block, order, has_place);
  const auto pass = [&](SurfaceOrderKind kind) {
    if (walk.surface.must_stop()) return;
    const std::optional<Eigen::Vector2d> at_mm =
        has_place ? std::optional(walk.modal.at_mm) : std::nullopt;
    walk.emitter.surface_order(block.line, kind, order.memory, at_mm);
  };
  if (*order.surface == Command::SurfaceDetect && !walk.surface.is_on() &&
      !std::exchange(walk.warned_unbracketed, true)) {
    walk.reporter.report(Code::SurfaceUnbracketed, block, " without G71", "G71 before it");
  }
  switch (*order.surface) {
    case Command::SurfaceClear:
      walk.surface.clear_memory();
      pass(SurfaceOrderKind::ClearMemory);
      break;
    case Command::SurfaceDetect:
      if (has_place) {
        walk.surface.detect(probe_request(walk, block, order));
        pass(SurfaceOrderKind::Detect);
      } else {
        walk.surface.store_last(block.line, order.memory);
        pass(walk.surface.last_is_of_grid() ? SurfaceOrderKind::StoreGrid
                                            : SurfaceOrderKind::StoreLast);
      }
      break;
    case Command::SurfaceAverage:
      if (!order.memory) {
        return walk.reporter.report(Code::ArgumentInvalid, block, "G74L#");
      }
      walk.surface.average(block.line, *order.memory);
      if (!walk.surface.must_stop()) pass_average(walk, block, order);
      break;
    case Command::ProbeRetract:
      function(walk, block.line, FunctionKind::RetractProbe, "G75");
      break;
    case Command::DepthRecord:
      walk.surface.record(probe_request(walk, block, order));
      pass(SurfaceOrderKind::Record);
      break;
    case Command::GridReference:
      walk.surface.grid_reference(probe_request(walk, block, order));
      break;
    default:
      walk.surface.grid_point(probe_request(walk, block, order));
      break;
  }
  update_cut(walk);
}

}  // namespace panelcal::sieb_meyer
