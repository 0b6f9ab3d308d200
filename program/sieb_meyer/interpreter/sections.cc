// SPDX-License-Identifier: Apache-2.0
// Sections: which copy runs when, and with what state it begins. Subprograms.
#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>

#include "program/sieb_meyer/interpreter/interpreter.h"
#include "program/sieb_meyer/sections/subprograms.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {

/// Runs the lines between two places, and the sections among them.
void Interpreter::run_text(const Text& text,
                           const std::vector<int>& sections,
                           LinePlace begin,
                           std::size_t end) {
  text_ = text;
  cursor_ = LineCursor(text.bytes, begin);
  auto next = sections.begin();
  while (cursor_.offset() < end && !has_ended()) {
    std::size_t plain_end = end;
    if (next != sections.end()) {
      const Section& section = text.sections->sections[static_cast<std::size_t>(*next)];
      if (section.begin.offset <= cursor_.offset()) {
        run_section(*next++);
        continue;
      }
      plain_end = std::min(end, section.begin.offset);
    }
    const int number = cursor_.line_number();
    const std::int64_t n_before = emitter_.n_operations();
    if (!run_plain_lines(plain_end)) run_line(cursor_.next());
    // Subprograms that call subprograms repeat lines as sections do.
    const bool is_repeated = !steps_.empty() || !calls_.empty();
    if (is_repeated && emitter_.n_operations() == n_before) emitter_.count_idle_line(number);
  }
}

void Interpreter::run_section(int i_section) {
  const Section& section = text_.sections->sections[static_cast<std::size_t>(i_section)];
  const Text text = text_;
  if (depth_ >= kMostLevels) {  // a subprogram's brackets count from where it is called
    reporter_.report(Code::NestingTooDeep,
                     section.begin.number,
                     1,
                     "M31 opens another level",
                     fmt::format("at most {} levels, subprograms counted", kMostLevels));
    ended_ = true;
    return;
  }
  if (!section.is_offset()) {
    ++depth_;
    run_body(i_section);
    --depth_;
    if (has_ended()) return;
    cursor_ = LineCursor(text.bytes, section.after);
    return;
  }
  if (pattern_) {
    reporter_.report(Code::CycleUnfinished,
                     pattern_->line,
                     1,
                     panelcal::quoted(pattern_->text) + " has no second point before a section",
                     "X#Y# in the next line");
    ended_ = true;
    return;
  }
  if (is_routing()) {
    reporter_.report(Code::ContourUnclosed,
                     section.begin.number,
                     1,
                     "a section begins while a contour is being routed",
                     "a T0 line before it");
    ended_ = true;
    return;
  }
  if (trial_ != nullptr) {
    trial_->is_repeated = true;
    emitter_.stop_executing();
  }
  if (modal_.reference == Reference::Coordinate) modal_.reference = Reference::Begin;
  ++depth_;
  if (is_kept(section)) {
    run_kept(i_section);
  } else {
    run_copies(i_section);
  }
  --depth_;
  if (has_ended()) return;
  cursor_ = LineCursor(text.bytes, section.after);
  after_section(section);
}

void Interpreter::run_body(int i_section) {
  const Section& section = text_.sections->sections[static_cast<std::size_t>(i_section)];
  run_text(text_, section.children, section.begin, section.body_end);
}

void Interpreter::run_copies(int i_section) {
  const Section& section = text_.sections->sections[static_cast<std::size_t>(i_section)];
  const Modal start = modal_;
  const Placement outer = placement_;
  steps_.emplace_back(section.n_copies(), 0);
  place_.path.push_back(0);
  // The second copy begins with the tool and the planes that the first one ended with, as all
  // others do; so they are only counted.
  constexpr std::int64_t kWalked = 2;
  const bool counts_copies = !emitter_.needs_places() && !section.has.measurements &&
                             !section.has.own_copies && !keeps_structure() && areas_.empty() &&
                             !surface_.has_grid();
  std::int64_t i_copy = 0;
  std::int64_t n_before = 0;
  std::int64_t n_idle_before = 0;
  for (const CopyRow& row : section.rows) {
    for (std::int64_t i = 0; i < row.count && !has_ended(); ++i, ++i_copy) {
      if (counts_copies && i_copy == kWalked) break;
      n_before = emitter_.n_operations();
      n_idle_before = emitter_.n_idle_lines();
      steps_.back().second = i_copy;
      place_.path.back() = static_cast<int>(i_copy);
      const Eigen::Vector2d offset_mm = row.offset_mm(i);
      place(outer * Transform<frame::Programmed, frame::Programmed>(row.orientation, offset_mm));
      run_copy(i_section, start);
    }
    if (counts_copies && i_copy == kWalked) break;
  }
  const std::int64_t n_left = section.n_copies() - i_copy;
  if (counts_copies && n_left > 0 && !has_ended()) {
    emitter_.count_copies(n_left,
                          emitter_.n_operations() - n_before,
                          emitter_.n_idle_lines() - n_idle_before,
                          section.begin.number);
  }
  steps_.pop_back();
  place_.path.pop_back();
  place(outer);
}

/// One copy, from the state that the first one began with; tools and planes carry on.
void Interpreter::run_copy(int i_section, const Modal& start) {
  const std::optional<Feed> feed = modal_.feed;
  modal_ = start;
  modal_.feed = feed;  // carries on like tools and planes
  contour_ = Contour::None;
  const bool was_on = surface_.is_on();
  const bool left_on = std::exchange(leaves_surface_on_, false);
  const Scaling scaling_before = scaling_;
  scaling_.takes_over.reset();
  optical_.begin_copy();
  const KeptOffsets outer_offsets = begin_kept_copy();
  run_body(i_section);
  if (has_ended()) return;
  const int line = cursor_.line_number();
  if (pattern_) {
    reporter_.report(Code::CycleUnfinished,
                     pattern_->line,
                     1,
                     panelcal::quoted(pattern_->text) + " has no second point",
                     "X#Y# in the next line");
    pattern_.reset();
  }
  if (is_routing()) {
    reporter_.report(Code::ContourUnclosed,
                     line,
                     1,
                     "the section ends while a contour is being routed",
                     "a T0 line before the offsets");
  }
  end_contour(line);
  if (leaves_surface_on_) {
    reporter_.report(Code::SurfaceUnfinished,
                     line,
                     1,
                     "the section ends with surface detection on (G71)",
                     "G70 before the offsets");
  } else if (surface_.is_on() != was_on) {
    reporter_.report(Code::SurfaceUnfinished,
                     line,
                     1,
                     "the section ends with surface detection off (G70), and began with it on: its "
                     "copies would not be alike",
                     "G71 in the section, or G70 outside of it");
  }
  leaves_surface_on_ = left_on;
  end_scaled_copy(line, scaling_before);
  optical_.end_copy(line);
  end_kept_copy(line, outer_offsets);
}

/// The manual switches to absolute coordinates at an offset line, and takes program zero for the
/// reference behind a pattern.
void Interpreter::after_section(const Section& section) {
  if (section.layout_line > 0 && modal_.incremental) {
    reporter_.report(Code::ArgumentInvalid,
                     section.layout_line,
                     1,
                     "a subprogram of offset lines is called with X or Y under G91",
                     "G90 before a call with X and Y");
  }
  modal_.at_mm.setZero();
  modal_.reference = Reference::Section;
  modal_.incremental = false;
  modal_.motion.reset();
  modal_.side = CompensationSide::Off;
  contour_ = Contour::None;
  ++n_blocks_;
  // An offset line may switch something else for what follows, such as M92.
  Block block;
  if (lex(LineCursor(text_.bytes, section.closing).next(), block)) return;
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
  if (n > 0) run_block(block);
}

// --- placement ---------------------------------------------------------------------------------

void Interpreter::place(const Placement& placement) {
  placement_ = placement;
  refresh_placement();
}

/// The number of the pattern's copy from 1, all levels counted through: &R, and G39's location.
int Interpreter::step_number() const {
  std::int64_t step = 0;
  for (const auto& [n, i] : steps_) {
    step = step * n + i;
    if (step >= 1'000'000'000) return 1'000'000'000;
  }
  return static_cast<int>(step) + 1;
}

// --- subprograms -------------------------------------------------------------------------------

/// A subprogram of offset lines alone, found once for each state of BLKD; null for all others.
const Layout* Interpreter::called_layout(std::string_view name, bool deletes_blocks) {
  const auto source = program_.patterns.find(name);
  if (source == program_.patterns.end()) return nullptr;
  const auto [known, is_new] =
      layouts_.try_emplace((deletes_blocks ? "/" : "") + std::string(name));
  if (is_new) {
    const SourceText& text = source->second;
    const SubprogramText body = *find_subprogram(text.bytes, name);
    const std::string file = reporter_.file();
    reporter_.set_file(text.file);
    known->second = scan_layout(text.bytes,
                                body.begin,
                                body.end,
                                {.format = format_, .deletes_blocks = deletes_blocks},
                                reporter_);
    if (known->second && known->second->is_sound && is_cut_off(text.bytes, body)) {
      reporter_.report_end_missing(text.bytes, "complete lines");
      known->second->is_sound = false;
    }
    reporter_.set_file(file);
  }
  return known->second ? &*known->second : nullptr;
}

/// Refuses a call that cannot be executed.
bool Interpreter::may_call(const Block& block, const std::string& name) {
  const auto refuse = [&](Code code, std::string what, std::string expected) {
    reporter_.report(code, block.line, block.argument_column, std::move(what), std::move(expected));
    ended_ = true;
    return false;
  };
  if (!is_subprogram_name(name)) {
    return refuse(
        Code::ArgumentInvalid, quoted(block.text), "M99,NAME of capital letters and digits");
  }
  if (std::ranges::find(calls_, name) != calls_.end()) {
    return refuse(Code::SubprogramRecursive,
                  fmt::format("{} calls a subprogram that is being executed ({})",
                              quoted(block.text),
                              fmt::join(calls_, ", ")),
                  "subprograms that do not call themselves");
  }
  if (depth_ + 1 > kMostLevels) {
    return refuse(Code::NestingTooDeep,
                  quoted(block.text) + " opens another level",
                  fmt::format("at most {} levels, subprograms counted", kMostLevels));
  }
  if (!program_.patterns.contains(name)) {
    return refuse(Code::PatternMissing,
                  quoted(block.text) + ": there is no such subprogram",
                  name + ".SS5, or a file *.SS5 with a line @" + name);
  }
  return true;
}

/// The sections of a subprogram, found once for each state of BLKD: a line that it leaves out is no
/// part of them.
const SectionTree& Interpreter::sections_of(const std::string& name,
                                            const SourceText& source,
                                            const SubprogramText& body) {
  const auto [scanned, is_new] =
      subprogram_sections_.try_emplace(deletes_blocks_ ? "/" + name : name);
  if (is_new) {
    scanned->second = scan_sections(source.bytes,
                                    body.begin,
                                    body.end,
                                    {.format = format_,
                                     .deletes_blocks = deletes_blocks_,
                                     .in_subprogram = true,
                                     .find_layout =
                                         [this](std::string_view called, bool deletes_blocks) {
                                           return called_layout(called, deletes_blocks);
                                         }},
                                    reporter_);
    const auto& found = scanned->second.sections;
    const auto mixed = std::ranges::find_if(found, &Section::is_offset);
    if (scanned->second.is_sound && mixed != found.end()) {
      reporter_.report(Code::SubprogramMixed,
                       mixed->rows.front().line,
                       1,
                       panelcal::quoted(name) + " repeats its own lines by offsets",
                       "the offset lines in the program that calls it");
    }
  }
  return scanned->second;
}

void Interpreter::call(const Block& block, const Order& order) {
  const std::string name(block.argument);
  if (!may_call(block, name)) return;
  const SourceText& source = program_.patterns.find(name)->second;
  const SubprogramText body = *find_subprogram(source.bytes, name);

  const Text caller = text_;
  const LineCursor back = cursor_;
  const Placement outer = placement_;
  const Modal modal = modal_;
  const std::string file = reporter_.file();
  const PatternFile outer_pattern = place_.pattern;
  reporter_.set_file(source.file);
  if (is_cut_off(source.bytes, body)) {
    reporter_.report_end_missing(source.bytes, "complete lines");
    reporter_.set_file(file);
    ended_ = true;
    return;
  }
  const SectionTree& sections = sections_of(name, source, body);
  if (!sections.is_sound) {
    ended_ = true;
    return;
  }
  const Eigen::Vector2d zero_mm(order.xy_mm[0].value_or(0), order.xy_mm[1].value_or(0));
  place(outer *
        Transform<frame::Programmed, frame::Programmed>(Eigen::Matrix2d::Identity(), zero_mm));
  place_.pattern = {source.file, source.sha256};
  calls_.push_back(name);
  ++depth_;
  contour_ = Contour::None;
  modal_ = Modal{};
  modal_.feed = modal.feed;
  const Text text{source.bytes, source.file, &sections};
  run_text(text, sections.roots, body.begin, body.end);
  if (!has_ended()) {
    end_contour(cursor_.line_number());
    if (pattern_) {
      report(Code::CycleUnfinished, block, panelcal::quoted(pattern_->text), "its second point");
      pattern_.reset();
    }
  }
  const std::optional<Feed> feed = modal_.feed;
  --depth_;
  calls_.pop_back();
  reporter_.set_file(file);
  place_.pattern = outer_pattern;
  text_ = caller;
  cursor_ = back;
  modal_ = modal;
  modal_.reference = Reference::Call;
  modal_.feed = feed;
  contour_ = Contour::None;
  // FA, SA and FV may have been set inside: their effect is on the placement, not in it.
  place(outer);
}

}  // namespace panelcal::sieb_meyer
