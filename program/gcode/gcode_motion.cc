// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/gcode/gcode_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace panelcal::gcode {
namespace {

constexpr double kInch_mm = 25.4;

/// Codes that move nothing in X, Y and Z and change no coordinates.
constexpr std::array kHarmless = {4.0, 17.0, 40.0, 43.0, 49.0, 61.0, 61.1, 64.0, 94.0, 97.0};
constexpr std::array kCycles = {73.0, 81.0, 82.0, 83.0, 85.0, 86.0, 89.0};
/// Beside a known move these turn or shift what nobody maps.
constexpr std::string_view kOtherAxes = "ABCUVW";

bool is_one_of(std::span<const double> codes, double code) {
  return std::ranges::find(codes, code) != codes.end();
}

}  // namespace

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

Expected<void> MotionReader::read_mode(const GcodeBlock& block, const GcodeWord& word) {
  const double code = word.value;
  const std::string text = quoted(block.text.substr(word.begin, word.end - word.begin));
  if (code == 0 || code == 1 || code == 2 || code == 3 || is_one_of(kCycles, code)) {
    if (motion_ != code) cycle_z_mm_ = cycle_r_mm_ = std::nullopt;
    motion_ = code;
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
    leaves_ = true;
  } else if (code >= 54 && code < 60) {
    // The map lies in one system of coordinates.
    if (has_moved_) {
      return problem(block, Code::NotSupported, &word, text + " after a move", "one work zero");
    }
  } else if (!is_one_of(kHarmless, code)) {
    return problem(block,
                   Code::NotSupported,
                   &word,
                   text,
                   "G0 to G3 in the XY plane, drilling cycles, and codes that leave coordinates "
                   "alone");
  }
  return {};
}

Expected<void> MotionReader::read_modes(const GcodeBlock& block) {
  leaves_ = false;
  for (const GcodeWord& word : block.words) {
    if (word.letter == 'G') PANELCAL_CHECK(read_mode(block, word));
    if (word.letter != 'M') continue;
    if (word.value == 98 || word.value == 99) {
      return problem(block,
                     Code::NotSupported,
                     &word,
                     quoted(block.text.substr(word.begin, word.end - word.begin)),
                     "a program without subprograms");
    }
    has_ended_ = has_ended_ || word.value == 2 || word.value == 30;
  }
  return {};
}

// --- moves -------------------------------------------------------------------------------------

Expected<std::optional<Motion>> MotionReader::read(const GcodeBlock& block) {
  const bool has_axis = block.has('X') || block.has('Y') || block.has('Z');
  const bool has_motion_word = std::ranges::any_of(block.words, [](const GcodeWord& word) {
    return word.letter == 'G' && (word.value < 4 || (word.value >= 73 && word.value < 90));
  });
  if (block.is_deleted && (has_axis || has_motion_word)) {
    return problem(block,
                   Code::NotSupported,
                   nullptr,
                   "a move behind a slash, which is executed or not as the operator likes",
                   "moves without a slash");
  }
  PANELCAL_CHECK(read_modes(block));
  const auto other = std::ranges::find_if(block.words, [](const GcodeWord& word) {
    return kOtherAxes.find(word.letter) != std::string_view::npos;
  });
  if (leaves_) {
    at_ = {};
    return std::nullopt;
  }
  if (other != block.words.end()) {
    return problem(block,
                   Code::NotSupported,
                   &*other,
                   quoted(block.text.substr(other->begin, other->end - other->begin)),
                   "moves of X, Y and Z");
  }
  const bool is_full_circle =
      motion_ && (*motion_ == 2 || *motion_ == 3) && (block.has('I') || block.has('J'));
  if (!has_axis && !is_full_circle) return std::nullopt;
  PANELCAL_TRY(Motion motion, read_motion(block));
  return motion;
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
  if (is_incremental_) {
    return problem(block, Code::NotSupported, nullptr, "a move in G91", "G90 before it");
  }
  Motion motion;
  motion.from = motion.to = at_;
  if (const auto x_mm = number_mm(block, 'X')) motion.to.x_mm = x_mm;
  if (const auto y_mm = number_mm(block, 'Y')) motion.to.y_mm = y_mm;
  if (const auto z_mm = number_mm(block, 'Z')) motion.to.z_mm = z_mm;
  motion.kind = *motion_ == 0   ? MotionKind::Rapid
                : *motion_ == 1 ? MotionKind::Line
                : *motion_ == 2 ? MotionKind::Clockwise
                : *motion_ == 3 ? MotionKind::Counterclockwise
                                : MotionKind::Cycle;
  if (motion.is_arc()) PANELCAL_CHECK(read_arc(block, motion));
  if (motion.kind == MotionKind::Cycle) {
    PANELCAL_CHECK(read_cycle(block, motion));
    at_ = motion.to;
    at_.z_mm = motion.returns_to_r || !motion.from.z_mm
                   ? motion.retract_mm
                   : std::max(motion.retract_mm, *motion.from.z_mm);
  } else {
    at_ = motion.to;
  }
  has_moved_ = true;
  return motion;
}

/// The centre and the sweep of an arc; a full circle ends where it begins and has no radius word.
Expected<void> MotionReader::read_arc(const GcodeBlock& block, Motion& motion) const {
  if (!motion.from.has_xy() || !motion.to.has_xy()) {
    return problem(block,
                   Code::CoordinateMissing,
                   nullptr,
                   "an arc from nobody knows where",
                   "X and Y before");
  }
  if (const GcodeWord* turns = block.find('P'); turns != nullptr || block.has('K')) {
    return problem(
        block, Code::NotSupported, turns, "an arc of several turns, or with K", "I and J");
  }
  const Eigen::Vector2d from_mm = motion.from.xy_mm(), to_mm = motion.to.xy_mm();
  const bool is_clockwise = motion.kind == MotionKind::Clockwise;
  if (const auto r_mm = number_mm(block, 'R')) {
    const Eigen::Vector2d half_mm = 0.5 * (to_mm - from_mm);
    const double away_mm2 = *r_mm * *r_mm - half_mm.squaredNorm();
    constexpr double kRounding = 1e-3;
    const double radius_mm = std::abs(*r_mm);
    if (half_mm.norm() == 0 || away_mm2 < -2 * kRounding * radius_mm * radius_mm) {
      return problem(block,
                     Code::ArgumentInvalid,
                     block.find('R'),
                     "an arc of R that does not reach its end",
                     "a greater R, or I and J");
    }
    const double away_mm = std::sqrt(std::max(0.0, away_mm2));
    // Left of the way lies the centre of short counter-clockwise arcs and long clockwise ones.
    const double side = is_clockwise == (*r_mm > 0) ? -1 : 1;
    const Eigen::Vector2d left(-half_mm.y(), half_mm.x());
    motion.center_mm = from_mm + half_mm + side * away_mm * left.normalized();
  } else if (block.has('I') || block.has('J')) {
    const Eigen::Vector2d given_mm(number_mm(block, 'I').value_or(0),
                                   number_mm(block, 'J').value_or(0));
    if (arcs_are_absolute_ && !(block.has('I') && block.has('J'))) {
      return problem(
          block, Code::ArgumentInvalid, nullptr, "an arc in G90.1 without I or J", "both");
    }
    motion.center_mm = arcs_are_absolute_ ? given_mm : Eigen::Vector2d(from_mm + given_mm);
  } else {
    return problem(
        block, Code::ArgumentInvalid, nullptr, "an arc without a centre", "I and J, or R");
  }
  const Eigen::Vector2d begin_mm = from_mm - motion.center_mm, end_mm = to_mm - motion.center_mm;
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
  double sweep_rad = std::atan2(end_mm.y(), end_mm.x()) - std::atan2(begin_mm.y(), begin_mm.x());
  if (is_clockwise) {
    while (sweep_rad >= 0) sweep_rad -= kTurn;
  } else {
    while (sweep_rad <= 0) sweep_rad += kTurn;
  }
  motion.sweep_rad = sweep_rad;
  return {};
}

/// Z and R hold for the cycle's next holes.
Expected<void> MotionReader::read_cycle(const GcodeBlock& block, Motion& motion) {
  if (const GcodeWord* times = block.find('L'); times != nullptr && times->value != 1) {
    return problem(block, Code::NotSupported, times, "a cycle that is repeated", "one hole a line");
  }
  if (const auto z_mm = number_mm(block, 'Z')) cycle_z_mm_ = z_mm;
  if (const auto r_mm = number_mm(block, 'R')) cycle_r_mm_ = r_mm;
  if (!cycle_z_mm_ || !cycle_r_mm_ || !motion.to.has_xy()) {
    return problem(block,
                   Code::CoordinateMissing,
                   nullptr,
                   "a drilling cycle of which X, Y, Z or R is not known",
                   "each of them, here or before");
  }
  motion.to.z_mm = cycle_z_mm_;
  motion.retract_mm = *cycle_r_mm_;
  motion.returns_to_r = returns_to_r_;
  return {};
}

}  // namespace panelcal::gcode
