// SPDX-License-Identifier: Apache-2.0
// Planes, depth control, peck drilling and measured surfaces.
#include <cmath>
#include <utility>

#include "program/sieb_meyer/figures/peck.h"
#include "program/sieb_meyer/interpreter/interpreter.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {

void Interpreter::set_depths(const Block& block, const Order& order) {
  ramp_start_ = base_cut_;
  const bool routs = (order.motion || modal_.motion) && !order.is_tool_up;
  if (order.h_mm) {
    if (routs) {
      return report(Code::ContourUnclosed, block, quoted(block.text), "H# before the contour");
    }
    if (*order.h_mm < 0) {
      report(Code::ArgumentInvalid, block, quoted(block.text), "H of zero or more");
      return;
    }
    const std::string plane = fmt::format("H{:.3f}", *order.h_mm);
    emitter_.put(block.line, Setting{plane});
    h_mm_ = order.h_mm;
  }
  if (order.z_mm && *order.z_mm < 0) {
    return report(Code::ArgumentInvalid, block, quoted(block.text), "Z of zero or more");
  }
  const bool is_slm = order.slm.value_or(surface_.is_on());
  const bool is_controlled = order.depth_control.value_or(depth_control_);
  const std::optional<double> k_mm = order.k_mm ? order.k_mm : k_mm_;
  const bool is_residual_web = !is_slm && k_mm && *k_mm < 0;
  if (is_residual_web && (order.k_mm || (is_controlled && (order.depth_control || order.slm)))) {
    return report(Code::ArgumentInvalid,
                  block,
                  fmt::format("{} works with K{:.4g}", quoted(block.text), *k_mm),
                  "K of zero or more, but under G71");
  }
  if (order.slm.value_or(false) && order.z_mm) {
    return report(
        Code::ArgumentInvalid, block, quoted(block.text), "G71K#: depths are below the surface");
  }
  if (order.is_ramp && !z_mm_) {
    return report(
        Code::CoordinateMissing, block, quoted(block.text), "Z# before it, where the ramp begins");
  }
  if (order.is_ramp && !order.z_mm) {
    return report(
        Code::CoordinateMissing, block, quoted(block.text), "G6Z# with the plane at the end");
  }
  if (order.is_ramp && is_depth_controlled()) {
    return report(Code::CommandMisplaced,
                  block,
                  quoted(block.text) + " ramps between heights above the table under depth control",
                  "G82, or G70, before the contour");
  }
  if (order.slm && is_routing()) {
    return report(Code::ContourUnclosed, block, quoted(block.text), "a T0 line before it");
  }
  if (order.z_mm) z_mm_ = order.z_mm;
  if (order.k_mm) k_mm_ = order.k_mm;
  if (order.depth_control) depth_control_ = *order.depth_control;
  if (order.depth_control || order.slm) {
    doubts_control_ = !order.depth_control && !*order.slm && surface_.is_on() && depth_control_;
  }
  if (order.slm) {
    *order.slm ? surface_.switch_on() : surface_.switch_off();
    leaves_surface_on_ = *order.slm;
  }
  if (order.depth_control || order.slm) suspend_surface(block, order);
  const bool changes = order.z_mm || order.k_mm || order.h_mm || order.depth_control || order.slm ||
                       order.skips_surface;
  if (!changes) return;
  if (order.skips_surface && has_kept_grid_) skip_kept_grid(block, order);
  update_cut();
  if (order.slm && keeps_structure()) {
    emitter_.put(block.line, SurfaceOrder{.kind = SurfaceOrderKind::Switch, .cut = base_cut_});
  }
  if (peck_.is_on) check_peck(block.line);
}

/// "The depth control remains on until the execution is finished or until a G82 command is called"
/// (manual, 11), and G71 turns it on as well (10.1): so G82 turns off what G71 turned on, until G83
/// or another G71. What G71 keeps beside it the manual leaves open.
void Interpreter::suspend_surface(const Block& block, const Order& order) {
  const bool was_suspended =
      std::exchange(is_surface_suspended_, surface_.is_on() && order.suspends_depth_control);
  if (!is_surface_suspended_ || was_suspended) return;
  report(Code::DepthControlAssumed,
         block,
         quoted(block.text) + " turns it off, until G83 or G71",
         "G70 before G82, or G71 behind it");
}

/// G83 "remains on" until G82 (manual, 11), but what follows G70 is a "program section without
/// depth control" in the example of 10.1, where no G83 stands before.
void Interpreter::judge_control(int line) {
  if (!std::exchange(doubts_control_, false)) return;
  reporter_.report(
      Code::DepthControlAssumed, line, 1, "G83 from before G70 holds on", "G82 or G83 behind G70");
}

bool Interpreter::uses_surface() const {
  return surface_.is_on() && !skips_surface_ && !is_surface_suspended_;
}

/// Depths are below a surface, not above the table.
bool Interpreter::is_depth_controlled() const {
  return depth_control_ || (surface_.is_on() && !is_surface_suspended_);
}

/// Updates the cut of holes and contours from here on, but for what a grid adds at each place.
/// Numbers that the program does not state stay absent: they are those that were entered by hand.
void Interpreter::update_cut() {
  const auto length = [](const std::optional<double>& value_mm) {
    return value_mm ? std::optional(mm(*value_mm)) : std::nullopt;
  };
  base_cut_ = {};
  base_cut_.upper_limit = length(h_mm_);
  if (uses_surface()) {
    base_cut_.control = DepthControl::Slm;
    const std::vector<Length> reference = surface_.reference();
    if (!reference.empty()) {
      base_cut_.surface = reference.front();
      base_cut_.other_surfaces.assign(reference.begin() + 1, reference.end());
    }
  } else if (depth_control_) {
    base_cut_.control = DepthControl::Depth;
  }
  if (base_cut_.is_controlled()) {
    base_cut_.depth = length(k_mm_);
    base_cut_.lower_limit = length(z_mm_);
  } else {
    base_cut_.z = length(z_mm_);
  }
  emitter_.set_cut(base_cut_);
}

/// "For the depth control (relative working plane) the Z-value is the minimum limit for lowering
/// the Z-axis" (manual, Z). On a board that is not probed the height says nothing.
bool Interpreter::is_below_limit() const {
  const DepthOfCut& cut = base_cut_;
  if (!cut.surface || !cut.depth || !cut.lower_limit || !surface_.is_measured()) return false;
  return *cut.surface - *cut.depth < *cut.lower_limit;
}

bool Interpreter::uses_grid() const {
  return surface_.has_grid() && !skips_surface_ && !is_depth_controlled();
}

/// The measured grid raises and lowers the working plane with the surface.
DepthOfCut Interpreter::grid_cut(int line, const Eigen::Vector2d& at_mm, const DepthOfCut& cut) {
  const Eigen::Vector2d nominal_mm =
      place_.placement(position_mm<frame::Programmed>(at_mm)).in_mm();
  const auto surface = surface_.grid_surface_at(line, nominal_mm);
  if (!surface) return cut;
  DepthOfCut moved = cut;
  if (moved.z) *moved.z = *moved.z + surface->deviation;
  moved.surface = surface->heights.front();
  moved.other_surfaces.assign(surface->heights.begin() + 1, surface->heights.end());
  moved.reference = surface_.measured_reference();
  moved.predicted = surface->predicted;
  return moved;
}

// --- peck and pulse drilling -------------------------------------------------------------------

void Interpreter::set_peck(const Block& block, const Order& order) {
  const bool pecks = order.parameters == ParameterKind::Peck;
  const bool pulses = order.parameters == ParameterKind::Pulse;
  const bool routs = (order.motion || modal_.motion) && !order.is_tool_up;
  if ((order.peck || order.pulse || pecks || pulses) && routs) {
    return report(
        Code::ContourUnclosed, block, quoted(block.text), "peck drilling before the contour");
  }
  const bool says_numbers = order.ij_mm[0] || order.ij_mm[1] || order.percent || order.permille;
  if (pecks && says_numbers) {
    if (order.ij_mm[0]) peck_.lowering_mm = *order.ij_mm[0];
    if (order.ij_mm[1]) peck_.first_stroke_mm = *order.ij_mm[1];
    if (order.permille) peck_.factor_permille = *order.permille;
    const bool is_percent = !order.percent || (*order.percent >= 0 && *order.percent <= 100);
    if (!is_percent || peck_.factor_permille > 1000) {
      return report(Code::ArgumentInvalid,
                    block,
                    quoted(block.text),
                    "P of 0 to 100 %, W of 0 to 1000 permille");
    }
  }
  if (order.percent && !pecks) {
    return report(Code::ArgumentInvalid, block, quoted(block.text), "P# with G81");
  }
  if (order.dwell_ms && !pulses) {
    return report(Code::ArgumentInvalid, block, quoted(block.text), "E# with G89");
  }
  if (order.peck.value_or(false) && order.pulse.value_or(false)) {
    return report(Code::CommandMisplaced, block, quoted(block.text), "G81 or G89 in a line");
  }
  if ((order.pulse.value_or(false) && peck_.is_on && order.peck.value_or(true)) ||
      (order.peck.value_or(false) && peck_.is_pulsing && order.pulse.value_or(true))) {
    report(Code::PeckAndPulse,
           block,
           fmt::format("{} while {} is on", quoted(block.text), peck_.is_on ? "G81" : "G89"),
           peck_.is_on ? "G80 before it" : "G88 before it");
  }
  const bool says_pulse_numbers = pulses && (says_numbers || order.dwell_ms || order.r_mm);
  const Peck before = peck_;
  if (order.peck) {
    peck_.is_on = *order.peck;
    if (peck_.is_on) peck_.is_pulsing = false;
  }
  if (order.pulse) {
    peck_.is_pulsing = *order.pulse;
    if (peck_.is_pulsing) peck_.is_on = false;
  }
  pass_peck_ends(block.line, order, before);
  if (peck_.is_on && (order.peck || (pecks && says_numbers))) {
    function(block.line, FunctionKind::PeckOn, "G81" + (pecks ? parameter_text(order) : ""));
    check_peck(block.line);
  }
  if (peck_.is_pulsing && (order.pulse || says_pulse_numbers)) {
    function(block.line, FunctionKind::PulseOn, "G89" + (pulses ? parameter_text(order) : ""));
  }
}

/// "Pulse drilling and peck drilling cannot be used at the same time" (manual, G81 and G89): what
/// ends is passed on before what begins, also where the program does not say that it ends, or a
/// control would be told of both at once.
void Interpreter::pass_peck_ends(int line, const Order& order, const Peck& before) {
  const auto ends = [](const std::optional<bool>& said, bool was_on, bool is_on) {
    return !said.value_or(true) || (was_on && !is_on);
  };
  if (ends(order.pulse, before.is_pulsing, peck_.is_pulsing)) {
    function(line, FunctionKind::PulseOff, "G88");
  }
  if (ends(order.peck, before.is_on, peck_.is_on)) {
    function(line, FunctionKind::PeckOff, "G80");
  }
}

/// The peck numbers of a line as format 5000 writes them.
std::string Interpreter::parameter_text(const Order& order) {
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
void Interpreter::check_peck(int line) {
  const bool is_below_board = is_depth_controlled();
  if (is_below_board ? !k_mm_ : !z_mm_) return;
  // I is a height above the same surface that the working plane is measured from.
  const double distance_mm =
      is_below_board ? peck_.lowering_mm + *k_mm_ : peck_.lowering_mm - *z_mm_;
  if (distance_mm < 0) return;
  const auto strokes = peck_strokes(distance_mm, peck_.first_stroke_mm, peck_.factor_permille);
  if (!strokes) {
    return reporter_.report(Code::CycleInvalid, line, 1, "G81: " + strokes.error(), "");
  }
  if (strokes->reaches_target || peck_.forces_target) return;
  reporter_.report(Code::PeckTargetMissed,
                   line,
                   1,
                   fmt::format("{} partial strokes end {:.3f} mm above the working plane",
                               strokes->strokes_mm.size(),
                               strokes->remaining_mm),
                   "a larger J or W, or PEKM,D at the control");
}

// --- surface detection -------------------------------------------------------------------------

ProbeRequest Interpreter::probe_request(const Block& block, const Order& order) {
  ProbeRequest request;
  request.line = block.line;
  request.file = std::string(place_.pattern.path);
  request.file_sha256 = place_.pattern.sha256;
  request.command = code_text(*order.surface);
  request.nominal = place_.placement(position_mm<frame::Programmed>(modal_.at_mm));
  request.expected = measuring_.corrections().stack.actual_of(request.nominal);
  request.work_zero = place_.work_zero;
  request.path = place_.path;
  // "If a tool is programmed in a block with G79, this tool has priority over BOTL/TOPL."
  const bool is_own_tool = order.tool.has_value();
  request.tool = tool_ ? tool_->number : 0;
  if (probing_tool_ && !is_own_tool) request.tool = *probing_tool_;
  request.memory = order.memory;
  if (depth_control_ && k_mm_) request.depth = mm(*k_mm_);
  if (probing_depth_) request.depth = probing_depth_;
  return request;
}

void Interpreter::take_surface(const Block& block, const Order& order) {
  if (is_routing()) {
    return report(Code::ContourUnclosed, block, quoted(block.text), "a T0 line before it");
  }
  takes_surface_late_ = contour_ == Contour::Positioned;
  if (!keeps_structure()) surface_.take_reference(block.line, *order.memory);
  if (surface_.must_stop()) return;
  emitter_.surface_order(block.line, SurfaceOrderKind::Take, order.memory, std::nullopt);
  update_cut();
}

bool Interpreter::may_take_surface_order(const Block& block, const Order& order, bool probes) {
  const auto refuse = [&](Code code, std::string what, std::string expected) {
    report(code, block, std::move(what), std::move(expected));
    return false;
  };
  if (modal_.motion || is_routing()) {
    return refuse(Code::ContourUnclosed, quoted(block.text), "a T0 line before it");
  }
  if (pattern_) {
    return refuse(Code::CycleUnfinished, panelcal::quoted(pattern_->text), "its second point");
  }
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

void Interpreter::pass_average(const Block& block, const Order& order) {
  emitter_.put(block.line,
               SurfaceOrder{.kind = SurfaceOrderKind::Average,
                            .memory = order.memory,
                            .average = surface_.average_letter()});
}

void Interpreter::surface_order(const Block& block, const Order& order) {
  const bool probes =
      *order.surface == Command::SurfaceDetect || *order.surface == Command::GridReference ||
      *order.surface == Command::GridPoint || *order.surface == Command::DepthRecord;
  if (!may_take_surface_order(block, order, probes)) return;
  // For probing the tool is put away, be it that of the job before, and the dummy tool comes in its
  // place.
  if (order.is_tool_up || (order.is_dummy_tool && tool_)) {
    tool_.reset();
    emitter_.take(block.line, {Tool{}, std::nullopt});
  }
  if (order.is_dummy_tool) function(block.line, FunctionKind::MachineFunction, "TD");
  contour_ = Contour::None;
  machine_at_mm_.reset();
  const bool has_place = move_to(order);
  if (probes && !has_place && *order.surface != Command::SurfaceDetect) {
    return report(Code::CoordinateMissing, block, quoted(block.text), "X#Y# of the place to probe");
  }
  if (has_place && !emitter_.count_target(block.line)) return;
  if (has_place) note_scaling(block.line);
  if (keeps_structure()) return keep_surface_order(block, order, has_place);
  const auto pass = [&](SurfaceOrderKind kind) {
    if (surface_.must_stop()) return;
    const std::optional<Eigen::Vector2d> at_mm =
        has_place ? std::optional(modal_.at_mm) : std::nullopt;
    emitter_.surface_order(block.line, kind, order.memory, at_mm);
  };
  if (*order.surface == Command::SurfaceDetect && !surface_.is_on() &&
      !std::exchange(warned_unbracketed_, true)) {
    report(Code::SurfaceUnbracketed, block, quoted(block.text) + " without G71", "G71 before it");
  }
  switch (*order.surface) {
    case Command::SurfaceClear:
      surface_.clear_memory();
      pass(SurfaceOrderKind::ClearMemory);
      break;
    case Command::SurfaceDetect:
      if (has_place) {
        surface_.detect(probe_request(block, order));
        pass(SurfaceOrderKind::Detect);
      } else {
        surface_.store_last(block.line, order.memory);
        pass(surface_.last_is_of_grid() ? SurfaceOrderKind::StoreGrid
                                        : SurfaceOrderKind::StoreLast);
      }
      break;
    case Command::SurfaceAverage:
      if (!order.memory) {
        return report(Code::ArgumentInvalid, block, quoted(block.text), "G74L#");
      }
      surface_.average(block.line, *order.memory);
      if (!surface_.must_stop()) pass_average(block, order);
      break;
    case Command::ProbeRetract:
      function(block.line, FunctionKind::RetractProbe, "G75");
      break;
    case Command::DepthRecord:
      surface_.record(probe_request(block, order));
      pass(SurfaceOrderKind::Record);
      break;
    case Command::GridReference:
      surface_.grid_reference(probe_request(block, order));
      break;
    default:
      surface_.grid_point(probe_request(block, order));
      break;
  }
  update_cut();
}

}  // namespace panelcal::sieb_meyer
