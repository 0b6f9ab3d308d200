// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/sieb_meyer/interpreter/walk.h"

namespace panelcal::sieb_meyer {

// What the parts of the interpreter ask of each other.

// interpreter.cc: Lines, and the order of what one asks for.
bool refuse_in_contour(Walk& walk, const Block& block);
bool refuse_open_pattern(Walk& walk, const Block& block);
void report_open_pattern(Walk& walk, const std::string& where);
void run(Walk& walk);
void run_line(Walk& walk, const SourceLine& line);
bool run_plain_lines(Walk& walk, std::size_t end);
void run_block(Walk& walk, const Block& block);
void update_care(Walk& walk);
bool has_reference(const Walk& walk);
bool move_to(Walk& walk, const Order& order);
bool holds_only(Walk& walk, const Block& block, const Order& order, std::uint32_t known);

// sections.cc: Sections and subprograms: which copy runs when.
void run_text(Walk& walk,
              const RunText& text,
              const std::vector<int>& sections,
              LinePlace begin,
              std::size_t end);
void run_copy(Walk& walk, int i_section, const Modal& start);
void place(Walk& walk, const Placement& placement);
int step_number(const Walk& walk);
const Layout* called_layout(Walk& walk, std::string_view name, bool deletes_blocks);
void call(Walk& walk, const Block& block, const Order& order);

// drill.cc: Holes, patterns and texts.
bool has_tool(Walk& walk, int line);
bool may_work(Walk& walk, int line);
void drill(Walk& walk, int line, const Eigen::Vector2d& at_mm);
bool is_forbidden(Walk& walk, int line, const Eigen::Vector2d& at_mm);
void begin_pattern(Walk& walk, const Block& block, const Order& order);
void end_pattern(Walk& walk, const Block& block, const Order& order);
void nibble_circle(Walk& walk, const Block& block, const Order& order);
std::optional<double> tool_diameter_mm(Walk& walk, const Block& block);
void drill_text(Walk& walk, const Block& block, bool upwards);

// rout.cc: Contours and figures.
void position(Walk& walk, const Block& block, const Order& order);
void end_contour(Walk& walk, int line);
void rout(Walk& walk, const Block& block, const Order& order);

// depth.cc: Planes, peck drilling and surfaces.
void set_depths(Walk& walk, const Block& block, const Order& order);
void judge_control(Walk& walk, int line);
bool uses_surface(const Walk& walk);
void update_cut(Walk& walk);
bool is_below_limit(const Walk& walk);
bool uses_grid(const Walk& walk);
DepthOfCut grid_cut(Walk& walk, int line, const Eigen::Vector2d& at_mm, const DepthOfCut& cut);
DepthOfCut cut_at(Walk& walk, int line, const Eigen::Vector2d& at_mm);
void set_peck(Walk& walk, const Block& block, const Order& order);
void take_surface(Walk& walk, const Block& block, const Order& order);
void pass_average(Walk& walk, const Block& block, const Order& order);
void surface_order(Walk& walk, const Block& block, const Order& order);

// events.cc: Tools, and what the machine does by itself.
void take_tool(Walk& walk, const Block& block, const Order& order);
void function(
    Walk& walk, int line, FunctionKind kind, std::string_view text, bool is_at_place = false);
void stop_at_place(Walk& walk, int line);
void events_before(Walk& walk, const Block& block, const Order& order);
void events_after(Walk& walk, const Block& block, const Order& order);
void area(Walk& walk, const Block& block, const Order& order);

// cnc.cc: The CNC commands of M49.
void cnc_command(Walk& walk, const Block& block);
void refresh_placement(Walk& walk);
void switch_scaling(Walk& walk, const Block& block, bool is_on);
void end_scaled_copy(Walk& walk, int line, const Scaling& before);
void note_scaling(Walk& walk, int line);
bool is_decided(Walk& walk, int line);

// optical.cc: Optical orders.
TargetPlace target_place(Walk& walk, const Block& block, Command command);
bool may_drill_target(Walk& walk, int line);
void optical_order(Walk& walk, const Block& block, const Order& order);
void camera_text(Walk& walk, const Block& block, Command command);

// kept.cc: For translation: sections and optical orders that are passed on as such.
bool is_kept(const Walk& walk, const Section& section);
void run_kept(Walk& walk, int i_section);
KeptOffsets begin_kept_copy(Walk& walk);
void end_kept_copy(Walk& walk, int line, const KeptOffsets& outer);
void keep_optical_order(Walk& walk, const Block& block, Command command);
void keep_set(Walk& walk, const Block& block);
void keep_surface_order(Walk& walk, const Block& block, const Order& order, bool has_place);
void skip_kept_grid(Walk& walk, const Block& block, const Order& order);

}  // namespace panelcal::sieb_meyer
