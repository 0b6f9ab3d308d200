// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/interpreter/interpreter.h"

#include <utility>

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

Placement sieb_meyer_placement(int version) {
  return {axis_orientation(version), Eigen::Vector2d::Zero()};
}

}  // namespace

Interpreter::Interpreter(const Program& program,
                         const WalkOptions& options,
                         Survey& survey,
                         const WalkEnds& ends)
    : program_(program),
      layout_(layout_of(program)),
      options_(options),
      trial_(ends.trial),
      format_(layout_.numbers),
      plain_(plain_format(format_)),
      reporter_(program.source.file,
                ends.log,
                ends.sink == nullptr || ends.trial != nullptr ? Reporter::Level::All
                                                              : Reporter::Level::ErrorsOnly,
                ends.trial == nullptr ? nullptr : &ends.trial->working_log),
      measuring_(options, survey, ends.measurements, reporter_, ends.log),
      emitter_(layout_.tools, options, place_, measuring_.corrections(), reporter_, ends.sink),
      optical_(measuring_, options, reporter_),
      settings_(options.sieb_meyer),
      surface_(settings_, survey, ends.probes, reporter_, ends.log),
      frame_(sieb_meyer_placement(program.axis_version())),
      deletes_blocks_(program.deletes_blocks()),
      obeys_areas_(options.sieb_meyer.obeys_areas) {
  place_.work_zero =
      options.absolute_zero + displacement_mm<frame::Machine>(options.work_zero.in_mm());
  place(frame_);
  if (ends.measurements != nullptr) emitter_.drill_into(ends.measurements->drilled_panel());
}

void Interpreter::run() {
  const SourceText& source = program_.source;
  sections_ = scan_sections(
      source.bytes,
      layout_.body,
      layout_.body_end,
      {.format = format_,
       .deletes_blocks = deletes_blocks_,
       .find_layout = [this](std::string_view name,
                             bool deletes_blocks) { return called_layout(name, deletes_blocks); }},
      reporter_);
  if (!sections_.is_sound) return;
  text_ = {source.bytes, {}, &sections_};
  run_text(text_, sections_.roots, layout_.body, layout_.body_end);
  if (has_ended()) return;
  end_program();
}

void Interpreter::end_program() {
  const int line = cursor_.line_number();
  if (is_routing()) {
    reporter_.report(Code::ContourUnclosed,
                     line,
                     1,
                     "the program ends while a contour is being routed",
                     "a T0 line at its end");
  }
  end_contour(line);
  if (pattern_) {
    reporter_.report(Code::CycleUnfinished,
                     pattern_->line,
                     1,
                     panelcal::quoted(pattern_->text) + " has no second point",
                     "X#Y# in the next line");
  }
  if (surface_.is_on() && leaves_surface_on_) {
    reporter_.report(Code::SurfaceUnbracketed,
                     line,
                     1,
                     "the program ends with surface detection on (G71)",
                     "G70 before its end");
  }
  optical_.end_program(line);
}

// --- lines -------------------------------------------------------------------------------------

/// A refused line may have said where the axes are: those behind it are not blamed for what it
/// leaves open.
void Interpreter::run_line(const SourceLine& line) {
  n_refused_ = reporter_.n_refused();
  read_line(line);
  if (std::exchange(n_refused_, reporter_.n_refused()) == reporter_.n_refused()) return;
  modal_.reference = Reference::Coordinate;
}

void Interpreter::read_line(const SourceLine& line) {
  if (line.text.size() > kLongLine && !is_blank(line.text)) {
    reporter_.report(Code::LineTooLong,
                     line.number,
                     static_cast<int>(kLongLine) + 1,
                     fmt::format("{} characters", line.text.size()),
                     "at most 64");
  }
  if (is_blank(line.text)) return;
  if (const auto rest = without_slash(line)) {
    if (deletes_blocks_) return;
    if (!program_.reading.block_delete && !std::exchange(warned_slash_, true)) {
      reporter_.report(Code::BlockDeleteAssumed,
                       line.number,
                       line.column,
                       quoted(line.text),
                       "M49,BLKD or M49,NOBLKD, or [program] block_delete in machine.toml");
    }
    if (without_slash(*rest)) {
      return reporter_.report(
          Code::BlockSyntax, rest->number, rest->column, quoted(line.text), "one slash");
    }
    return run_line(*rest);
  }
  Block block;
  if (const auto fault = lex(line, block)) {
    return reporter_.report(Code::BlockSyntax,
                            line.number,
                            fault->column,
                            quoted(fault->text),
                            std::string(fault->expected));
  }
  run_block(block);
}

/// The short way for what nearly every line is: a hole at absolute coordinates. Everything else,
/// and every doubt, goes the long way. No hole changes what decides this; where a hole needs care,
/// they come one by one, since it may be left out.
bool Interpreter::run_plain_lines(std::size_t end) {
  if (modal_.motion || modal_.incremental || pattern_ || contour_ != Contour::None ||
      !has_reference()) {
    return false;
  }
  const bool refuses_points = format_.file == FileFormat::F1000;
  const bool is_simple = tool_ && !needs_care_;
  bool is_full = false;
  const auto take = [&](int line, const PlainCoordinate& block) {
    if ((refuses_points && block.n_points > 0) || is_full) return false;
    const Eigen::Vector2d at_mm = block.from(modal_.at_mm);
    modal_.at_mm = at_mm;
    ++n_blocks_;
    if (is_simple) {
      emitter_.drill(line, at_mm);
    } else {
      drill(line, at_mm);
    }
    is_full = !is_simple || emitter_.is_over_limit();
    return true;
  };
  const auto skip = [&](std::int64_t n) {
    const std::int64_t n_unseen = emitter_.count_unseen(n);
    n_blocks_ += n_unseen;
    return n_unseen;
  };
  const bool only_counts = is_simple && !emitter_.needs_places();
  const bool has_any = only_counts ? plain_.read_lines(cursor_, end, take, skip)
                                   : plain_.read_lines(cursor_, end, take);
  if (has_any) {
    modal_.at_step_mm = format_.step_mm();
    has_coordinate_ = true;
  }
  return has_any;
}

void Interpreter::run_block(const Block& block) {
  const OrderContext context{.format = format_,
                             .is_routing = modal_.motion || is_routing(),
                             .expects_count = pattern_.has_value(),
                             .is_pecking = peck_.is_on,
                             .is_pulsing = peck_.is_pulsing};
  ++n_blocks_;
  auto order = read_order(block, context, reporter_);
  if (!order) return;
  // In format 1000 functions hold for the line they stand in.
  const bool holds_once = format_.file == FileFormat::F1000;
  const bool was_incremental = modal_.incremental;
  if (holds_once && modal_.motion && order->has_xy() && !order->motion && !order->is_tool_up) {
    return report(Code::CommandMisplaced,
                  block,
                  quoted(block.text) + " routs without G1, G2 or G3",
                  "G1, G2 or G3 in every line of format 1000");
  }
  skips_surface_ = order->skips_surface;
  run_order(block, *order);
  if (std::exchange(skips_surface_, false)) update_cut();
  if (holds_once && order->incremental) modal_.incremental = was_incremental;
  update_care();
  emitter_.stop_after(trial_);
}

/// What a hole in a line of its own may depend on besides its place.
void Interpreter::update_care() {
  needs_care_ = scaling_.is_set() || !areas_.empty() || surface_.has_grid() || surface_.is_on() ||
                doubts_control_ || optical_.is_assumed_on();
}

/// The order of things in one line: what holds for the coordinate first, then the coordinate, then
/// what comes behind it; texts last.
void Interpreter::run_order(const Block& block, const Order& order) {
  prepare(block, order);
  const bool drills = !order.motion && !modal_.motion && !order.is_tool_up;
  emitter_.set_pecking(drills && (peck_.is_on || peck_.is_pulsing));
  events_before(block, order);
  if (has_ended()) return;
  move_or_measure(block, order);
  if (has_ended()) return;
  events_after(block, order);
}

void Interpreter::prepare(const Block& block, const Order& order) {
  if (order.is_tool_up) end_contour(block.line);
  take_tool(block, order);
  if (order.is_scaled) {
    if (is_routing()) {
      report(Code::ContourUnclosed, block, quoted(block.text), "a T0 line before it");
      ended_ = true;
      return;
    }
    switch_scaling(block, *order.is_scaled);
  }
  if (order.incremental) modal_.incremental = *order.incremental;
  if (order.feed_m_min) modal_.feed = mm_per_s(*order.feed_m_min * 1000 / 60);
  if (order.parameters == ParameterKind::Rout && !order.nibble) {
    if (order.r_mm || order.ij_mm[0] || order.ij_mm[1]) {
      modal_.arc_step_mm = order.parameter_step_mm;
    }
    if (order.r_mm) {
      modal_.radius_mm = order.r_mm;
      modal_.center_offset_mm = {};
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (!order.ij_mm[axis]) continue;
      modal_.center_offset_mm[axis] = order.ij_mm[axis];
      modal_.radius_mm.reset();
    }
  }
  set_depths(block, order);
  set_peck(block, order);
}

/// "The first coordinate of a relative coordinate definition relates to the last used absolute
/// coordinate. At the beginning of the program the last used absolute coordinate will be set to
/// X0Y0"; the reference is set anew "at the end of a Step-and-Repeat pattern" (manual, G91).
bool Interpreter::has_reference() const {
  const bool is_of_section =
      modal_.reference == Reference::Section || modal_.reference == Reference::Begin;
  return modal_.reference == Reference::Coordinate || (is_of_section && modal_.incremental);
}

std::string_view Interpreter::reference_text() const {
  switch (modal_.reference) {
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
bool Interpreter::has_axes(const Block& block, const Order& order) {
  if (!order.has_xy() || order.text == Command::Subprogram || has_reference()) return true;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (order.xy_mm[axis] && !modal_.incremental) continue;
    report(Code::AxisAmbiguous,
           block,
           fmt::format(
               "{} takes {} from {}", quoted(block.text), axis == 0 ? 'X' : 'Y', reference_text()),
           "absolute X and Y in this line");
    return false;
  }
  return true;
}

/// Absolute: an axis left out stays. Incremental: it adds nothing.
bool Interpreter::move_to(const Order& order) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    double& at_mm = modal_.at_mm[static_cast<Eigen::Index>(axis)];
    if (modal_.incremental) {
      at_mm += order.xy_mm[axis].value_or(0);
    } else if (order.xy_mm[axis]) {
      at_mm = *order.xy_mm[axis];
    }
  }
  if (order.has_xy()) {
    modal_.at_step_mm = order.xy_step_mm;
    modal_.reference = Reference::Coordinate;
    has_coordinate_ = true;
  }
  return order.has_xy();
}

/// A word that the line's task has no use for would otherwise vanish.
bool Interpreter::holds_only(const Block& block, const Order& order, std::uint32_t known) {
  // G40 with nothing to turn off does nothing; many programs begin with it.
  if (order.side == CompensationSide::Off && modal_.side == CompensationSide::Off) known |= kSide;
  const std::uint32_t rest = parts_of(order) & ~known;
  if (rest == 0) return true;
  const std::uint32_t first = rest & (~rest + 1);
  report(Code::CommandMisplaced,
         block,
         fmt::format("{} has no meaning in {}", form_of(first), quoted(block.text)),
         "it in a line that can use it");
  return false;
}

void Interpreter::move_or_measure(const Block& block, const Order& order) {
  if (!has_axes(block, order)) return;
  const bool writes = order.text == Command::TextX || order.text == Command::TextY;
  if (order.text == Command::Subprogram || writes) return call_or_write(block, order);
  if (order.camera) {
    if (holds_only(block, order, kCamera | kXy)) optical_order(block, order);
    return;
  }
  if (order.surface) {
    const std::uint32_t known = kSurface | kXy | kMemory | kToolUp | kDummyTool;
    if (holds_only(block, order, known)) surface_order(block, order);
    return;
  }
  if (order.memory) {
    if (holds_only(block, order, kMemory)) take_surface(block, order);
    return;
  }
  if (order.area) {
    if (holds_only(block, order, kArea | kXy | kRounding)) area(block, order);
    return;
  }
  if (pattern_) return end_pattern(block, order);
  if (order.v || order.nibble == Command::NibbleSlot) return begin_pattern(block, order);
  if (order.nibble) {
    if (holds_only(block, order, kNibble | kXy | kParameters)) nibble_circle(block, order);
    return;
  }
  if (order.is_tool_up) {
    if (holds_only(block, order, kToolUp | kXy | kSide | kParameters | kText)) {
      position(block, order);
    }
    return;
  }
  if (order.motion || modal_.motion ||
      (contour_ != Contour::None && !order.has_xy() && (parts_of(order) & ~kText) != 0)) {
    return rout(block, order);
  }
  if (!holds_only(block, order, kXy | kText)) return;
  if (move_to(order)) drill(block.line, modal_.at_mm);
}

void Interpreter::call_or_write(const Block& block, const Order& order) {
  if (!holds_only(block, order, kText | kXy)) return;
  if (modal_.motion || is_routing()) {
    return report(Code::ContourUnclosed, block, quoted(block.text), "a T0 line before it");
  }
  if (pattern_) {
    return report(
        Code::CycleUnfinished, block, panelcal::quoted(pattern_->text), "its second point");
  }
  if (order.text == Command::Subprogram) {
    if (modal_.incremental && order.has_xy()) {
      // The manual leaves open from where a call's zero counts.
      return report(
          Code::ArgumentInvalid, block, quoted(block.text), "G90 before a call with X and Y");
    }
    return call(block, order);
  }
  if (!move_to(order)) {
    return report(Code::CoordinateMissing, block, quoted(block.text), "X#Y# where the text begins");
  }
  drill_text(block, order.text == Command::TextY);
}

void Interpreter::report(Code code, const Block& block, std::string what, std::string expected) {
  reporter_.report(code, block.line, block.column, std::move(what), std::move(expected));
}

}  // namespace panelcal::sieb_meyer
