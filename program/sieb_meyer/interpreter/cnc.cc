// SPDX-License-Identifier: Apache-2.0
// CNC commands that a program gives by M49.
#include <numbers>
#include <string>
#include <utility>

#include "program/sieb_meyer/interpreter/parts.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// SAX3. is 3 micrometres per metre: the manual's example scales by 3 and 100, which no factor and
/// no percentage can mean.
constexpr double kScalePerStep = 1e-6;

constexpr double kRadPerDeg = std::numbers::pi / 180;

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

void pass_on(Walk& walk, const Block& block) {
  walk.emitter.put(block.line, Setting{.text = block.text, .unit = walk.format.unit});
}

void refuse_cnc(Walk& walk, const Block& block, std::string expected) {
  walk.reporter.report(Code::ArgumentInvalid, block.of_argument(), std::move(expected));
}

/// FP in the format that the program is written in changes nothing; outputs state their own.
bool states_own_format(const Walk& walk, const CncCommand& command) {
  return command.info->code == CncCode::FormatSetting && !walk.layout.setting.empty() &&
         command.argument == walk.layout.setting;
}

/// FA is a place on the machine; without it program zero is where the machine's configuration has
/// work zero.
void set_program_zero(Walk& walk, const Block& block, std::string_view argument, bool is_set) {
  const Position<frame::Machine> configured =
      walk.options.absolute_zero + displacement_mm<frame::Machine>(walk.options.work_zero.in_mm());
  Position<frame::Machine> zero = configured;
  if (is_set) {
    const auto xy = read_xy(argument);
    if (!xy || !(*xy)[0] || !(*xy)[1]) {
      return refuse_cnc(walk, block, fmt::format("FAX#Y#, {}", walk.format.unit_name()));
    }
    zero = walk.options.absolute_zero +
           displacement_mm<frame::Machine>(walk.in_mm(*(*xy)[0]), walk.in_mm(*(*xy)[1]));
  }
  // The control may have had another zero before: also one that changes nothing here is passed on.
  const CorrectionStack& stack = walk.measuring.corrections().stack;
  const bool is_correcting = stack.base() != nullptr || stack.nested() != nullptr;
  if (zero != walk.place.work_zero && is_correcting) {
    return walk.reporter.report(
        Code::ZeroSetUnderCorrection, block, "FA before the first target, or behind G30");
  }
  walk.place.work_zero = zero;
  walk.emitter.put(block.line, ZeroSet{zero - walk.options.absolute_zero, zero, !is_set});
}

void set_axis_version(Walk& walk, const Block& block, std::string_view argument) {
  const auto version = parse_count(argument);
  if (!version || *version < 1 || *version > 8) return refuse_cnc(walk, block, "FV1 to FV8");
  const Placement frame(axis_orientation(*version), Eigen::Vector2d::Zero());
  if (frame.linear() != walk.frame.linear()) {
    if (walk.depth > 0 || walk.has_coordinate) {
      return walk.reporter.report(Code::CommandMisplaced,
                                  block,
                                  " changes the axes inside the program",
                                  "FV before the first coordinate, outside all brackets");
    }
    walk.frame = frame;
    place(walk, walk.frame);
  }
  pass_on(walk, block);
}

/// Obeys commands that move programmed coordinates. The effect of a scale and a rotation is in the
/// coordinates, so only the axes and the program zero, as a place, are passed on.
bool obey_placement(Walk& walk, const Block& block, const CncCommand& command) {
  const std::string_view argument = command.argument;
  const auto xy = read_xy(argument);
  const bool has_xy = xy && ((*xy)[0] || (*xy)[1]);
  switch (command.info->code) {
    case CncCode::Scale:
      if (!has_xy) {
        refuse_cnc(walk, block, "SAX#Y# in micrometres per metre");
        return true;
      }
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double steps = (*xy)[axis].value_or(0);
        constexpr double kMostSteps = 100'000;  // a tenth: no board stretches that far
        if (std::abs(steps) > kMostSteps) {
          refuse_cnc(walk, block, "at most 100000 micrometres per metre");
          return true;
        }
        walk.scaling.factor[static_cast<Eigen::Index>(axis)] = 1 + steps * kScalePerStep;
      }
      walk.scaling.is_behind_m92 = !walk.scaling.scales();
      break;
    case CncCode::ScaleCenter:
      if (!has_xy) {
        refuse_cnc(walk, block, fmt::format("SAZX#Y#, {}", walk.format.unit_name()));
        return true;
      }
      walk.scaling.about_mm = {walk.in_mm((*xy)[0].value_or(0)), walk.in_mm((*xy)[1].value_or(0))};
      break;
    case CncCode::NoScale:
      walk.scaling.factor.setOnes();
      walk.scaling.about_mm.setZero();
      walk.scaling.was_assumed = walk.scaling.is_behind_m92 = false;
      break;
    case CncCode::Rotation: {
      const auto angle_deg = read_plain_number(argument);
      if (!angle_deg || std::abs(*angle_deg) > 360) {
        refuse_cnc(walk, block, "RA# in degrees");
        return true;
      }
      walk.rotation_rad = *angle_deg * kRadPerDeg;
      break;
    }
    case CncCode::NoRotation:
      walk.rotation_rad = 0;
      break;
    case CncCode::ProgramZero:
    case CncCode::NoProgramZero:
      set_program_zero(walk, block, argument, command.info->code == CncCode::ProgramZero);
      return true;
    case CncCode::AxisVersion:
      set_axis_version(walk, block, argument);
      return true;
    default:
      return false;
  }
  refresh_placement(walk);
  return true;
}

/// Averages, references and tolerances of surface detection.
bool obey_surface(Walk& walk, const Block& block, const CncCommand& command) {
  std::string_view argument = command.argument;
  switch (command.info->code) {
    case CncCode::Average:
      if (walk.surface.set_average(argument)) break;
      refuse_cnc(walk, block, "SPAV,A or SPAV,M or SPAV,O or SPAV,T");
      return true;
    case CncCode::DetectBottom:
    case CncCode::DetectTop: {
      const auto depth = read_plain_number(argument);
      if (!depth || *depth < 0) {
        refuse_cnc(walk,
                   block,
                   fmt::format("{} with a depth, {}", command.info->name, walk.format.unit_name()));
        return true;
      }
      walk.probing_depth = mm(walk.in_mm(*depth));
      break;
    }
    case CncCode::ToolBottom:
    case CncCode::ToolTop:
      walk.probing_tool = parse_count(argument);
      if (!walk.probing_tool) {
        refuse_cnc(walk, block, std::string(command.info->name) + " with the number of a tool");
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
        refuse_cnc(
            walk,
            block,
            fmt::format("{} with a number, {}", command.info->name, walk.format.unit_name()));
        return true;
      }
      const Length value = mm(walk.in_mm(*number));
      if (is_reference) {
        if (!walk.surface.set_reference_height(value)) {
          // The program does not state the side that a stroke probes.
          refuse_cnc(walk, block, "the height that was set before: there is one reference");
          return true;
        }
      } else {
        walk.surface.set_tolerance(std::string(command.info->name), value);
      }
      break;
    }
    default:
      return false;
  }
  pass_on(walk, block);
  return true;
}

/// The manual's examples have points, and no table has a step: in table B's numbers a length
/// without one is in mm. Elsewhere it may as well count the steps of coordinates.
void obey_command(Walk& walk, const Block& block, const CncCommand& command) {
  if (!walk.format.is_described() && states_lengths(command) && has_bare_number(command.argument)) {
    return walk.reporter.report(
        Code::FormatAmbiguous,
        block.of_argument(),
        "a decimal point: nothing states the step of M49's lengths without one");
  }
  if (obey_placement(walk, block, command) || obey_surface(walk, block, command)) return;
  const std::string_view argument = command.argument;
  switch (command.info->code) {
    case CncCode::NibbleInOrder:
      walk.nibbling.order = NibbleOrder::Sequential;
      break;
    case CncCode::NibbleAlternating:
      walk.nibbling.order = NibbleOrder::Alternating;
      break;
    case CncCode::NibbleRoughness: {
      const auto roughness = read_plain_number(argument);
      const bool is_usable = roughness && *roughness > 0 && walk.in_mm(*roughness) <= 1;
      if (!is_usable) return refuse_cnc(walk, block, "NIB# with the roughness, up to 1 mm");
      walk.nibbling.roughness_mm = walk.in_mm(*roughness);
      break;
    }
    case CncCode::BlockDelete:
    case CncCode::NoBlockDelete:
      if (!walk.calls.empty()) {
        // The program's sections were found before anyone knew of it.
        return walk.reporter.report(Code::CommandMisplaced,
                                    block,
                                    " in a subprogram",
                                    "BLKD and NOBLKD in the program itself");
      }
      walk.deletes_blocks = command.info->code == CncCode::BlockDelete;
      walk.warned_slash = true;
      break;
    case CncCode::PatternMode:
    case CncCode::HoleMode:
      walk.optical.set_pattern_mode(command.info->code == CncCode::PatternMode);
      break;
    case CncCode::ProgramAreas:
      if (const auto is_on = switch_of('C', argument)) walk.obeys_areas = is_on;
      break;
    case CncCode::PeckMode:
      if (const auto is_on = switch_of('D', argument)) walk.peck.forces_target = *is_on;
      break;
    case CncCode::OperatorText:
      walk.settings.text.operator_text = argument;
      break;
    case CncCode::ForbiddenAreas:
      if (argument == "A") walk.areas_in_copies = true;
      if (argument == "M" || argument == "P") walk.areas_in_copies = false;
      break;
    case CncCode::ClearAreas:
      if (argument == "A" || argument == "-A") walk.clears_areas = argument == "A";
      break;
    default:
      return;
  }
  pass_on(walk, block);
}

}  // namespace

void cnc_command(Walk& walk, const Block& block) {
  if (is_machine_function(block.argument)) {
    walk.machine_at_mm.reset();
    return function(walk, block.line, FunctionKind::MachineFunction, block.argument);
  }
  const auto command = find_cnc_command(block.argument);
  if (!command) {
    walk.reporter.report(
        Code::CncCommandUnknown, block.of_argument(), "a CNC command that the manual names");
    return pass_on(walk, block);
  }
  switch (command->info->treatment) {
    case Treatment::Passed:
      return pass_on(walk, block);
    case Treatment::Refused:
      if (switches_off(*command)) return pass_on(walk, block);
      if (states_own_format(walk, *command)) return;
      return walk.reporter.report(Code::NotSupported,
                                  block.of_argument(),
                                  " changes where the tool goes (" +
                                      std::string(command->info->effect) +
                                      ") in a way that the manual does not describe",
                                  "a program without it");
    case Treatment::Obeyed:
      if (command->info->numbers == CncNumbers::Nothing && !command->argument.empty()) {
        return refuse_cnc(
            walk, block, std::string(command->info->name) + " without anything behind it");
      }
      walk.machine_at_mm.reset();
      return obey_command(walk, block, *command);
  }
}

/// Scale and rotation act on the placed coordinates: program zero and the centre of scaling are
/// places on the table.
void refresh_placement(Walk& walk) {
  walk.machine_at_mm.reset();
  walk.place.placement = walk.placement;
  if (walk.scaling.scales() && walk.scaling.is_set()) {
    const Transform<frame::Nominal, frame::Nominal> scale(
        walk.scaling.factor.asDiagonal(),
        walk.scaling.about_mm - walk.scaling.factor.cwiseProduct(walk.scaling.about_mm));
    walk.place.placement = scale * walk.place.placement;
  }
  if (walk.rotation_rad != 0) {
    const double c = std::cos(walk.rotation_rad);
    const double s = std::sin(walk.rotation_rad);
    Eigen::Matrix2d turn;
    turn << c, -s, s, c;
    walk.place.placement =
        Transform<frame::Nominal, frame::Nominal>(turn, Eigen::Vector2d::Zero()) *
        walk.place.placement;
  }
}

/// M93 or M92. "The scaling commands can be used for limiting the scaling function to certain
/// program sections" (manual, 4): without them SA scales. M93 behind coordinates that SA alone has
/// scaled would turn on what is on, which speaks for a program that means them to be unscaled.
void switch_scaling(Walk& walk, const Block& block, bool is_on) {
  if (is_on && !walk.scaling.is_on && walk.scaling.was_assumed) {
    walk.reporter.report(Code::ScalingUndecided,
                         block,
                         " turns scaling on behind coordinates that SA alone scales",
                         "M93 or M92 in the first line with a coordinate behind SA");
  }
  walk.scaling.is_on = is_on;
  walk.scaling.is_behind_m92 = false;
  if (!walk.scaling.takes_over) walk.scaling.takes_over = false;
  refresh_placement(walk);
}

/// A copy of a section ends. The next one begins with the scaling that M93 or M92 has left.
void end_scaled_copy(Walk& walk, int line, const Scaling& before) {
  if (walk.scaling.takes_over == true && walk.steps.back().first > 1 &&
      walk.scaling.scales() != before.scales()) {
    walk.reporter.report(Code::ScalingUndecided,
                         line,
                         fmt::format("the section ends with scaling {} and begins with it {}: its "
                                     "copies would not be alike",
                                     walk.scaling.scales() ? "on (M93)" : "off (M92)",
                                     before.scales() ? "on" : "off"),
                         "M93 or M92 in its first line with a coordinate");
  }
  if (before.takes_over) walk.scaling.takes_over = before.takes_over;
}

/// Warns of a coordinate under a scale of which neither M93 nor M92 has said where it holds.
void note_scaling(Walk& walk, int line) {
  if (!walk.scaling.is_set()) return;
  if (!walk.scaling.takes_over) walk.scaling.takes_over = true;
  const auto warn = [&](std::string what) {
    walk.reporter.report(
        Code::ScalingAssumed, line, std::move(what), "M93 where the scaled section begins, or M92");
  };
  if (std::exchange(walk.scaling.is_behind_m92, false)) {
    return warn("a coordinate comes after SA behind M92, without M93, and is not scaled");
  }
  if (walk.scaling.is_on || std::exchange(walk.scaling.was_assumed, true)) return;
  warn("a coordinate comes after SA without M93 or M92, and is scaled");
}

/// False and an error if a stroke's depth is below a surface that is not named, or below its limit.
bool is_decided(Walk& walk, int line) {
  if (uses_surface(walk) && walk.surface.reference().empty() && !walk.keeps_structure()) {
    if (!std::exchange(walk.reported_surface, true)) {
      walk.reporter.report(Code::SurfaceMissing,
                           line,
                           "a coordinate comes under G71 before any reference surface",
                           "L#, or G73, before it");
    }
    return false;
  }
  if (is_below_limit(walk)) {
    if (!std::exchange(walk.reported_limit, true)) {
      walk.reporter.report(
          Code::ArgumentInvalid,
          line,
          fmt::format("{:.3f} mm below the surface, which was probed at {:.3f} mm, is "
                      "lower than Z{:.3f}, which limits the stroke",
                      walk.base_cut.depth->in_mm(),
                      walk.base_cut.surface->in_mm(),
                      walk.base_cut.lower_limit->in_mm()),
          "a lower Z");
    }
    return false;
  }
  note_scaling(walk, line);
  return true;
}

}  // namespace panelcal::sieb_meyer
