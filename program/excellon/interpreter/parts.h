// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "program/excellon/interpreter/walk.h"

namespace panelcal::excellon {

// What the parts of the interpreter ask of each other. commands.def names the one that executes
// each command.

// interpreter.cc: Lines and blocks.
void run(Walk& walk);
void run_line(Walk& walk, const SourceLine& line);
bool run_plain_lines(Walk& walk, std::size_t end);

// sections.cc: Step and repeat: which copy runs when.
void run_section(Walk& walk, int line);

// blocks.cc: Numbers, holes and targets.
bool is_alone(Walk& walk, const Block& block, std::size_t n_words = 1);
double rounding_mm(const Walk& walk);
void warn_padded(Walk& walk, const Block& block, const Word& word);
bool read_words(Walk& walk,
                const Block& block,
                std::span<const Word> words,
                std::string_view letters,
                MotionWords& out);
bool move_to(Walk& walk,
             const Block& block,
             const std::array<std::optional<double>, 2>& xy_mm,
             AxisUser user);
void coordinate(Walk& walk, const Block& block);
void repeat_hole(Walk& walk, const Block& block);
bool has_tool(Walk& walk, int line);
void measure(Walk& walk, const Block& block, Command command);
void select_vision_tool(Walk& walk, const Block& block);
void cancel_correction(Walk& walk, const Block& block, Command command);
void stored_label(Walk& walk, const Block& block, Command command);
void autocalibration(Walk& walk, const Block& block);

// settings.cc: Tools, zeros and units.
void select_tool(Walk& walk, const Block& block);
void rate(Walk& walk, const Block& block);
void set_zero(Walk& walk, const Block& block);
void set_unit(Walk& walk, const Block& block, LengthUnit unit);
void check_comment(Walk& walk, const SourceLine& line);
bool agrees_with_comment(Walk& walk, const Block& block);
void header_word(Walk& walk, const SourceLine& line);

// events.cc: Stops, messages, and what the machine does by itself.
void stop(Walk& walk, const Block& block, std::span<const Word> words, StopKind kind);
void end_program(Walk& walk, const Block& block, std::span<const Word> words, StopKind kind);
void end_without_mark(Walk& walk);
void dwell(Walk& walk, const Block& block);
void message(Walk& walk, const Block& block);
void long_message(Walk& walk, const SourceLine& line);
void text_offset(Walk& walk, const SourceLine& line);
void function(Walk& walk, const Block& block, FunctionKind kind);
void switch_scaling(Walk& walk, const Block& block, bool is_on);

// rout.cc: Routing.
bool refuse_while_plunged(Walk& walk, const Block& block);
std::optional<Length> tool_diameter(const Walk& walk);
void drill_mode(Walk& walk, const Block& block);
void set_table_feed(Walk& walk, const Block& block, std::optional<Feed> feed);
void start_motion(Walk& walk, const Block& block, Motion motion);
void move_or_rout(Walk& walk, const Block& block, std::span<const Word> words);
void plunge(Walk& walk, const Block& block, PlungeKind kind);
void retract(Walk& walk, const Block& block, bool with_clamping);
void switch_compensation(Walk& walk, const Block& block, CompensationSide side);
void routed_circle(Walk& walk, const Block& block, Command command);
void step_slot(Walk& walk,
               const Block& block,
               const Eigen::Vector2d& start_mm,
               const Eigen::Vector2d& end_mm,
               const MotionWords& words);

// cycles.cc: Canned cycles, engraved text, stored patterns.
bool refuse_pending(Walk& walk, int line, std::string_view what);
void refuse_cycle(Walk& walk, const Block& block, const Word& word, const std::string& why);
void begin_cycle(Walk& walk, const Block& block, Command command);
void take_corner(Walk& walk, const Block& block);
void inline_cycle(Walk& walk, const Block& block, std::size_t i_code, Command command);
void repeat_pattern(Walk& walk, const Block& block);

}  // namespace panelcal::excellon
