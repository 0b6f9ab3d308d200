// SPDX-License-Identifier: Apache-2.0
// CNC commands that a program gives by M49.
#include <numbers>
#include <string>
#include <utility>

#include "program/sieb_meyer/interpreter/interpreter.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// SAX3. is 3 micrometres per metre: the manual's example scales by 3 and 100, which no factor and
/// no percentage can mean.
constexpr double kScalePerStep = 1e-6;

constexpr double kRadPerDeg = std::numbers::pi / 180;

bool takes_argument(CncCode code) {
  switch (code) {
    case CncCode::NoScale:
    case CncCode::NoProgramZero:
    case CncCode::NoRotation:
    case CncCode::NibbleInOrder:
    case CncCode::NibbleAlternating:
    case CncCode::BlockDelete:
    case CncCode::NoBlockDelete:
    case CncCode::PatternMode:
    case CncCode::HoleMode:
      return false;
    default:
      return true;
  }
}

/// `C`, `-C` or either among other letters, `-C,I`; absent where the letter is not among them.
std::optional<bool> switch_of(char letter, std::string_view argument) {
  std::optional<bool> is_on;
  while (!argument.empty()) {
    const auto comma = argument.find(',');
    std::string_view word = argument.substr(0, comma);
    const bool is_negated = word.starts_with('-');
    if (is_negated) word.remove_prefix(1);
    if (word == std::string_view(&letter, 1)) is_on = !is_negated;
    if (comma == std::string_view::npos) break;
    argument.remove_prefix(comma + 1);
  }
  return is_on;
}

/// A command that would change where the tool goes, in a form that switches it off: ROV0, and the
/// letters of INDX with a minus (the notation of PRGM,-I and PEKM,-D).
bool switches_off(const CncCommand& command) {
  if (command.info->code == CncCode::RoutVersion) return command.argument == "0";
  if (command.info->code != CncCode::IndexTable || command.argument.empty()) return false;
  std::string_view rest = command.argument;
  while (true) {
    if (rest.size() < 2 || rest[0] != '-' || rest[1] < 'A' || rest[1] > 'Z') return false;
    rest.remove_prefix(2);
    if (rest.empty()) return true;
    if (rest.front() != ',') return false;
    rest.remove_prefix(1);
  }
}

bool is_machine_function(std::string_view text) {
  return text.size() >= 2 && text.front() == 'M' && parse_count(text.substr(1)).has_value();
}

}  // namespace

void Interpreter::refuse_cnc(const Block& block, std::string expected) {
  reporter_.report(Code::ArgumentInvalid,
                   block.line,
                   block.argument_column,
                   quoted(block.argument),
                   std::move(expected));
}

void Interpreter::cnc_command(const Block& block) {
  if (is_machine_function(block.argument)) {
    machine_at_mm_.reset();
    return function(block.line, FunctionKind::MachineFunction, block.argument);
  }
  const auto command = find_cnc_command(block.argument);
  if (!command) {
    reporter_.report(Code::CncCommandUnknown,
                     block.line,
                     block.argument_column,
                     quoted(block.argument),
                     "a CNC command that the manual names");
    return emitter_.put(block.line, Setting{.text = block.text, .unit = format_.unit});
  }
  switch (command->info->treatment) {
    case Treatment::Passed:
      return emitter_.put(block.line, Setting{.text = block.text, .unit = format_.unit});
    case Treatment::Refused:
      if (switches_off(*command))
        return emitter_.put(block.line, Setting{.text = block.text, .unit = format_.unit});
      if (states_own_format(*command)) return;
      return reporter_.report(Code::NotSupported,
                              block.line,
                              block.argument_column,
                              quoted(block.argument) + " changes where the tool goes (" +
                                  std::string(command->info->effect) +
                                  ") in a way that the manual does not describe",
                              "a program without it");
    case Treatment::Obeyed:
      if (!takes_argument(command->info->code) && !command->argument.empty()) {
        return refuse_cnc(block, std::string(command->info->name) + " without anything behind it");
      }
      machine_at_mm_.reset();
      return obey(block, *command);
  }
}

/// FP in the format that the program is written in changes nothing; outputs state their own.
bool Interpreter::states_own_format(const CncCommand& command) const {
  return command.info->code == CncCode::FormatSetting && !layout_.setting.empty() &&
         command.argument == layout_.setting;
}

/// The manual's examples have points, and no table has a step: in table B's numbers a length
/// without one is in mm. Elsewhere it may as well count the steps of coordinates.
void Interpreter::obey(const Block& block, const CncCommand& command) {
  if (!format_.is_described() && states_lengths(command) && has_bare_number(command.argument)) {
    return reporter_.report(
        Code::FormatAmbiguous,
        block.line,
        block.argument_column,
        quoted(block.argument),
        "a decimal point: nothing states the step of M49's lengths without one");
  }
  if (obey_placement(block, command) || obey_surface(block, command)) return;
  const std::string_view argument = command.argument;
  switch (command.info->code) {
    case CncCode::NibbleInOrder:
      nibbling_.order = NibbleOrder::Sequential;
      break;
    case CncCode::NibbleAlternating:
      nibbling_.order = NibbleOrder::Alternating;
      break;
    case CncCode::NibbleRoughness: {
      const auto roughness = read_plain_number(argument);
      const bool is_usable = roughness && *roughness > 0 && in_mm(*roughness) <= 1;
      if (!is_usable) return refuse_cnc(block, "NIB# with the roughness, up to 1 mm");
      nibbling_.roughness_mm = in_mm(*roughness);
      break;
    }
    case CncCode::BlockDelete:
    case CncCode::NoBlockDelete:
      if (!calls_.empty()) {
        // The program's sections were found before anyone knew of it.
        return report(Code::CommandMisplaced,
                      block,
                      quoted(block.text) + " in a subprogram",
                      "BLKD and NOBLKD in the program itself");
      }
      deletes_blocks_ = command.info->code == CncCode::BlockDelete;
      warned_slash_ = true;
      break;
    case CncCode::PatternMode:
    case CncCode::HoleMode:
      optical_.set_pattern_mode(command.info->code == CncCode::PatternMode);
      break;
    case CncCode::ProgramAreas:
      if (const auto is_on = switch_of('C', argument)) obeys_areas_ = is_on;
      break;
    case CncCode::PeckMode:
      if (const auto is_on = switch_of('D', argument)) peck_.forces_target = *is_on;
      break;
    case CncCode::OperatorText:
      settings_.text.operator_text = argument;
      break;
    case CncCode::ForbiddenAreas:
      if (argument == "A") areas_in_copies_ = true;
      if (argument == "M" || argument == "P") areas_in_copies_ = false;
      break;
    case CncCode::ClearAreas:
      if (argument == "A" || argument == "-A") clears_areas_ = argument == "A";
      break;
    default:
      return;
  }
  emitter_.put(block.line, Setting{.text = block.text, .unit = format_.unit});
}

/// Obeys commands that move programmed coordinates. The effect of a scale and a rotation is in the
/// coordinates, so only the axes and the program zero, as a place, are passed on.
bool Interpreter::obey_placement(const Block& block, const CncCommand& command) {
  const std::string_view argument = command.argument;
  const auto xy = read_xy(argument);
  const bool has_xy = xy && ((*xy)[0] || (*xy)[1]);
  switch (command.info->code) {
    case CncCode::Scale:
      if (!has_xy) {
        refuse_cnc(block, "SAX#Y# in micrometres per metre");
        return true;
      }
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double steps = (*xy)[axis].value_or(0);
        constexpr double kMostSteps = 100'000;  // a tenth: no board stretches that far
        if (std::abs(steps) > kMostSteps) {
          refuse_cnc(block, "at most 100000 micrometres per metre");
          return true;
        }
        scaling_.factor[static_cast<Eigen::Index>(axis)] = 1 + steps * kScalePerStep;
      }
      scaling_.is_behind_m92 = !scaling_.scales();
      break;
    case CncCode::ScaleCenter:
      if (!has_xy) {
        refuse_cnc(block, fmt::format("SAZX#Y#, {}", format_.unit_name()));
        return true;
      }
      scaling_.about_mm = {in_mm((*xy)[0].value_or(0)), in_mm((*xy)[1].value_or(0))};
      break;
    case CncCode::NoScale:
      scaling_.factor.setOnes();
      scaling_.about_mm.setZero();
      scaling_.was_assumed = scaling_.is_behind_m92 = false;
      break;
    case CncCode::Rotation: {
      const auto angle_deg = read_plain_number(argument);
      if (!angle_deg || std::abs(*angle_deg) > 360) {
        refuse_cnc(block, "RA# in degrees");
        return true;
      }
      rotation_rad_ = *angle_deg * kRadPerDeg;
      break;
    }
    case CncCode::NoRotation:
      rotation_rad_ = 0;
      break;
    case CncCode::ProgramZero:
    case CncCode::NoProgramZero:
      set_program_zero(block, argument, command.info->code == CncCode::ProgramZero);
      return true;
    case CncCode::AxisVersion:
      set_axis_version(block, argument);
      return true;
    default:
      return false;
  }
  refresh_placement();
  return true;
}

/// FA is a place on the machine; without it program zero is where the machine's configuration has
/// work zero.
void Interpreter::set_program_zero(const Block& block, std::string_view argument, bool is_set) {
  const Position<frame::Machine> configured =
      options_.absolute_zero + displacement_mm<frame::Machine>(options_.work_zero.in_mm());
  Position<frame::Machine> zero = configured;
  if (is_set) {
    const auto xy = read_xy(argument);
    if (!xy || !(*xy)[0] || !(*xy)[1]) {
      return refuse_cnc(block, fmt::format("FAX#Y#, {}", format_.unit_name()));
    }
    zero = options_.absolute_zero +
           displacement_mm<frame::Machine>(in_mm(*(*xy)[0]), in_mm(*(*xy)[1]));
  }
  // The control may have had another zero before: also one that changes nothing here is passed on.
  const CorrectionStack& stack = measuring_.corrections().stack;
  const bool is_correcting = stack.base() != nullptr || stack.nested() != nullptr;
  if (zero != place_.work_zero && is_correcting) {
    return report(Code::ZeroSetUnderCorrection,
                  block,
                  quoted(block.text),
                  "FA before the first target, or behind G30");
  }
  place_.work_zero = zero;
  emitter_.put(block.line, ZeroSet{zero - options_.absolute_zero, zero, !is_set});
}

void Interpreter::set_axis_version(const Block& block, std::string_view argument) {
  const auto version = parse_count(argument);
  if (!version || *version < 1 || *version > 8) return refuse_cnc(block, "FV1 to FV8");
  const Placement frame(axis_orientation(*version), Eigen::Vector2d::Zero());
  if (frame.linear() != frame_.linear()) {
    if (depth_ > 0 || has_coordinate_) {
      return report(Code::CommandMisplaced,
                    block,
                    quoted(block.text) + " changes the axes inside the program",
                    "FV before the first coordinate, outside all brackets");
    }
    frame_ = frame;
    place(frame_);
  }
  emitter_.put(block.line, Setting{.text = block.text, .unit = format_.unit});
}

/// Averages, references and tolerances of surface detection.
bool Interpreter::obey_surface(const Block& block, const CncCommand& command) {
  std::string_view argument = command.argument;
  switch (command.info->code) {
    case CncCode::Average:
      if (surface_.set_average(argument)) break;
      refuse_cnc(block, "SPAV,A or SPAV,M or SPAV,O or SPAV,T");
      return true;
    case CncCode::DetectBottom:
    case CncCode::DetectTop: {
      const auto depth = read_plain_number(argument);
      if (!depth || *depth < 0) {
        refuse_cnc(block,
                   fmt::format("{} with a depth, {}", command.info->name, format_.unit_name()));
        return true;
      }
      probing_depth_ = mm(in_mm(*depth));
      break;
    }
    case CncCode::ToolBottom:
    case CncCode::ToolTop:
      probing_tool_ = parse_count(argument);
      if (!probing_tool_) {
        refuse_cnc(block, std::string(command.info->name) + " with the number of a tool");
        return true;
      }
      break;
    case CncCode::ReferenceBottom:
    case CncCode::ReferenceTop:
    case CncCode::ToleranceBottom:
    case CncCode::ToleranceTop:
    case CncCode::ToleranceMap: {
      const bool is_reference = command.info->code == CncCode::ReferenceBottom ||
                                command.info->code == CncCode::ReferenceTop;
      if (argument.starts_with('R')) argument.remove_prefix(1);
      const auto number = read_plain_number(argument);
      if (!number || (!is_reference && *number <= 0)) {
        refuse_cnc(block,
                   fmt::format("{} with a number, {}", command.info->name, format_.unit_name()));
        return true;
      }
      const Length value = mm(in_mm(*number));
      if (is_reference) {
        if (!surface_.set_reference_height(value)) {
          // The program does not state the side that a stroke probes.
          refuse_cnc(block, "the height that was set before: there is one reference");
          return true;
        }
      } else {
        surface_.set_tolerance(std::string(command.info->name), value);
      }
      break;
    }
    default:
      return false;
  }
  emitter_.put(block.line, Setting{.text = block.text, .unit = format_.unit});
  return true;
}

/// Scale and rotation act on the placed coordinates: program zero and the centre of scaling are
/// places on the table.
void Interpreter::refresh_placement() {
  machine_at_mm_.reset();
  place_.placement = placement_;
  if (scaling_.scales() && scaling_.is_set()) {
    const Transform<frame::Nominal, frame::Nominal> scale(
        scaling_.factor.asDiagonal(),
        scaling_.about_mm - scaling_.factor.cwiseProduct(scaling_.about_mm));
    place_.placement = scale * place_.placement;
  }
  if (rotation_rad_ != 0) {
    const double c = std::cos(rotation_rad_);
    const double s = std::sin(rotation_rad_);
    Eigen::Matrix2d turn;
    turn << c, -s, s, c;
    place_.placement =
        Transform<frame::Nominal, frame::Nominal>(turn, Eigen::Vector2d::Zero()) * place_.placement;
  }
}

/// M93 or M92. "The scaling commands can be used for limiting the scaling function to certain
/// program sections" (manual, 4): without them SA scales. M93 behind coordinates that SA alone has
/// scaled would turn on what is on, which speaks for a program that means them to be unscaled.
void Interpreter::switch_scaling(const Block& block, bool is_on) {
  if (is_on && !scaling_.is_on && scaling_.was_assumed) {
    report(Code::ScalingUndecided,
           block,
           quoted(block.text) + " turns scaling on behind coordinates that SA alone scales",
           "M93 or M92 in the first line with a coordinate behind SA");
  }
  scaling_.is_on = is_on;
  scaling_.is_behind_m92 = false;
  if (!scaling_.takes_over) scaling_.takes_over = false;
  refresh_placement();
}

/// A copy of a section ends. The next one begins with the scaling that M93 or M92 has left.
void Interpreter::end_scaled_copy(int line, const Scaling& before) {
  if (scaling_.takes_over == true && steps_.back().first > 1 &&
      scaling_.scales() != before.scales()) {
    reporter_.report(Code::ScalingUndecided,
                     line,
                     1,
                     fmt::format("the section ends with scaling {} and begins with it {}: its "
                                 "copies would not be alike",
                                 scaling_.scales() ? "on (M93)" : "off (M92)",
                                 before.scales() ? "on" : "off"),
                     "M93 or M92 in its first line with a coordinate");
  }
  if (before.takes_over) scaling_.takes_over = before.takes_over;
}

/// Warns of a coordinate under a scale of which neither M93 nor M92 has said where it holds.
void Interpreter::note_scaling(int line) {
  if (!scaling_.is_set()) return;
  if (!scaling_.takes_over) scaling_.takes_over = true;
  const auto warn = [&](std::string what) {
    reporter_.report(Code::ScalingAssumed,
                     line,
                     1,
                     std::move(what),
                     "M93 where the scaled section begins, or M92");
  };
  if (std::exchange(scaling_.is_behind_m92, false)) {
    return warn("a coordinate comes after SA behind M92, without M93, and is not scaled");
  }
  if (scaling_.is_on || std::exchange(scaling_.was_assumed, true)) return;
  warn("a coordinate comes after SA without M93 or M92, and is scaled");
}

/// False and an error if a stroke's depth is below a surface that is not named, or below its limit.
bool Interpreter::is_decided(int line) {
  if (uses_surface() && surface_.reference().empty() && !keeps_structure()) {
    if (!std::exchange(reported_surface_, true)) {
      reporter_.report(Code::SurfaceMissing,
                       line,
                       1,
                       "a coordinate comes under G71 before any reference surface",
                       "L#, or G73, before it");
    }
    return false;
  }
  if (is_below_limit()) {
    if (!std::exchange(reported_limit_, true)) {
      reporter_.report(Code::ArgumentInvalid,
                       line,
                       1,
                       fmt::format("{:.3f} mm below the surface, which was probed at {:.3f} mm, is "
                                   "lower than Z{:.3f}, which limits the stroke",
                                   base_cut_.depth->in_mm(),
                                   base_cut_.surface->in_mm(),
                                   base_cut_.lower_limit->in_mm()),
                       "a lower Z");
    }
    return false;
  }
  note_scaling(line);
  return true;
}

}  // namespace panelcal::sieb_meyer
