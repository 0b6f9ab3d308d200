// SPDX-License-Identifier: Apache-2.0
// Step and repeat sections: which instance runs when, and with what state it begins.
#include <algorithm>
#include <initializer_list>
#include <utility>
#include <vector>

#include "program/excellon/interpreter/parts.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

/// More copies than this are written one by one.
constexpr std::int64_t kMostKeptCopies = 10'000;

using Copy = Transform<frame::Programmed, frame::Programmed>;

/// Every copy of levels[0, level) in the order of execution; the first is the pattern itself.
void append_copies(const RepeatSection& section,
                   std::size_t level,
                   const Copy& outer,
                   std::vector<Copy>& out) {
  if (level == 0) {
    out.push_back(outer);
    return;
  }
  append_copies(section, level - 1, outer, out);
  Eigen::Vector2d offset_mm = Eigen::Vector2d::Zero();
  for (const Copies& copies : section.levels[level - 1]) {
    if (copies.run.restarts) offset_mm.setZero();
    for (int i = 0; i < copies.run.count; ++i) {
      offset_mm += copies.run.step.in_mm();
      append_copies(section, level - 1, outer * Copy(copy_orientation(copies.run), offset_mm), out);
    }
  }
}

/// A copy of a pattern that changes tools before it takes one begins with another tool than the
/// pattern itself did, and what cycles drill depends on the tool.
bool begins_with_tool(const RepeatSection& section) {
  LineCursor cursor = section.pattern;
  while (cursor.offset() < section.pattern_end) {
    const SourceLine line = cursor.next();
    if (kind_of(line.text) == LineKind::Empty) continue;
    return line.text.substr(line.text.find_first_not_of(" \t")).starts_with('T');
  }
  return false;
}

/// The line has one of these codes, or says so in a comment.
bool has_any(std::string_view line, std::initializer_list<std::string_view> codes) {
  return std::ranges::any_of(
      codes, [line](std::string_view code) { return line.find(code) != std::string_view::npos; });
}

/// A line of the pattern measures a nested series (G46).
bool may_nest(const RepeatSection& section) {
  LineCursor cursor = section.pattern;
  while (cursor.offset() < section.pattern_end) {
    if (has_any(cursor.next().text, {"G46", "g46"})) return true;
  }
  return false;
}

/// A series ahead of a `$uvis,alg` of another number of targets has that number in the next copy.
bool measures_alike(const RepeatSection& section, int series_size) {
  constexpr std::string_view kSize = "$uvis,alg,";
  bool has_measured = false;
  LineCursor cursor = section.pattern;
  while (cursor.offset() < section.pattern_end) {
    const std::string_view text = cursor.next().text;
    has_measured |= has_any(text, {"G36", "g36", "G46", "g46"});
    const auto at = text.find(kSize);
    if (at == std::string_view::npos) continue;
    if (!has_measured && !text.starts_with('/')) return true;  // each copy states it
    const std::string_view rest = text.substr(at + kSize.size());
    const auto comma = rest.find(',');
    const bool is_same =
        comma != std::string_view::npos && parse_count(rest.substr(comma + 1)) == series_size;
    if (!is_same) return false;
  }
  return true;
}

bool can_keep(const RepeatSection& section) {
  if (section.changes_tools && !begins_with_tool(section)) return false;
  std::int64_t n_copies = 1;
  for (const std::vector<Copies>& level : section.levels) {
    std::int64_t n_level = 1;
    for (const Copies& copies : level) {
      if (copies.tool) return false;
      n_level += copies.run.count;
    }
    if (n_level > kMostKeptCopies / n_copies) return false;
    n_copies *= n_level;
  }
  return true;
}

/// "After the last M02 repeat command, an extra M02 command which requires no coordinates, must be
/// added in a block by itself. This will clear a counter." Offsets count anew at each M01 all the
/// same, as those of R#M02 do in the manual's sample program.
void warn_of_open_count(Walk& walk, const RepeatSection& section) {
  walk.line_of_open_count = section.line_of_open_count;
  if (!section.count_behind_open_one || std::exchange(walk.warned_count, true)) return;
  const auto& [block, line] = *section.count_behind_open_one;
  walk.reporter.report(Code::NotationAccepted,
                       block,
                       fmt::format(" counts from its pattern, not on from line {}", line),
                       fmt::format("M02 in a block by itself behind line {}", line));
}

/// All of the manual's examples have the mirrors first; what it says of each command leaves open
/// whether one that comes behind M70 would mirror the other axis.
void warn_of_swap(Walk& walk, const RepeatSection& section) {
  if (!section.swap_before_mirror || std::exchange(walk.warned_swap, true)) return;
  const Block& block = *section.swap_before_mirror;
  walk.reporter.report(Code::NotationAccepted,
                       block,
                       " is mirrored first, then its axes are exchanged",
                       "M70 behind M80 and M90");
}

/// "A repeat of all the commands" would begin a copy with the feed that the one before has ended
/// with, "identical patterns" with that of the pattern itself, which it has here.
void warn_of_feed(Walk& walk, const RepeatSection& section) {
  const auto late = std::exchange(walk.late_feed, std::nullopt);
  const bool has_copies = std::ranges::any_of(
      section.levels, [](const std::vector<Copies>& level) { return !level.empty(); });
  if (!late || !has_copies || std::exchange(walk.warned_feed, true)) return;
  walk.reporter.report(Code::FeedAssumed,
                       late->first.line,
                       late->first.column,
                       quoted(late->second) + " behind a rout at the feed from before the pattern",
                       "F# before the pattern's first rout move");
}

/// The manual clears the incremental accumulators at M08, back to work zero. It does not say what
/// an omitted axis means then in absolute mode, so that is refused (AxisUser::Cleared).
void end_section(Walk& walk, const RepeatSection& section) {
  if (!walk.is_inner_section()) walk.vision.end_section(section.closing.line);
  walk.modal.at_mm.setZero();
  walk.modal.user = {AxisUser::Cleared, AxisUser::Cleared};
  walk.modal.begins_pattern = false;
  walk.modal.has_hole = false;
  walk.modal.has_start = false;
  walk.last_cycle.reset();
  walk.cursor = section.after;

  if (section.closing.n_words == 1) return;
  const Word& second = section.closing.words[1];
  const auto code = walk.command(second);
  if (code != Command::EndRewind && code != Command::EndNoRewind) {
    return walk.reporter.report(
        Code::BlockNotAlone, section.closing.in(second), "M08 alone or with M30");
  }
  end_program(walk,
              section.closing,
              section.closing.all().subspan(2),
              code == Command::EndRewind ? StopKind::EndRewind : StopKind::EndNoRewind);
}

void take_tool_of(Walk& walk, const Copies& copies) {
  Block block;
  block.line = copies.line;
  block.words[0] = *copies.tool;
  block.n_words = 1;
  select_tool(walk, block);
}

void run_instance(Walk& walk,
                  const RepeatSection& section,
                  const Modal& start,
                  const Placement& placement) {
  if (walk.has_ended()) return;
  walk.place.placement = placement;
  walk.modal = start;
  const auto feed_outside = std::exchange(walk.feed_in_pattern, std::nullopt);
  const bool took_feed_outside = std::exchange(walk.takes_feed_from_before, false);
  walk.last_cycle.reset();
  if (!walk.is_inner_section()) {
    walk.vision.begin_instance(placement);
    walk.n_worked_before = walk.emitter.n_worked();
  }
  walk.cursor = section.pattern;
  if (walk.cursor.offset() == section.pattern_end) walk.emitter.count_idle_line(section.line);
  while (walk.cursor.offset() < section.pattern_end && !walk.has_ended()) {
    const int number = walk.cursor.line_number();
    const std::int64_t n_before = walk.emitter.n_operations();
    if (!run_plain_lines(walk, section.pattern_end)) run_line(walk, walk.cursor.next());
    if (walk.emitter.n_operations() == n_before) walk.emitter.count_idle_line(number);
  }
  if (walk.has_ended()) return;
  const bool is_late = walk.takes_feed_from_before && walk.modal.feed != start.feed;
  if (is_late && !walk.late_feed) walk.late_feed = walk.feed_in_pattern;
  walk.takes_feed_from_before = took_feed_outside || (walk.takes_feed_from_before && !feed_outside);
  if (!walk.feed_in_pattern) walk.feed_in_pattern = feed_outside;
  const int end_line = walk.cursor.line_number();
  refuse_pending(walk, end_line, "the end of the pattern");
  if (std::exchange(walk.is_plunged, false)) {
    walk.reporter.report(Code::ToolPlunged,
                         end_line,
                         "the pattern ends while the router is down",
                         "M16 or M17 at its end");
  }
  if (!walk.is_inner_section()) walk.vision.end_instance(end_line);
}

/// Runs everything below `level` once in place and once for every copy that the level asks for.
void run_level(Walk& walk,
               const RepeatSection& section,
               const Modal& start,
               std::size_t level,
               const Placement& outer) {
  if (level == 0) return run_instance(walk, section, start, outer);
  // levels[] is innermost first, the path outermost first.
  const std::size_t depth = walk.place.path.size() - level;
  walk.place.path[depth] = 0;
  const std::int64_t n_before = walk.emitter.n_operations();
  const std::int64_t n_idle_before = walk.emitter.n_idle_lines();
  run_level(walk, section, start, level - 1, outer);
  if (walk.is_first_walk() && !section.has_vision) {
    // Checking needs the copies only where they measure; else they are counted.
    std::int64_t n_copies = 0;
    for (const Copies& copies : section.levels[level - 1]) n_copies += copies.run.count;
    walk.emitter.count_copies(n_copies,
                              walk.emitter.n_operations() - n_before,
                              walk.emitter.n_idle_lines() - n_idle_before,
                              section.line);
    return;
  }

  Eigen::Vector2d offset_mm = Eigen::Vector2d::Zero();
  for (const Copies& copies : section.levels[level - 1]) {
    const CopyRun& run = copies.run;
    if (run.restarts) offset_mm.setZero();
    const Eigen::Matrix2d orientation = copy_orientation(run);
    for (int i = 0; i < run.count && !walk.has_ended(); ++i) {
      offset_mm += run.step.in_mm();
      ++walk.place.path[depth];
      if (copies.tool) take_tool_of(walk, copies);
      run_level(walk,
                section,
                start,
                level - 1,
                outer * Transform<frame::Programmed, frame::Programmed>(orientation, offset_mm));
    }
  }
}

/// Passes the pattern on once, where it stands, with all its copies. False if structure is not kept
/// here: the copies are to be run.
bool run_kept(Walk& walk, const RepeatSection& section, const Modal& start) {
  if (!walk.keeps_structure() || walk.is_inner_section() || !can_keep(section) ||
      !measures_alike(section, walk.vision.series_size())) {
    return false;
  }
  if (walk.vision.has_open_series()) {
    walk.reporter.report(Code::NotSupported,
                         section.line,
                         "a pattern begins inside a series of targets, which has no form in a "
                         "translation",
                         "the whole series before M25, or behind it");
    walk.ended = true;
    return true;
  }
  std::vector<Copy> copies;
  append_copies(section, section.levels.size(), Copy(), copies);
  // Programmed places become those in work coordinates, and copies as well.
  const Transform<frame::Programmed, frame::Nominal> inverse = walk.frame.inverse();
  const Copy back(inverse.linear(), inverse.translation());
  std::vector<Placement> placements;
  for (const Copy& copy : copies) {
    placements.push_back(walk.frame * copy * back);
  }
  const std::vector<int> path = std::exchange(walk.place.path, {});
  if (may_nest(section)) {
    walk.emitter.put(section.line, StoredCorrection{StoredCorrectionKind::NestNext, 0, {}, 0});
  }
  walk.emitter.put(section.line, PatternBegin{});
  walk.vision.begin_kept_pattern();
  run_instance(walk, section, start, walk.frame);
  walk.vision.end_kept_pattern(placements.size());
  if (!walk.has_ended()) walk.emitter.put(section.closing.line, PatternEnd{placements});
  walk.place.path = path;
  return true;
}

/// Copies that are only counted may begin with other tools than the pattern did: the one it ends
/// with, and those of the M02 blocks, in the order in which the last copy takes them.
void check_tools_of_copies(Walk& walk, const RepeatSection& section, const Modal& start) {
  const bool has_copies = std::ranges::any_of(
      section.levels, [](const std::vector<Copies>& level) { return !level.empty(); });
  if (!section.changes_tools || !has_copies) return;
  // Its holes have been counted with the copies.
  const auto look_again = [&] {
    walk.emitter.uncounted([&] { run_instance(walk, section, start, walk.frame); });
  };
  look_again();
  for (auto level = section.levels.rbegin(); level != section.levels.rend(); ++level) {
    for (const Copies& copies : *level) {
      if (!copies.tool) continue;
      take_tool_of(walk, copies);
      look_again();
    }
  }
}

}  // namespace

void run_section(Walk& walk, int line) {
  if (refuse_pending(walk, line, "M25")) return;
  if (walk.in_pattern || walk.is_plunged) {
    walk.reporter.report(walk.is_plunged ? Code::ToolPlunged : Code::CommandMisplaced,
                         line,
                         walk.is_plunged ? "a pattern begins while the router is down"
                                         : "a pattern begins inside a pattern",
                         walk.is_plunged ? "M16 or M17 first" : "M01 and M08 first");
    return;
  }
  const auto section =
      scan_section(walk.cursor,
                   line,
                   {walk.format(), walk.set, walk.deletes_blocks, walk.line_of_open_count},
                   walk.reporter);
  if (!section) {
    walk.ended = true;
    return;
  }
  warn_of_open_count(walk, *section);
  warn_of_swap(walk, *section);
  if (walk.trial != nullptr) {
    walk.trial->is_repeated = true;
    walk.emitter.stop_executing();
  }
  const std::size_t depth = walk.place.path.size();
  walk.in_pattern = true;
  walk.has_dimension = true;  // of M02X#Y#
  walk.place.path.resize(depth + section->levels.size(), 0);
  walk.modal.begins_pattern = true;
  const Modal start = walk.modal;
  if (!run_kept(walk, *section, start))
    run_level(walk, *section, start, section->levels.size(), walk.frame);
  if (walk.is_first_walk() && !section->has_vision) check_tools_of_copies(walk, *section, start);
  warn_of_feed(walk, *section);
  walk.in_pattern = false;
  walk.place.path.resize(depth);
  walk.place.placement = walk.frame;
  if (!walk.has_ended()) end_section(walk, *section);
}

}  // namespace panelcal::excellon
