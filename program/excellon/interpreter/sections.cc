// SPDX-License-Identifier: Apache-2.0
// Step and repeat sections: which instance runs when, and with what state it begins.
#include <algorithm>
#include <initializer_list>
#include <utility>
#include <vector>

#include "program/excellon/interpreter/interpreter.h"
#include <fmt/format.h>

namespace panelcal::excellon {

void Interpreter::run_section(int line) {
  if (refuse_pending(line, "M25")) return;
  if (in_pattern_ || is_plunged_) {
    reporter_.report(is_plunged_ ? Code::ToolPlunged : Code::CommandMisplaced,
                     line,
                     1,
                     is_plunged_ ? "a pattern begins while the router is down"
                                 : "a pattern begins inside a pattern",
                     is_plunged_ ? "M16 or M17 first" : "M01 and M08 first");
    return;
  }
  const auto section = scan_section(
      cursor_, line, {format(), set_, deletes_blocks_, line_of_open_count_}, reporter_);
  if (!section) {
    ended_ = true;
    return;
  }
  warn_of_open_count(*section);
  warn_of_swap(*section);
  if (trial_ != nullptr) {
    trial_->is_repeated = true;
    emitter_.stop_executing();
  }
  const std::size_t depth = place_.path.size();
  in_pattern_ = true;
  has_dimension_ = true;  // of M02X#Y#
  place_.path.resize(depth + section->levels.size(), 0);
  modal_.begins_pattern = true;
  const Modal start = modal_;
  if (!run_kept(*section, start)) run_level(*section, start, section->levels.size(), frame_);
  if (is_first_walk() && !section->has_vision) check_tools_of_copies(*section, start);
  warn_of_feed(*section);
  in_pattern_ = false;
  place_.path.resize(depth);
  place_.placement = frame_;
  if (!has_ended()) end_section(*section);
}

/// "After the last M02 repeat command, an extra M02 command which requires no coordinates, must be
/// added in a block by itself. This will clear a counter." Offsets count anew at each M01 all the
/// same, as those of R#M02 do in the manual's sample program.
void Interpreter::warn_of_open_count(const RepeatSection& section) {
  line_of_open_count_ = section.line_of_open_count;
  if (!section.count_behind_open_one || std::exchange(warned_count_, true)) return;
  const auto& [block, line] = *section.count_behind_open_one;
  reporter_.report(
      Code::NotationAccepted,
      block.line,
      block.column,
      fmt::format("{} counts from its pattern, not on from line {}", quoted(block.text), line),
      fmt::format("M02 in a block by itself behind line {}", line));
}

/// All of the manual's examples have the mirrors first; what it says of each command leaves open
/// whether one that comes behind M70 would mirror the other axis.
void Interpreter::warn_of_swap(const RepeatSection& section) {
  if (!section.swap_before_mirror || std::exchange(warned_swap_, true)) return;
  const Block& block = *section.swap_before_mirror;
  reporter_.report(Code::NotationAccepted,
                   block.line,
                   block.column,
                   quoted(block.text) + " is mirrored first, then its axes are exchanged",
                   "M70 behind M80 and M90");
}

/// "A repeat of all the commands" would begin a copy with the feed that the one before has ended
/// with, "identical patterns" with that of the pattern itself, which it has here.
void Interpreter::warn_of_feed(const RepeatSection& section) {
  const auto late = std::exchange(late_feed_, std::nullopt);
  const bool has_copies = std::ranges::any_of(
      section.levels, [](const std::vector<Copies>& level) { return !level.empty(); });
  if (!late || !has_copies || std::exchange(warned_feed_, true)) return;
  reporter_.report(Code::FeedAssumed,
                   late->first.line,
                   late->first.column,
                   quoted(late->second) + " behind a rout at the feed from before the pattern",
                   "F# before the pattern's first rout move");
}

/// The manual clears the incremental accumulators at M08, back to work zero. It does not say what
/// an omitted axis means then in absolute mode, so that is refused (AxisUser::Cleared).
void Interpreter::end_section(const RepeatSection& section) {
  if (!is_inner_section()) vision_.end_section(section.closing.line);
  modal_.at_mm.setZero();
  modal_.user = {AxisUser::Cleared, AxisUser::Cleared};
  modal_.begins_pattern = false;
  modal_.has_hole = false;
  modal_.has_start = false;
  last_cycle_.reset();
  cursor_ = section.after;

  if (section.closing.n_words == 1) return;
  const Word& second = section.closing.words[1];
  const auto code = command(second);
  if (code != Command::EndRewind && code != Command::EndNoRewind) {
    return report(Code::BlockNotAlone, section.closing, second, "M08 alone or with M30");
  }
  end_program(section.closing,
              section.closing.all().subspan(2),
              code == Command::EndRewind ? StopKind::EndRewind : StopKind::EndNoRewind);
}

/// Runs everything below `level` once in place and once for every copy that the level asks for.
void Interpreter::run_level(const RepeatSection& section,
                            const Modal& start,
                            std::size_t level,
                            const Placement& outer) {
  if (level == 0) return run_instance(section, start, outer);
  // levels[] is innermost first, the path outermost first.
  const std::size_t depth = place_.path.size() - level;
  place_.path[depth] = 0;
  const std::int64_t n_before = emitter_.n_operations();
  const std::int64_t n_idle_before = emitter_.n_idle_lines();
  run_level(section, start, level - 1, outer);
  if (is_first_walk() && !section.has_vision) {
    // Checking needs the copies only where they measure; else they are counted.
    std::int64_t n_copies = 0;
    for (const Copies& copies : section.levels[level - 1]) n_copies += copies.run.count;
    emitter_.count_copies(n_copies,
                          emitter_.n_operations() - n_before,
                          emitter_.n_idle_lines() - n_idle_before,
                          section.line);
    return;
  }

  Eigen::Vector2d offset_mm = Eigen::Vector2d::Zero();
  for (const Copies& copies : section.levels[level - 1]) {
    const CopyRun& run = copies.run;
    if (run.restarts) offset_mm.setZero();
    const Eigen::Matrix2d orientation = copy_orientation(run);
    for (int i = 0; i < run.count && !has_ended(); ++i) {
      offset_mm += run.step.in_mm();
      ++place_.path[depth];
      if (copies.tool) take_tool_of(copies);
      run_level(section,
                start,
                level - 1,
                outer * Transform<frame::Programmed, frame::Programmed>(orientation, offset_mm));
    }
  }
}

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

}  // namespace

/// Passes the pattern on once, where it stands, with all its copies. False if structure is not kept
/// here: the copies are to be run.
bool Interpreter::run_kept(const RepeatSection& section, const Modal& start) {
  if (!keeps_structure() || is_inner_section() || !can_keep(section) ||
      !measures_alike(section, vision_.series_size())) {
    return false;
  }
  if (vision_.has_open_series()) {
    reporter_.report(Code::NotSupported,
                     section.line,
                     1,
                     "a pattern begins inside a series of targets, which has no form in a "
                     "translation",
                     "the whole series before M25, or behind it");
    ended_ = true;
    return true;
  }
  std::vector<Copy> copies;
  append_copies(section, section.levels.size(), Copy(), copies);
  // Programmed places become those in work coordinates, and copies as well.
  const Transform<frame::Programmed, frame::Nominal> inverse = frame_.inverse();
  const Copy back(inverse.linear(), inverse.translation());
  std::vector<Placement> placements;
  for (const Copy& copy : copies) {
    placements.push_back(frame_ * copy * back);
  }
  const std::vector<int> path = std::exchange(place_.path, {});
  if (may_nest(section)) {
    emitter_.put(section.line, StoredCorrection{StoredCorrectionKind::NestNext, 0, {}, 0});
  }
  emitter_.put(section.line, PatternBegin{});
  vision_.begin_kept_pattern();
  run_instance(section, start, frame_);
  vision_.end_kept_pattern(placements.size());
  if (!has_ended()) emitter_.put(section.closing.line, PatternEnd{placements});
  place_.path = path;
  return true;
}

/// Copies that are only counted may begin with other tools than the pattern did: the one it ends
/// with, and those of the M02 blocks, in the order in which the last copy takes them.
void Interpreter::check_tools_of_copies(const RepeatSection& section, const Modal& start) {
  const bool has_copies = std::ranges::any_of(
      section.levels, [](const std::vector<Copies>& level) { return !level.empty(); });
  if (!section.changes_tools || !has_copies) return;
  // Its holes have been counted with the copies.
  const auto look_again = [&] {
    emitter_.uncounted([&] { run_instance(section, start, frame_); });
  };
  look_again();
  for (auto level = section.levels.rbegin(); level != section.levels.rend(); ++level) {
    for (const Copies& copies : *level) {
      if (!copies.tool) continue;
      take_tool_of(copies);
      look_again();
    }
  }
}

void Interpreter::take_tool_of(const Copies& copies) {
  Block block;
  block.line = copies.line;
  block.words[0] = *copies.tool;
  block.n_words = 1;
  select_tool(block);
}

void Interpreter::run_instance(const RepeatSection& section,
                               const Modal& start,
                               const Placement& placement) {
  if (has_ended()) return;
  place_.placement = placement;
  modal_ = start;
  const auto feed_outside = std::exchange(feed_in_pattern_, std::nullopt);
  const bool took_feed_outside = std::exchange(takes_feed_from_before_, false);
  last_cycle_.reset();
  if (!is_inner_section()) vision_.begin_instance();
  cursor_ = section.pattern;
  if (cursor_.offset() == section.pattern_end) emitter_.count_idle_line(section.line);
  while (cursor_.offset() < section.pattern_end && !has_ended()) {
    const int number = cursor_.line_number();
    const std::int64_t n_before = emitter_.n_operations();
    if (!run_plain_lines(section.pattern_end)) run_line(cursor_.next());
    if (emitter_.n_operations() == n_before) emitter_.count_idle_line(number);
  }
  if (has_ended()) return;
  const bool is_late = takes_feed_from_before_ && modal_.feed != start.feed;
  if (is_late && !late_feed_) late_feed_ = feed_in_pattern_;
  takes_feed_from_before_ = took_feed_outside || (takes_feed_from_before_ && !feed_outside);
  if (!feed_in_pattern_) feed_in_pattern_ = feed_outside;
  const int end_line = cursor_.line_number();
  refuse_pending(end_line, "the end of the pattern");
  if (std::exchange(is_plunged_, false)) {
    reporter_.report(Code::ToolPlunged,
                     end_line,
                     1,
                     "the pattern ends while the router is down",
                     "M16 or M17 at its end");
  }
  if (!is_inner_section()) vision_.end_instance(end_line);
}

}  // namespace panelcal::excellon
