// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace panelcal::gcode {
namespace {

constexpr double kInch_mm = 25.4;

/// Codes that move nothing in X, Y and Z and change no coordinates; cancels of what is refused.
constexpr std::array kHarmless = {
    4.0, 15.0, 17.0, 40.0, 40.1, 50.0, 61.0, 61.1, 64.0, 69.0, 94.0, 97.0};
constexpr std::array kCycles = {73.0, 81.0, 82.0, 83.0, 85.0, 86.0, 89.0};
constexpr std::array kMotions = {
    MotionKind::Rapid, MotionKind::Line, MotionKind::Clockwise, MotionKind::Counterclockwise};
/// Beside a known move these turn or shift coordinates that have no map.
constexpr std::string_view kOtherAxes = "ABCUVW";
/// Their numbers may be computed: none says where the tool goes.
constexpr std::string_view kFreeLetters = "#DFHPQST";

bool is_one_of(std::span<const double> codes, double code) {
  return std::ranges::find(codes, code) != codes.end();
}

bool has_axis(const GcodeBlock& block) {
  return block.has('X') || block.has('Y') || block.has('Z');
}

std::string text_of(const GcodeBlock& block, const GcodeWord& word) {
  return quoted(block.text.substr(word.begin, word.end - word.begin));
}

}  // namespace

Eigen::Vector2d place_mm(const Motion& motion, double part) {
  const Eigen::Vector2d from_mm = motion.from.xy_mm(), to_mm = motion.to.xy_mm();
  if (part == 1) return to_mm;
  if (!motion.is_arc()) return from_mm + part * (to_mm - from_mm);
  const Eigen::Vector2d begin_mm = from_mm - motion.center_mm;
  const double angle_rad = std::atan2(begin_mm.y(), begin_mm.x()) + part * motion.sweep_rad;
  // The radii at both ends may differ by what the control forgives.
  const double radius_mm =
      begin_mm.norm() + part * ((to_mm - motion.center_mm).norm() - begin_mm.norm());
  return motion.center_mm + radius_mm * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
}

double length_mm(const Motion& motion) {
  if (motion.is_arc()) {
    return std::abs(motion.sweep_rad) * (motion.from.xy_mm() - motion.center_mm).norm();
  }
  return (motion.to.xy_mm() - motion.from.xy_mm()).norm();
}

tl::unexpected<Diagnostic> MotionReader::problem(const GcodeBlock& block,
                                                 Code code,
                                                 const GcodeWord* word,
                                                 std::string what,
                                                 std::string expected) const {
  const int column = word == nullptr ? 1 : static_cast<int>(word->begin) + 1;
  return failure({code, {file_, block.line, column}, std::move(what), std::move(expected)});
}

std::optional<double> MotionReader::number_mm(const GcodeBlock& block, char letter) const {
  const GcodeWord* const word = block.find(letter);
  return word == nullptr ? std::nullopt : std::optional(word->value * unit_mm());
}

// --- modes -------------------------------------------------------------------------------------

void MotionReader::note(double code) {
  if (code == 17) stated_.plane = true;
  if (code == 20 || code == 21) stated_.unit = true;
  if (code == 90 || code == 91) stated_.distance = true;
  if (code == 90.1 || code == 91.1) stated_.arcs = true;
  if (code == 94) stated_.feed = true;
  if (code == 98 || code == 99) stated_.retract = true;
}

std::string MotionReader::take_unstated(const GcodeBlock& block,
                                        const std::optional<Motion>& motion) {
  std::string words;
  const auto need = [&](bool& is_stated, std::string_view word) {
    if (std::exchange(is_stated, true)) return;
    if (!words.empty()) words += ' ';
    words += word;
  };
  const bool is_arc = motion && motion->is_arc();
  const bool is_cycle = motion && motion->kind == MotionKind::Cycle;
  const bool has_feed = block.has('F');
  if (is_arc || is_cycle) need(stated_.plane, "G17");
  if (unit_mm_ && (motion || has_feed)) need(stated_.unit, unit_mm() == kInch_mm ? "G20" : "G21");
  if (motion) need(stated_.distance, "G90");
  if (is_arc) need(stated_.arcs, "G91.1");
  if (has_feed || (motion && motion->kind != MotionKind::Rapid)) need(stated_.feed, "G94");
  if (is_cycle) need(stated_.retract, "G98");
  return words;
}

Expected<void> MotionReader::read_code(const GcodeBlock& block, const GcodeWord& word) {
  const double code = word.value;
  note(code);
  if (code == 0 || code == 1 || code == 2 || code == 3) {
    motion_ = kMotions[static_cast<std::size_t>(code)];
  } else if (is_one_of(kCycles, code)) {
    if (motion_ != MotionKind::Cycle) cycle_began_mm_ = at_.z_mm;
    if (motion_ != MotionKind::Cycle || cycle_code_ != code) {
      cycle_z_mm_ = cycle_r_mm_ = std::nullopt;
    }
    motion_ = MotionKind::Cycle;
    cycle_code_ = code;
  } else if (code == 80) {
    motion_.reset();
  } else if (code == 20 || code == 21) {
    unit_mm_ = code == 20 ? kInch_mm : 1;
  } else if (code == 90 || code == 91) {
    is_incremental_ = code == 91;
  } else if (code == 90.1 || code == 91.1) {
    arcs_are_absolute_ = code == 90.1;
  } else if (code == 98 || code == 99) {
    returns_to_r_ = code == 99;
  } else if (code == 28 || code == 30 || code == 53) {
    return leave(block, word);
  } else if (code == 43 || code == 49) {
    at_.z_mm.reset();
  } else if ((code >= 54 && code < 60) || code == 92.1) {
    // The map lies in one system of coordinates.
    if (has_moved_ && code != offset_code_) {
      return problem(block,
                     Code::NotSupported,
                     &word,
                     text_of(block, word) + " after a move",
                     "one work zero");
    }
    offset_code_ = code == 92.1 ? offset_code_ : code;
  } else if (!is_one_of(kHarmless, code)) {
    return problem(block,
                   Code::NotSupported,
                   &word,
                   text_of(block, word),
                   "G0 to G3 in the XY plane, drilling cycles, and codes that leave coordinates "
                   "alone");
  } else if (code == 4 && (has_axis(block) || block.has('I') || block.has('J'))) {
    return problem(block, Code::NotSupported, &word, "a dwell with coordinates", "G4 P#");
  }
  return {};
}

/// The way home first passes the coordinates of its line, which in G91 are steps from where the
/// tool is.
Expected<void> MotionReader::leave(const GcodeBlock& block, const GcodeWord& word) {
  leaves_ = true;
  const bool is_step =
      std::ranges::any_of(block.words, [](const GcodeWord& other) { return other.is('G', 91); });
  const auto is_zero = [&](char letter) {
    return !block.has(letter) || block.find(letter)->value == 0;
  };
  const bool goes_straight = !has_axis(block) || ((is_incremental_ || is_step) && is_zero('X') &&
                                                  is_zero('Y') && is_zero('Z'));
  if (word.value == 53 || goes_straight) return {};
  return problem(block,
                 Code::NotSupported,
                 &word,
                 text_of(block, word) + " by way of a place",
                 "G28 or G30 alone, or with G91 and steps of 0");
}

Expected<void> MotionReader::read_function(const GcodeBlock& block, const GcodeWord& word) {
  const double code = word.value;
  const auto refuse = [&](std::string expected) {
    return problem(block, Code::NotSupported, &word, text_of(block, word), std::move(expected));
  };
  if (code == 98 || code == 99) return refuse("a program without subprograms");
  // They keep and restore modes: G90 and G91, G20 and G21 among them.
  if (code >= 70 && code <= 73) return refuse("a program that states its modes itself");
  // LinuxCNC starts programs of the user for them.
  if (code >= 100 && code < 200)
    return refuse("a program without the user's own codes M100 to M199");
  if (code == 6) at_ = {};
  has_ended_ = has_ended_ || code == 2 || code == 30;
  return {};
}

Expected<void> MotionReader::read_modes(const GcodeBlock& block) {
  leaves_ = false;
  for (const GcodeWord& word : block.words) {
    if (block.is_deleted && word.letter != 'N') {
      return problem(block,
                     Code::NotSupported,
                     &word,
                     "a line behind a slash, which is executed or not as the operator likes",
                     "lines without a slash");
    }
    if (kOtherAxes.find(word.letter) != std::string_view::npos) {
      return problem(block, Code::NotSupported, &word, text_of(block, word), "moves of X, Y and Z");
    }
    if (word.is_computed && kFreeLetters.find(word.letter) == std::string_view::npos) {
      return problem(block,
                     Code::NotSupported,
                     &word,
                     text_of(block, word),
                     "a number as it is: variables and expressions are not evaluated");
    }
    if (word.letter == 'G') PANELCAL_CHECK(read_code(block, word));
    if (word.letter == 'M') PANELCAL_CHECK(read_function(block, word));
  }
  return {};
}

// --- moves -------------------------------------------------------------------------------------

Expected<std::optional<Motion>> MotionReader::read(const GcodeBlock& block) {
  if (has_ended_ && !block.words.empty()) {
    return problem(block,
                   Code::NotSupported,
                   &block.words.front(),
                   "something behind M2 or M30, which some controls execute",
                   "one program in a file");
  }
  PANELCAL_CHECK(read_modes(block));
  if (leaves_) {
    forget(block);
    return std::nullopt;
  }
  const bool is_arc = motion_ == MotionKind::Clockwise || motion_ == MotionKind::Counterclockwise;
  const bool is_full_circle = is_arc && (block.has('I') || block.has('J'));
  if (!has_axis(block) && !is_full_circle) return std::nullopt;
  PANELCAL_TRY(Motion motion, read_motion(block));
  return motion;
}

/// In the machine's coordinates move the axes that the block names; home go all.
void MotionReader::forget(const GcodeBlock& block) {
  const bool is_partial =
      std::ranges::any_of(block.words, [](const GcodeWord& word) { return word.is('G', 53); });
  if (!is_partial || block.has('X')) at_.x_mm.reset();
  if (!is_partial || block.has('Y')) at_.y_mm.reset();
  if (!is_partial || block.has('Z')) at_.z_mm.reset();
}

/// A step from an unknown place leads to an unknown place.
void MotionReader::read_axis(const GcodeBlock& block,
                             char letter,
                             std::optional<double>& at_mm) const {
  const std::optional<double> word_mm = number_mm(block, letter);
  if (!word_mm) return;
  if (!is_incremental_) {
    at_mm = word_mm;
  } else if (at_mm) {
    // Steps up and down again come back to the very height that other moves are compared with.
    constexpr double kPerMm = 1e9;
    constexpr double kMost_mm = 1e6;  // beyond, no digit is left to round
    const double sum_mm = *at_mm + *word_mm;
    at_mm = std::abs(sum_mm) < kMost_mm ? std::round(sum_mm * kPerMm) / kPerMm : sum_mm;
  }
}

Expected<Motion> MotionReader::read_motion(const GcodeBlock& block) {
  if (!motion_) {
    return problem(block,
                   Code::NotSupported,
                   nullptr,
                   "coordinates without a move",
                   "G0, G1, G2, G3 or a drilling cycle");
  }
  if (!unit_mm_) {
    return problem(block,
                   Code::ArgumentInvalid,
                   nullptr,
                   "a move before its unit is known",
                   "G20 (inches) or G21 (millimetres) before it");
  }
  Motion motion;
  motion.kind = *motion_;
  motion.from = motion.to = at_;
  read_axis(block, 'X', motion.to.x_mm);
  read_axis(block, 'Y', motion.to.y_mm);
  read_axis(block, 'Z', motion.to.z_mm);
  if (motion.is_arc()) PANELCAL_CHECK(read_arc(block, motion));
  at_ = motion.to;
  if (motion.kind == MotionKind::Cycle) {
    PANELCAL_CHECK(read_cycle(block, motion));
    at_.z_mm = motion.travel_mm;
  }
  has_moved_ = true;
  return motion;
}

/// The centre and the sweep of an arc; a full circle ends where it begins and has no radius word.
Expected<void> MotionReader::read_arc(const GcodeBlock& block, Motion& motion) const {
  if (!motion.from.has_xy() || !motion.to.has_xy()) {
    return problem(
        block, Code::CoordinateMissing, nullptr, "arc from an unknown place", "X and Y before it");
  }
  const GcodeWord* const turns = block.find('P');
  if ((turns != nullptr && !turns->is('P', 1)) || block.has('K')) {
    return problem(
        block, Code::NotSupported, turns, "an arc of several turns, or with K", "I and J");
  }
  PANELCAL_TRY(motion.center_mm, center_mm(block, motion));
  const Eigen::Vector2d begin_mm = motion.from.xy_mm() - motion.center_mm;
  const Eigen::Vector2d end_mm = motion.to.xy_mm() - motion.center_mm;
  constexpr double kLeastSlack_mm = 0.0127;  // half a thousandth of an inch, as LinuxCNC has it
  const double slack_mm = std::max(kLeastSlack_mm, 1e-3 * begin_mm.norm());
  if (!(begin_mm.norm() > 0) || std::abs(begin_mm.norm() - end_mm.norm()) > slack_mm) {
    return problem(
        block,
        Code::ArgumentInvalid,
        nullptr,
        fmt::format("an arc that begins {:.4f} mm from its centre and ends {:.4f} mm from it",
                    begin_mm.norm(),
                    end_mm.norm()),
        "one radius");
  }
  constexpr double kTurn = 2 * std::numbers::pi;
  const bool is_clockwise = motion.kind == MotionKind::Clockwise;
  double sweep_rad = std::atan2(end_mm.y(), end_mm.x()) - std::atan2(begin_mm.y(), begin_mm.x());
  if (is_clockwise) {
    while (sweep_rad >= 0) sweep_rad -= kTurn;
  } else {
    while (sweep_rad <= 0) sweep_rad += kTurn;
  }
  motion.sweep_rad = sweep_rad;
  return {};
}

Expected<Eigen::Vector2d> MotionReader::center_mm(const GcodeBlock& block,
                                                  const Motion& motion) const {
  const Eigen::Vector2d from_mm = motion.from.xy_mm();
  if (const auto r_mm = number_mm(block, 'R')) {
    const Eigen::Vector2d half_mm = 0.5 * (motion.to.xy_mm() - from_mm);
    const double away_mm2 = *r_mm * *r_mm - half_mm.squaredNorm();
    constexpr double kRounding = 1e-3;
    if (half_mm.norm() == 0 || away_mm2 < -2 * kRounding * *r_mm * *r_mm) {
      return problem(block,
                     Code::ArgumentInvalid,
                     block.find('R'),
                     "an arc of R that does not reach its end",
                     "a greater R, or I and J");
    }
    // Left of the way lies the centre of short counter-clockwise arcs and long clockwise ones.
    const double side = (motion.kind == MotionKind::Clockwise) == (*r_mm > 0) ? -1 : 1;
    const Eigen::Vector2d left(-half_mm.y(), half_mm.x());
    return Eigen::Vector2d(from_mm + half_mm +
                           side * std::sqrt(std::max(0.0, away_mm2)) * left.normalized());
  }
  if (!block.has('I') && !block.has('J')) {
    return problem(
        block, Code::ArgumentInvalid, nullptr, "an arc without a centre", "I and J, or R");
  }
  const Eigen::Vector2d given_mm(number_mm(block, 'I').value_or(0),
                                 number_mm(block, 'J').value_or(0));
  if (!arcs_are_absolute_) return Eigen::Vector2d(from_mm + given_mm);
  if (!block.has('I') || !block.has('J')) {
    return problem(block, Code::ArgumentInvalid, nullptr, "an arc in G90.1 without I or J", "both");
  }
  return given_mm;
}

/// Z and R hold for the cycle's next holes.
Expected<void> MotionReader::read_cycle(const GcodeBlock& block, Motion& motion) {
  const GcodeWord* const times = block.find('L') != nullptr ? block.find('L') : block.find('K');
  if (times != nullptr && times->value != 1) {
    return problem(block, Code::NotSupported, times, "a cycle that is repeated", "one hole a line");
  }
  const auto above = [&](const std::optional<double>& base_mm, double step_mm) {
    if (!is_incremental_) return std::optional(step_mm);
    return base_mm ? std::optional(*base_mm + step_mm) : std::nullopt;
  };
  if (const auto r_mm = number_mm(block, 'R')) cycle_r_mm_ = above(motion.from.z_mm, *r_mm);
  if (const auto z_mm = number_mm(block, 'Z')) cycle_z_mm_ = above(cycle_r_mm_, *z_mm);
  if (!cycle_z_mm_ || !cycle_r_mm_ || !motion.to.has_xy()) {
    return problem(block,
                   Code::CoordinateMissing,
                   nullptr,
                   "a drilling cycle of which X, Y, Z or R is not known",
                   "each of them, here or before");
  }
  motion.to.z_mm = cycle_z_mm_;
  motion.retract_mm = *cycle_r_mm_;
  motion.travel_mm =
      returns_to_r_ ? *cycle_r_mm_ : std::max(*cycle_r_mm_, cycle_began_mm_.value_or(*cycle_r_mm_));
  return {};
}

}  // namespace panelcal::gcode
