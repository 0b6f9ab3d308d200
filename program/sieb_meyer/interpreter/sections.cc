// SPDX-License-Identifier: Apache-2.0
// Sections: which copy runs when, and with what state it begins. Subprograms.
#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>

#include "program/sieb_meyer/interpreter/parts.h"
#include "program/sieb_meyer/sections/subprograms.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

void run_body(Walk& walk, int i_section) {
  const Section& section = walk.section(i_section);
  run_text(walk, walk.text, section.children, section.begin, section.body_end);
}

void run_copies(Walk& walk, int i_section) {
  const Section& section = walk.section(i_section);
  const Modal start = walk.modal;
  const Placement outer = walk.placement;
  walk.steps.emplace_back(section.n_copies(), 0);
  walk.place.path.push_back(0);
  // The second copy begins with the tool and the planes that the first one ended with, as all
  // others do; so they are only counted.
  constexpr std::int64_t kWalked = 2;
  const bool counts_copies = !walk.emitter.needs_places() && !section.has.measurements &&
                             !section.has.own_copies && !walk.keeps_structure() &&
                             walk.areas.empty() && !walk.surface.has_grid();
  std::int64_t i_copy = 0;
  std::int64_t n_before = 0;
  std::int64_t n_idle_before = 0;
  for (const CopyRow& row : section.rows) {
    for (std::int64_t i = 0; i < row.count && !walk.has_ended(); ++i, ++i_copy) {
      if (counts_copies && i_copy == kWalked) break;
      n_before = walk.emitter.n_operations();
      n_idle_before = walk.emitter.n_idle_lines();
      walk.steps.back().second = i_copy;
      walk.place.path.back() = static_cast<int>(i_copy);
      const Eigen::Vector2d offset_mm = row.offset_mm(i);
      place(walk,
            outer * Transform<frame::Programmed, frame::Programmed>(row.orientation, offset_mm));
      run_copy(walk, i_section, start);
    }
    if (counts_copies && i_copy == kWalked) break;
  }
  const std::int64_t n_left = section.n_copies() - i_copy;
  if (counts_copies && n_left > 0 && !walk.has_ended()) {
    walk.emitter.count_copies(n_left,
                              walk.emitter.n_operations() - n_before,
                              walk.emitter.n_idle_lines() - n_idle_before,
                              section.begin.number);
  }
  walk.steps.pop_back();
  walk.place.path.pop_back();
  place(walk, outer);
}

/// The manual switches to absolute coordinates at an offset line, and takes program zero for the
/// reference behind a pattern.
void after_section(Walk& walk, const Section& section) {
  if (section.layout_line > 0 && walk.modal.incremental) {
    walk.reporter.report(Code::ArgumentInvalid,
                         section.layout_line,
                         "a subprogram of offset lines is called with X or Y under G91",
                         "G90 before a call with X and Y");
  }
  walk.modal.at_mm.setZero();
  walk.modal.reference = Reference::Section;
  walk.modal.incremental = false;
  walk.modal.motion.reset();
  walk.modal.side = CompensationSide::Off;
  walk.contour = Contour::None;
  ++walk.n_blocks;
  // An offset line may switch something else for what follows, such as M92.
  Block block;
  if (lex(LineCursor(walk.text.bytes, section.closing).next(), block)) return;
  std::size_t n = 0;
  for (const Word& word : block.all()) {
    const auto command = word.letter == 'M' || word.letter == 'G' ? command_of(word) : std::nullopt;
    const bool is_structure =
        word.letter == 'X' || word.letter == 'Y' || word.letter == 'W' || word.letter == 'V' ||
        (command && (is_offset(*command) || command == Command::CloseSection ||
                     command == Command::Subprogram));
    if (!is_structure) block.words[n++] = word;
  }
  block.n_words = n;
  if (n > 0) run_block(walk, block);
}

void run_section(Walk& walk, int i_section) {
  const Section& section = walk.section(i_section);
  const RunText text = walk.text;
  if (walk.depth >= kMostLevels) {  // a subprogram's brackets count from where it is called
    walk.reporter.report(Code::NestingTooDeep,
                         section.begin.number,
                         "M31 opens another level",
                         fmt::format("at most {} levels, subprograms counted", kMostLevels));
    walk.ended = true;
    return;
  }
  if (!section.is_offset()) {
    ++walk.depth;
    run_body(walk, i_section);
    --walk.depth;
    if (walk.has_ended()) return;
    walk.cursor = LineCursor(text.bytes, section.after);
    return;
  }
  if (walk.pattern) {
    report_open_pattern(walk, " before a section");
    walk.ended = true;
    return;
  }
  if (walk.is_routing()) {
    walk.reporter.report(Code::ContourUnclosed,
                         section.begin.number,
                         "a section begins while a contour is being routed",
                         "a T0 line before it");
    walk.ended = true;
    return;
  }
  if (walk.trial != nullptr) {
    walk.trial->is_repeated = true;
    walk.emitter.stop_executing();
  }
  if (walk.modal.reference == Reference::Coordinate) walk.modal.reference = Reference::Begin;
  ++walk.depth;
  if (is_kept(walk, section)) {
    run_kept(walk, i_section);
  } else {
    run_copies(walk, i_section);
  }
  --walk.depth;
  if (walk.has_ended()) return;
  walk.cursor = LineCursor(text.bytes, section.after);
  after_section(walk, section);
}

/// Refuses a call that cannot be executed.
bool may_call(Walk& walk, const Block& block, const std::string& name) {
  const auto refuse = [&](Code code, std::string what, std::string expected) {
    walk.reporter.report(
        code, block.line, block.argument_column, std::move(what), std::move(expected));
    walk.ended = true;
    return false;
  };
  if (!is_subprogram_name(name)) {
    return refuse(
        Code::ArgumentInvalid, quoted(block.text), "M99,NAME of capital letters and digits");
  }
  if (std::ranges::find(walk.calls, name) != walk.calls.end()) {
    return refuse(Code::SubprogramRecursive,
                  fmt::format("{} calls a subprogram that is being executed ({})",
                              quoted(block.text),
                              fmt::join(walk.calls, ", ")),
                  "subprograms that do not call themselves");
  }
  if (walk.depth + 1 > kMostLevels) {
    return refuse(Code::NestingTooDeep,
                  quoted(block.text) + " opens another level",
                  fmt::format("at most {} levels, subprograms counted", kMostLevels));
  }
  if (!walk.program.patterns.contains(name)) {
    return refuse(Code::PatternMissing,
                  quoted(block.text) + ": there is no such subprogram",
                  name + ".SS5, or a file *.SS5 with a line @" + name);
  }
  return true;
}

/// The sections of a subprogram, found once for each state of BLKD: a line that it leaves out is no
/// part of them.
const SectionTree& sections_of(Walk& walk,
                               const std::string& name,
                               const SourceText& source,
                               const SubprogramText& body) {
  const auto [scanned, is_new] =
      walk.subprogram_sections.try_emplace(walk.deletes_blocks ? "/" + name : name);
  if (is_new) {
    scanned->second = scan_sections(source.bytes,
                                    body.begin,
                                    body.end,
                                    {.format = walk.format,
                                     .deletes_blocks = walk.deletes_blocks,
                                     .in_subprogram = true,
                                     .find_layout =
                                         [&walk](std::string_view called, bool deletes_blocks) {
                                           return called_layout(walk, called, deletes_blocks);
                                         }},
                                    walk.reporter);
    const auto& found = scanned->second.sections;
    const auto mixed = std::ranges::find_if(found, &Section::is_offset);
    if (scanned->second.is_sound && mixed != found.end()) {
      walk.reporter.report(Code::SubprogramMixed,
                           mixed->rows.front().line,
                           quoted(name) + " repeats its own lines by offsets",
                           "the offset lines in the program that calls it");
    }
  }
  return scanned->second;
}

}  // namespace

/// Runs the lines between two places, and the sections among them.
void run_text(Walk& walk,
              const RunText& text,
              const std::vector<int>& sections,
              LinePlace begin,
              std::size_t end) {
  walk.text = text;
  walk.cursor = LineCursor(text.bytes, begin);
  auto next = sections.begin();
  while (walk.cursor.offset() < end && !walk.has_ended()) {
    std::size_t plain_end = end;
    if (next != sections.end()) {
      const Section& section = text.sections->sections[static_cast<std::size_t>(*next)];
      if (section.begin.offset <= walk.cursor.offset()) {
        run_section(walk, *next++);
        continue;
      }
      plain_end = std::min(end, section.begin.offset);
    }
    const int number = walk.cursor.line_number();
    const std::int64_t n_before = walk.emitter.n_operations();
    if (!run_plain_lines(walk, plain_end)) run_line(walk, walk.cursor.next());
    // Subprograms that call subprograms repeat lines as sections do.
    const bool is_repeated = !walk.steps.empty() || !walk.calls.empty();
    if (is_repeated && walk.emitter.n_operations() == n_before)
      walk.emitter.count_idle_line(number);
  }
}

/// One copy, from the state that the first one began with; tools and planes carry on.
void run_copy(Walk& walk, int i_section, const Modal& start) {
  const std::optional<Feed> feed = walk.modal.feed;
  walk.modal = start;
  walk.modal.feed = feed;  // carries on like tools and planes
  walk.contour = Contour::None;
  const bool was_on = walk.surface.is_on();
  const bool left_on = std::exchange(walk.leaves_surface_on, false);
  const Scaling scaling_before = walk.scaling;
  walk.scaling.takes_over.reset();
  walk.optical.begin_copy();
  const KeptOffsets outer_offsets = begin_kept_copy(walk);
  run_body(walk, i_section);
  if (walk.has_ended()) return;
  const int line = walk.cursor.line_number();
  report_open_pattern(walk, "");
  walk.pattern.reset();
  if (walk.is_routing()) {
    walk.reporter.report(Code::ContourUnclosed,
                         line,
                         "the section ends while a contour is being routed",
                         "a T0 line before the offsets");
  }
  end_contour(walk, line);
  if (walk.leaves_surface_on) {
    walk.reporter.report(Code::SurfaceUnfinished,
                         line,
                         "the section ends with surface detection on (G71)",
                         "G70 before the offsets");
  } else if (walk.surface.is_on() != was_on) {
    walk.reporter.report(
        Code::SurfaceUnfinished,
        line,
        "the section ends with surface detection off (G70), and began with it on: its "
        "copies would not be alike",
        "G71 in the section, or G70 outside of it");
  }
  walk.leaves_surface_on = left_on;
  end_scaled_copy(walk, line, scaling_before);
  walk.optical.end_copy(line);
  end_kept_copy(walk, line, outer_offsets);
}

// --- placement ---------------------------------------------------------------------------------

void place(Walk& walk, const Placement& placement) {
  walk.placement = placement;
  refresh_placement(walk);
}

/// The number of the pattern's copy from 1, all levels counted through: &R, and G39's location.
int step_number(const Walk& walk) {
  std::int64_t step = 0;
  for (const auto& [n, i] : walk.steps) {
    step = step * n + i;
    if (step >= 1'000'000'000) return 1'000'000'000;
  }
  return static_cast<int>(step) + 1;
}

// --- subprograms -------------------------------------------------------------------------------

/// A subprogram of offset lines alone, found once for each state of BLKD; null for all others.
const Layout* called_layout(Walk& walk, std::string_view name, bool deletes_blocks) {
  const auto source = walk.program.patterns.find(name);
  if (source == walk.program.patterns.end()) return nullptr;
  const auto [known, is_new] =
      walk.layouts.try_emplace((deletes_blocks ? "/" : "") + std::string(name));
  if (is_new) {
    const SourceText& text = source->second;
    const SubprogramText body = *find_subprogram(text.bytes, name);
    const std::string file = walk.reporter.file();
    walk.reporter.set_file(text.file);
    known->second = scan_layout(text.bytes,
                                body.begin,
                                body.end,
                                {.format = walk.format, .deletes_blocks = deletes_blocks},
                                walk.reporter);
    if (known->second && known->second->is_sound && is_cut_off(text.bytes, body)) {
      walk.reporter.report_end_missing(text.bytes, "complete lines");
      known->second->is_sound = false;
    }
    walk.reporter.set_file(file);
  }
  return known->second ? &*known->second : nullptr;
}

void call(Walk& walk, const Block& block, const Order& order) {
  const std::string name(block.argument);
  if (!may_call(walk, block, name)) return;
  const SourceText& source = walk.program.patterns.find(name)->second;
  const SubprogramText body = *find_subprogram(source.bytes, name);

  const RunText caller = walk.text;
  const LineCursor back = walk.cursor;
  const Placement outer = walk.placement;
  const Modal modal = walk.modal;
  const std::string file = walk.reporter.file();
  const PatternFile outer_pattern = walk.place.pattern;
  walk.reporter.set_file(source.file);
  if (is_cut_off(source.bytes, body)) {
    walk.reporter.report_end_missing(source.bytes, "complete lines");
    walk.reporter.set_file(file);
    walk.ended = true;
    return;
  }
  const SectionTree& sections = sections_of(walk, name, source, body);
  if (!sections.is_sound) {
    walk.ended = true;
    return;
  }
  const Eigen::Vector2d zero_mm(order.xy_mm[0].value_or(0), order.xy_mm[1].value_or(0));
  place(walk,
        outer *
            Transform<frame::Programmed, frame::Programmed>(Eigen::Matrix2d::Identity(), zero_mm));
  walk.place.pattern = {source.file, source.sha256};
  walk.calls.push_back(name);
  ++walk.depth;
  walk.contour = Contour::None;
  walk.modal = Modal{};
  walk.modal.feed = modal.feed;
  const RunText text{source.bytes, source.file, &sections};
  run_text(walk, text, sections.roots, body.begin, body.end);
  if (!walk.has_ended()) {
    end_contour(walk, walk.cursor.line_number());
    if (refuse_open_pattern(walk, block)) walk.pattern.reset();
  }
  const std::optional<Feed> feed = walk.modal.feed;
  --walk.depth;
  walk.calls.pop_back();
  walk.reporter.set_file(file);
  walk.place.pattern = outer_pattern;
  walk.text = caller;
  walk.cursor = back;
  walk.modal = modal;
  walk.modal.reference = Reference::Call;
  walk.modal.feed = feed;
  walk.contour = Contour::None;
  // FA, SA and FV may have been set inside: their effect is on the placement, not in it.
  place(walk, outer);
}

}  // namespace panelcal::sieb_meyer
