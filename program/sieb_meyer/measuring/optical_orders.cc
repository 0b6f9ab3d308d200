// SPDX-License-Identifier: Apache-2.0
// G39: sets of corrections that a program saves and loads, and offsets of spindles that it moves.
#include <algorithm>
#include <string_view>
#include <utility>

#include "program/sieb_meyer/measuring/offset_deviation.h"
#include "program/sieb_meyer/measuring/optical.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// Sound holes are refused once in this number of orders to store their offset.
constexpr double kScatterChance = 0.001;

/// The n-th copy of both structures has the same number. One level of sections counts its copies
/// from 1, whether some of its panel are left out behind them or not; how the number of nested
/// copies runs on, the manual does not say.
bool counts_alike(const std::vector<std::int64_t>& copies, const std::vector<std::int64_t>& other) {
  return copies == other || (copies.size() == 1 && other.size() == 1);
}

}  // namespace

bool OpticalSession::organize(const Block& block, int step, const TargetPlace& place) {
  const std::string_view text = block.argument;
  const auto is_word = [&](std::string_view word) { return text.starts_with(word); };
  const auto slot_behind = [&](std::string_view word) -> std::optional<int> {
    const std::string_view number = text.substr(word.size());
    return number.empty() ? std::optional(step) : parse_count(number);
  };
  const auto refuse = [&](std::string expected) {
    reporter_.report(Code::ArgumentInvalid,
                     block.line,
                     block.argument_column,
                     quoted(text),
                     std::move(expected));
    measuring_.stop();
    return false;
  };
  if (text == "DELALL") {
    saved_.clear();
    return false;
  }
  for (const std::string_view word : {"SAVE", "LOAD", "CLEAR"}) {
    if (!is_word(word)) continue;
    const auto slot = slot_behind(word);
    if (!slot) return refuse(std::string(word) + " or " + std::string(word) + "# with a number");
    if (*slot < 1 || *slot > static_cast<int>(kMostSets)) {
      reporter_.report(Code::CorrectionSetsFull,
                       block.line,
                       block.argument_column,
                       fmt::format("{} asks for storage location {}", quoted(block.text), *slot),
                       fmt::format("1 to {}", kMostSets));
      measuring_.stop();
      return false;
    }
    if (word == "SAVE") save(block, *slot, text.size() > word.size(), place);
    if (word == "LOAD") load(block, *slot, place);
    if (word == "CLEAR") saved_.erase(*slot);
    return false;
  }
  if (const auto order = offset_order(text)) return move_offset(block, *order, place);
  if (is_word("SPOF") && parse_count(text.substr(4))) {
    return refuse(fmt::format("SPOF# with a spindle from 1 to {}", kMostSpindles));
  }
  if (text == "REQCOMP") {
    request_correction(block, place);
    return false;
  }
  return refuse("SAVE, LOAD, CLEAR, DELALL, SPOP, SPOP1, SPOP2, SPISPI, SPOF# or REQCOMP");
}

/// "Get correction value from the camera computer (requirement: measurement mode = 3)" (manual,
/// G39). The vision system that has seen the targets is ours: its value is their fit, or the last
/// one where no target came since. It is in force, as what G39,LOAD gets.
void OpticalSession::request_correction(const Block& block, const TargetPlace& place) {
  const auto refuse = [&](Code code, std::string what, std::string expected) {
    reporter_.report(code, block.with(quoted(block.text) + what), std::move(expected));
    measuring_.stop();
  };
  if (mode_ != 3) {
    return refuse(Code::CommandMisplaced,
                  fmt::format(" needs measurement mode 3, not {}", mode_),
                  "[vision] mode = 3 (manual, 9, G39), or G31");
  }
  if (has_open_layers("G39,REQCOMP", block.line)) return;
  if (points_.empty()) {
    if (!base_) return refuse(Code::CorrectionMissing, " without measurements", "G32 before it");
    if (!is_made_of_last(*base_)) {
      return refuse(Code::CommandMisplaced,
                    " comes behind a correction that is not of the last targets",
                    "G39,LOAD alone, which turns its values on, or a target between them");
    }
    const bool is_in_force =
        is_on_ && !pattern_.nested && measuring_.corrections().base_series == base_;
    if (is_in_force) return;
  } else {
    base_ = fit_waiting(place);
  }
  put_in_force(block.line);
  requested_ = {block.line, reporter_.file(), *base_};
}

/// For messages: the order and its line, with the file where that is another one than theirs.
/// Precondition: requested_ is set
std::string OpticalSession::request_text() const {
  const std::string text = fmt::format("G39,REQCOMP of line {}", requested_->line);
  return requested_->file == reporter_.file() ? text : text + " of " + requested_->file;
}

/// Whether the correction is on behind G39,REQCOMP the manual does not say.
void OpticalSession::note_stroke(int line) {
  if (!is_assumed_on()) return;
  requested_->is_assumed_on = false;
  reporter_.report(Code::CorrectionAssumed,
                   line,
                   request_text() + " is taken to turn the correction on",
                   "G31 behind it");
}

void OpticalSession::note_measured(std::vector<std::size_t> measurements) {
  last_measurements_ = std::move(measurements);
  last_deviation_.reset();
}

/// True if the deviation that an order stores is one of the offset in force, and is used only once.
bool OpticalSession::may_move_offset(const Block& block) {
  const auto refuse = [&](std::string_view what, std::string expected) {
    reporter_.report(Code::CommandMisplaced, block, fmt::format(" {}", what), std::move(expected));
    measuring_.stop();
    return false;
  };
  const auto has_points = [](const PatternState& pattern) { return !pattern.points.empty(); };
  if (has_points(pattern_) || std::ranges::any_of(outer_patterns_, has_points)) {
    return refuse(
        "comes in the middle of a pattern, whose points would be measured with two offsets",
        "it behind the pattern's copy, or before its first G36");
  }
  const CorrectionState& on = measuring_.corrections();
  if ((on.base_series && is_made_of_last(*on.base_series)) ||
      (on.nested_series && is_made_of_last(*on.nested_series))) {
    return refuse(
        "takes over the measurements of the correction that is on; with both, holes would be "
        "moved by it twice",
        "G30 or G34 before it");
  }
  if (last_deviation_ && n_looks_ != n_looks_at_order_) {
    return refuse("stores a second time the measurement with the offset before that",
                  "all orders for one measurement before the next is made");
  }
  return true;
}

/// Each target is of one base series at most, and the series of a pattern begin alike.
bool OpticalSession::is_made_of_last(std::size_t i_series) const {
  return !last_measurements_.empty() &&
         measuring_.series(i_series).measurements.front() == last_measurements_.front();
}

/// Neither G31 nor G39,LOAD may bring back a correction by what has become the offset's.
void OpticalSession::forget_corrections_of_last() {
  if (base_ && is_made_of_last(*base_)) base_.reset();
  if (requested_ && is_made_of_last(requested_->i_series)) requested_.reset();
  std::erase_if(saved_, [&](const auto& numbered) {
    const SavedSet& set = numbered.second;
    return (set.base && is_made_of_last(*set.base)) || (set.nested && is_made_of_last(*set.nested));
  });
}

/// The mean of what was measured last; absent if nothing was, or if that is no one offset. Sets
/// `is_lost` if a target was not found: that was said, and nothing is drilled.
std::optional<OffsetCorrection> OpticalSession::deviation_of_last(const Block& block,
                                                                  bool& is_lost) {
  std::vector<Measurement> measured;
  for (const std::size_t i : last_measurements_) {
    is_lost |= !measuring_.is_found(i);
    measured.push_back(measuring_.measurement(i));
  }
  if (is_lost) return std::nullopt;
  auto deviation = offset_deviation(measured, options_.uncertainty);
  if (!deviation) {
    reporter_.report(Code::CorrectionMissing,
                     block,
                     " has no measured offset to store",
                     "G32 at a hole that this spindle drilled, before it");
    return std::nullopt;
  }
  const double chance = scatter_chance(measured, options_.uncertainty);
  if (!(chance < kScatterChance)) return deviation;
  reporter_.report(Code::CalibrationRefused,
                   block,
                   fmt::format(": the holes measured for it lie farther apart than [uncertainty] "
                               "allows (chance {:.1e}, limit {})",
                               chance,
                               kScatterChance),
                   "sound holes that this spindle drilled");
  return std::nullopt;
}

/// The measured target is for the spindle's offset, and no target of the board's any more. The
/// order goes through as well, for the machine's own use.
bool OpticalSession::move_offset(const Block& block,
                                 const OffsetOrder& order,
                                 const TargetPlace& place) {
  settle_points();
  if (!measurements_.empty()) note_measured(std::exchange(measurements_, {}));
  forget_waiting();
  if (!options_.moves_offset) {
    measuring_.report_not_calibrated(block.line, block.column, block.text);
    return true;
  }
  if (!may_move_offset(block)) return false;
  forget_corrections_of_last();
  if (!measuring_.is_first_pass()) return true;
  if (!last_deviation_) {
    bool is_lost = false;
    last_deviation_ = deviation_of_last(block, is_lost);
    n_looks_at_order_ = n_looks_;
    if (is_lost) return true;
  }
  if (!last_deviation_) {
    measuring_.stop();
    return false;
  }
  CalibrationOrder calibration;
  calibration.line = block.line;
  calibration.file = place.file;
  calibration.file_sha256 = place.file_sha256;
  calibration.command = "G39," + std::string(block.argument);
  calibration.path = place.path;
  calibration.correction = *last_deviation_;
  calibration.correction->order = order;
  measuring_.calibrate(std::move(calibration), block.column, block.text);
  return true;
}

void OpticalSession::save(const Block& block, int slot, bool has_number, const TargetPlace& place) {
  if (!base_ && !pattern_.nested) {
    reporter_.report(
        Code::CorrectionMissing, block, " without a correction to save", "G32 and G31 before it");
    measuring_.stop();
    return;
  }
  saved_[slot] = {base_, pattern_.nested, place.placement, place.copies, has_number, block.line};
}

/// Without a number of its own a set belongs to the copy it was measured on: another structure of
/// sections counts its copies in another order. A section with fewer copies (a panel with boards
/// that are marked as bad) may take the sets whose places it has under the same numbers.
void OpticalSession::load(const Block& block, int slot, const TargetPlace& place) {
  const auto found = saved_.find(slot);
  if (found == saved_.end()) {
    reporter_.report(Code::CorrectionMissing,
                     block,
                     fmt::format(": location {} is empty", slot),
                     "G39,SAVE earlier in the program");
    measuring_.stop();
    return;
  }
  const SavedSet& set = found->second;
  const bool asks_by_step = block.argument == "LOAD";
  const bool is_same =
      counts_alike(set.copies, place.copies) && is_same_place(set.placement, place.placement);
  if (asks_by_step && !set.has_number && !is_same) {
    reporter_.report(
        Code::StoredElsewhere,
        block,
        fmt::format(" takes a set that line {} saved in other sections or at another zero",
                    set.line),
        "the same sections and offsets as where it was saved");
    measuring_.stop();
    return;
  }
  base_ = set.base;
  if (requested_) requested_->is_assumed_on = false;
  pattern_.nested = set.nested;
  is_on_ = true;
  measuring_.corrections().clear_base();
  if (base_) measuring_.activate(*base_, block.line);
  if (pattern_.nested) measuring_.activate(*pattern_.nested, block.line);
}

}  // namespace panelcal::sieb_meyer
