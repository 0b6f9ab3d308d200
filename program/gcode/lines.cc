// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/lines.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include <fmt/format.h>

namespace panelcal::gcode {
namespace {

constexpr std::string_view kCoordinates = "XYZIJR";
constexpr std::array kAfterMove = {0.0, 1.0, 2.0, 30.0, 60.0};

/// A ten-thousandth of a micrometre: more than any program has.
constexpr int kPlaceDecimals = 7;
/// A tenth of a micrometre; in inches a fortieth.
constexpr int kHeightDecimals_mm = 4;
constexpr int kHeightDecimals_inch = 6;

}  // namespace

void GcodeLines::put(const GcodeBlock& block) {
  text_ += block.text;
  text_ += '\n';
}

void GcodeLines::put_unstated(std::string_view words) {
  if (!words.empty()) text_ += fmt::format("{} (not stated by the program)\n", words);
}

void GcodeLines::put_rise(double z_mm, const Counting& counting) {
  line_ = counting.unit_mm == 1 ? "G21 G90 G0" : "G20 G90 G0";
  put_height('Z', z_mm, {.unit_mm = counting.unit_mm});
  end_line();
}

void GcodeLines::begin_move(MotionKind kind) {
  line_ = kind == MotionKind::Rapid       ? "G0"
          : kind == MotionKind::Line      ? "G1"
          : kind == MotionKind::Clockwise ? "G2"
                                          : "G3";
}

void GcodeLines::step(const Motion& motion) {
  const auto move = [](std::optional<double>& told_mm,
                       const std::optional<double>& from_mm,
                       const std::optional<double>& to_mm) {
    told_mm = told_mm && from_mm && to_mm ? *told_mm + (*to_mm - *from_mm) : to_mm;
  };
  move(told_.x_mm, motion.from.x_mm, motion.to.x_mm);
  move(told_.y_mm, motion.from.y_mm, motion.to.y_mm);
  move(told_.z_mm, motion.from.z_mm, motion.to.z_mm);
}

void GcodeLines::put_place(char letter, double value_mm, const Counting& counting) {
  put_coordinate(letter, value_mm, counting, kPlaceDecimals);
}

void GcodeLines::put_height(char letter, double value_mm, const Counting& counting) {
  put_coordinate(letter,
                 value_mm,
                 counting,
                 counting.unit_mm == 1 ? kHeightDecimals_mm : kHeightDecimals_inch);
}

void GcodeLines::put_offset(char letter, double value_mm, const Counting& counting) {
  put_number(letter, value_mm / counting.unit_mm, kPlaceDecimals);
}

void GcodeLines::put_coordinate(char letter,
                                double value_mm,
                                const Counting& counting,
                                int n_decimals) {
  std::optional<double> none;  // R of a cycle leads nowhere
  std::optional<double>& told_mm = letter == 'X'   ? told_.x_mm
                                   : letter == 'Y' ? told_.y_mm
                                   : letter == 'Z' ? told_.z_mm
                                                   : none;
  const double from_mm = counting.is_incremental ? told_mm.value_or(0) : 0;
  const double written = put_number(letter, (value_mm - from_mm) / counting.unit_mm, n_decimals);
  told_mm = from_mm + written * counting.unit_mm;
}

/// Gives the number that was written.
double GcodeLines::put_number(char letter, double value, int n_decimals) {
  std::string text = fmt::format("{:.{}f}", value, n_decimals);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  if (!line_.empty()) line_ += ' ';
  line_ += letter;
  line_ += text == "-0" ? "0" : text;
  double written = 0;
  std::from_chars(text.data(), text.data() + text.size(), written);
  return written;
}

void GcodeLines::end_line() {
  text_ += line_;
  text_ += '\n';
  line_.clear();
}

void GcodeLines::end_block(const GcodeBlock& block) {
  put_others(block, true);
  if (block.rest.empty()) return end_line();
  // New coordinates may have more digits. LinuxCNC refuses lines of more than 252 characters (its
  // buffer of 255 must not be full with the line's end).
  constexpr std::size_t kMaxLine = 252;
  if (line_.size() + 1 + block.rest.size() > kMaxLine) {
    text_ += block.rest;
    text_ += '\n';
  } else {
    line_ += " " + block.rest;
  }
  end_line();
}

void GcodeLines::put_others(const GcodeBlock& block, bool after) {
  for (const GcodeWord& word : block.words) {
    const bool is_after =
        word.letter == 'M' && std::ranges::find(kAfterMove, word.value) != kAfterMove.end();
    const bool is_coordinate = kCoordinates.find(word.letter) != std::string_view::npos;
    if (is_coordinate || is_after != after) continue;
    if (!line_.empty()) line_ += ' ';
    line_ += block.text.substr(word.begin, word.end - word.begin);
  }
}

}  // namespace panelcal::gcode
