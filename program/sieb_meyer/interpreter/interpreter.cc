// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "program/sieb_meyer/interpreter/parts.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

constexpr std::size_t kLongLine = 64;

/// A letter without a number is zero. A number without a point counts steps from the right, and has
/// as many digits as it likes, or it counts from the left.
NumberFormat plain_format(const ProgramFormat& format) {
  constexpr int kAnyDigits = 12;
  return {
      .unit = format.unit,
      .zeros = format.zeros,
      .integer_digits = format.zeros == Zeros::LeadingKept ? format.integer_digits() : kAnyDigits,
      .decimal_digits = format.decimal_digits()};
}

void end_program(Walk& walk) {
  const int line = walk.cursor.line_number();
  if (walk.is_routing()) {
    walk.reporter.report(Code::ContourUnclosed,
                         line,
                         "the program ends while a contour is being routed",
                         "a T0 line at its end");
  }
  end_contour(walk, line);
  report_open_pattern(walk, "");
  if (walk.surface.is_on() && walk.leaves_surface_on) {
    walk.reporter.report(Code::SurfaceUnbracketed,
                         line,
                         "the program ends with surface detection on (G71)",
                         "G70 before its end");
  }
  walk.optical.end_program(line);
}

void take_line(Walk& walk, const SourceLine& line) {
  if (line.text.size() > kLongLine && !is_blank(line.text)) {
    walk.reporter.report(Code::LineTooLong,
                         line.number,
                         static_cast<int>(kLongLine) + 1,
                         fmt::format("{} characters", line.text.size()),
                         "at most 64");
  }
  if (is_blank(line.text)) return;
  if (const auto rest = without_slash(line)) {
    if (walk.deletes_blocks) return;
    if (!walk.program.reading.block_delete && !std::exchange(walk.warned_slash, true)) {
      walk.reporter.report(Code::BlockDeleteAssumed,
                           line,
                           "M49,BLKD or M49,NOBLKD, or [program] block_delete in machine.toml");
    }
    if (without_slash(*rest)) {
      return walk.reporter.report(
          Code::BlockSyntax, rest->number, rest->column, quoted(line.text), "one slash");
    }
    return run_line(walk, *rest);
  }
  Block block;
  if (const auto fault = lex(line, block)) {
    return walk.reporter.report_syntax(line.number, *fault);
  }
  run_block(walk, block);
}

void prepare(Walk& walk, const Block& block, const Order& order) {
  if (order.is_tool_up) end_contour(walk, block.line);
  take_tool(walk, block, order);
  if (order.is_scaled) {
    if (walk.is_routing()) {
      walk.reporter.report(Code::ContourUnclosed, block, "a T0 line before it");
      walk.ended = true;
      return;
    }
    switch_scaling(walk, block, *order.is_scaled);
  }
  if (order.incremental) walk.modal.incremental = *order.incremental;
  if (order.feed_m_min) walk.modal.feed = mm_per_s(*order.feed_m_min * 1000 / 60);
  if (order.parameters == ParameterKind::Rout && !order.nibble) {
    if (order.r_mm || order.ij_mm[0] || order.ij_mm[1]) {
      walk.modal.arc_step_mm = order.parameter_step_mm;
    }
    if (order.r_mm) {
      walk.modal.radius_mm = order.r_mm;
      walk.modal.center_offset_mm = {};
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (!order.ij_mm[axis]) continue;
      walk.modal.center_offset_mm[axis] = order.ij_mm[axis];
      walk.modal.radius_mm.reset();
    }
  }
  set_depths(walk, block, order);
  set_peck(walk, block, order);
}

std::string_view reference_text(const Walk& walk) {
  switch (walk.modal.reference) {
    case Reference::Coordinate:
      return "the last coordinate";
    case Reference::Section:
      return "before the offsets of a section";
    case Reference::Begin:
      return "before the section";
    case Reference::Call:
      return "before an M99";
    case Reference::Area:
      return "before an M56, M57 or M58";
  }
  return "";
}

/// In contours "the last valid X-value and/or Y-value applies" (manual, G1 to G3). Behind offsets,
/// calls and areas, and where a section begins, the manual does not say which one is valid, so a
/// line that depends on it is refused, as in Excellon. In M99 itself a coordinate left out is 0.
bool has_axes(Walk& walk, const Block& block, const Order& order) {
  if (!order.has_xy() || order.text == Command::Subprogram || has_reference(walk)) return true;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (order.xy_mm[axis] && !walk.modal.incremental) continue;
    walk.reporter.report(
        Code::AxisAmbiguous,
        block,
        fmt::format(" takes {} from {}", axis == 0 ? 'X' : 'Y', reference_text(walk)),
        "absolute X and Y in this line");
    return false;
  }
  return true;
}

void call_or_write(Walk& walk, const Block& block, const Order& order) {
  if (!holds_only(walk, block, order, kText | kXy)) return;
  if (refuse_in_contour(walk, block) || refuse_open_pattern(walk, block)) return;
  if (order.text == Command::Subprogram) {
    if (walk.modal.incremental && order.has_xy()) {
      // The manual leaves open from where a call's zero counts.
      return walk.reporter.report(Code::ArgumentInvalid, block, "G90 before a call with X and Y");
    }
    return call(walk, block, order);
  }
  if (!move_to(walk, order)) {
    return walk.reporter.report(Code::CoordinateMissing, block, "X#Y# where the text begins");
  }
  drill_text(walk, block, order.text == Command::TextY);
}

void move_or_measure(Walk& walk, const Block& block, const Order& order) {
  if (!has_axes(walk, block, order)) return;
  const bool writes = order.text == Command::TextX || order.text == Command::TextY;
  if (order.text == Command::Subprogram || writes) return call_or_write(walk, block, order);
  if (order.camera) {
    if (holds_only(walk, block, order, kCamera | kXy)) optical_order(walk, block, order);
    return;
  }
  if (order.surface) {
    const std::uint32_t known = kSurface | kXy | kMemory | kToolUp | kDummyTool;
    if (holds_only(walk, block, order, known)) surface_order(walk, block, order);
    return;
  }
  if (order.memory) {
    if (holds_only(walk, block, order, kMemory)) take_surface(walk, block, order);
    return;
  }
  if (order.area) {
    if (holds_only(walk, block, order, kArea | kXy | kRounding)) area(walk, block, order);
    return;
  }
  if (walk.pattern) return end_pattern(walk, block, order);
  if (order.v || order.nibble == Command::NibbleSlot) return begin_pattern(walk, block, order);
  if (order.nibble) {
    if (holds_only(walk, block, order, kNibble | kXy | kParameters))
      nibble_circle(walk, block, order);
    return;
  }
  if (order.is_tool_up) {
    if (holds_only(walk, block, order, kToolUp | kXy | kSide | kParameters | kText)) {
      position(walk, block, order);
    }
    return;
  }
  if (order.motion || walk.modal.motion ||
      (walk.contour != Contour::None && !order.has_xy() && (parts_of(order) & ~kText) != 0)) {
    return rout(walk, block, order);
  }
  if (!holds_only(walk, block, order, kXy | kText)) return;
  if (move_to(walk, order)) drill(walk, block.line, walk.modal.at_mm);
}

/// The order of things in one line: what holds for the coordinate first, then the coordinate, then
/// what comes behind it; texts last.
void run_order(Walk& walk, const Block& block, const Order& order) {
  prepare(walk, block, order);
  const bool drills = !order.motion && !walk.modal.motion && !order.is_tool_up;
  walk.emitter.set_pecking(drills && (walk.peck.is_on || walk.peck.is_pulsing));
  events_before(walk, block, order);
  if (walk.has_ended()) return;
  move_or_measure(walk, block, order);
  if (walk.has_ended()) return;
  events_after(walk, block, order);
}

}  // namespace

Walk::Walk(const Program& walked,
           const WalkOptions& walk_options,
           Survey& survey,
           const WalkEnds& ends)
    : program(walked),
      layout(layout_of(program)),
      options(walk_options),
      trial(ends.trial),
      format(layout.numbers),
      plain(plain_format(format)),
      reporter(ends.reporter(program.source.file)),
      measuring(options, survey, ends.measurements, reporter, ends.log),
      emitter(layout.tools, options, place, measuring.corrections(), reporter, ends.sink),
      optical(measuring, options, reporter),
      settings(options.sieb_meyer),
      surface(settings, survey, ends.probes, reporter, ends.log),
      frame(axis_orientation(program.axis_version()), Eigen::Vector2d::Zero()),
      deletes_blocks(program.deletes_blocks()),
      obeys_areas(options.sieb_meyer.obeys_areas) {
  place.work_zero =
      options.absolute_zero + displacement_mm<frame::Machine>(options.work_zero.in_mm());
  sieb_meyer::place(*this, frame);
  if (ends.measurements != nullptr) emitter.drill_into(ends.measurements->drilled_panel());
}

bool refuse_in_contour(Walk& walk, const Block& block) {
  if (!walk.modal.motion && !walk.is_routing()) return false;
  walk.reporter.report(Code::ContourUnclosed, block, "a T0 line before it");
  return true;
}

bool refuse_open_pattern(Walk& walk, const Block& block) {
  if (!walk.pattern) return false;
  walk.reporter.report(
      Code::CycleUnfinished, block.with(quoted(walk.pattern->text)), "its second point");
  return true;
}

/// Of a pattern that waits for its point where lines end.
void report_open_pattern(Walk& walk, const std::string& where) {
  if (!walk.pattern) return;
  walk.reporter.report(Code::CycleUnfinished,
                       walk.pattern->line,
                       quoted(walk.pattern->text) + " has no second point" + where,
                       "X#Y# in the next line");
}

void run(Walk& walk) {
  const SourceText& source = walk.program.source;
  walk.sections = scan_sections(source.bytes,
                                walk.layout.body,
                                walk.layout.body_end,
                                {.format = walk.format,
                                 .deletes_blocks = walk.deletes_blocks,
                                 .find_layout =
                                     [&walk](std::string_view name, bool deletes_blocks) {
                                       return called_layout(walk, name, deletes_blocks);
                                     }},
                                walk.reporter);
  if (!walk.sections.is_sound) return;
  walk.text = {source.bytes, {}, &walk.sections};
  run_text(walk, walk.text, walk.sections.roots, walk.layout.body, walk.layout.body_end);
  if (walk.has_ended()) return;
  end_program(walk);
}

// --- lines -------------------------------------------------------------------------------------

/// A refused line may have said where the axes are: those behind it are not blamed for what it
/// leaves open.
void run_line(Walk& walk, const SourceLine& line) {
  walk.n_refused = walk.reporter.n_refused();
  take_line(walk, line);
  if (std::exchange(walk.n_refused, walk.reporter.n_refused()) == walk.reporter.n_refused()) return;
  walk.modal.reference = Reference::Coordinate;
}

/// The short way for what nearly every line is: a hole at absolute coordinates. Everything else,
/// and every doubt, goes the long way. No hole changes what decides this; where a hole needs care,
/// they come one by one, since it may be left out.
bool run_plain_lines(Walk& walk, std::size_t end) {
  if (walk.modal.motion || walk.modal.incremental || walk.pattern ||
      walk.contour != Contour::None || !has_reference(walk)) {
    return false;
  }
  const bool refuses_points = walk.format.file == FileFormat::F1000;
  const bool is_simple = walk.tool && !walk.needs_care;
  bool is_full = false;
  const auto take = [&](int line, const PlainCoordinate& block) {
    if ((refuses_points && block.n_points > 0) || is_full) return false;
    const Eigen::Vector2d at_mm = block.from(walk.modal.at_mm);
    walk.modal.at_mm = at_mm;
    ++walk.n_blocks;
    if (is_simple) {
      walk.emitter.drill(line, at_mm);
    } else {
      drill(walk, line, at_mm);
    }
    is_full = !is_simple || walk.emitter.is_over_limit();
    return true;
  };
  const auto skip = [&](std::int64_t n) {
    const std::int64_t n_unseen = walk.emitter.count_unseen(n);
    walk.n_blocks += n_unseen;
    return n_unseen;
  };
  const bool only_counts = is_simple && !walk.emitter.needs_places();
  const bool has_any = only_counts ? walk.plain.read_lines(walk.cursor, end, take, skip)
                                   : walk.plain.read_lines(walk.cursor, end, take);
  if (has_any) {
    walk.modal.at_step_mm = walk.format.step_mm();
    walk.has_coordinate = true;
  }
  return has_any;
}

void run_block(Walk& walk, const Block& block) {
  const OrderContext context{.format = walk.format,
                             .is_routing = walk.modal.motion || walk.is_routing(),
                             .expects_count = walk.pattern.has_value(),
                             .is_pecking = walk.peck.is_on,
                             .is_pulsing = walk.peck.is_pulsing};
  ++walk.n_blocks;
  auto order = read_order(block, context, walk.reporter);
  if (!order) return;
  // In format 1000 functions hold for the line they stand in.
  const bool holds_once = walk.format.file == FileFormat::F1000;
  const bool was_incremental = walk.modal.incremental;
  if (holds_once && walk.modal.motion && order->has_xy() && !order->motion && !order->is_tool_up) {
    return walk.reporter.report(Code::CommandMisplaced,
                                block,
                                " routs without G1, G2 or G3",
                                "G1, G2 or G3 in every line of format 1000");
  }
  walk.skips_surface = order->skips_surface;
  run_order(walk, block, *order);
  if (std::exchange(walk.skips_surface, false)) update_cut(walk);
  if (holds_once && order->incremental) walk.modal.incremental = was_incremental;
  update_care(walk);
  walk.emitter.stop_after(walk.trial);
}

/// What a hole in a line of its own may depend on besides its place.
void update_care(Walk& walk) {
  walk.needs_care = walk.scaling.is_set() || !walk.areas.empty() || walk.surface.has_grid() ||
                    walk.surface.is_on() || walk.doubts_control || walk.optical.is_assumed_on();
}

/// "The first coordinate of a relative coordinate definition relates to the last used absolute
/// coordinate. At the beginning of the program the last used absolute coordinate will be set to
/// X0Y0"; the reference is set anew "at the end of a Step-and-Repeat pattern" (manual, G91).
bool has_reference(const Walk& walk) {
  const bool is_of_section =
      walk.modal.reference == Reference::Section || walk.modal.reference == Reference::Begin;
  return walk.modal.reference == Reference::Coordinate || (is_of_section && walk.modal.incremental);
}

/// Absolute: an axis left out stays. Incremental: it adds nothing.
bool move_to(Walk& walk, const Order& order) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    double& at_mm = walk.modal.at_mm[static_cast<Eigen::Index>(axis)];
    if (walk.modal.incremental) {
      at_mm += order.xy_mm[axis].value_or(0);
    } else if (order.xy_mm[axis]) {
      at_mm = *order.xy_mm[axis];
    }
  }
  if (order.has_xy()) {
    walk.modal.at_step_mm = order.xy_step_mm;
    walk.modal.reference = Reference::Coordinate;
    walk.has_coordinate = true;
  }
  return order.has_xy();
}

/// A word that the line's task has no use for would otherwise vanish.
bool holds_only(Walk& walk, const Block& block, const Order& order, std::uint32_t known) {
  // G40 with nothing to turn off does nothing; many programs begin with it.
  if (order.side == CompensationSide::Off && walk.modal.side == CompensationSide::Off)
    known |= kSide;
  const std::uint32_t rest = parts_of(order) & ~known;
  if (rest == 0) return true;
  const std::uint32_t first = rest & (~rest + 1);
  walk.reporter.report(
      Code::CommandMisplaced,
      block.with(fmt::format("{} has no meaning in {}", form_of(first), quoted(block.text))),
      "it in a line that can use it");
  return false;
}

}  // namespace panelcal::sieb_meyer
