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

constexpr int kMostDecimals = 7;
/// A tenth of a micrometre; in inches a fortieth.
constexpr int kHeightDecimals_mm = 4;
constexpr int kHeightDecimals_inch = 6;

/// LinuxCNC refuses lines of more than 252 characters (its buffer of 255 must not be full with the
/// line's end).
constexpr std::size_t kMaxLine = 252;

/// Begins what is left of a comment: there the control looks for orders to itself (MSG, LOG).
constexpr std::string_view kGoesOn = "... ";

constexpr std::array kMotionWords = {"G0", "G1", "G2", "G3"};

/// Number of bytes of a text to write, without a part of a UTF-8 character.
std::size_t fitting(std::string_view text, std::size_t n_most) {
  if (text.size() <= n_most) return text.size();
  std::size_t n = n_most;
  while (n > 0 && (static_cast<unsigned char>(text[n]) & 0xC0U) == 0x80U) --n;
  return n > 0 ? n : n_most;
}

/// Writes a comment in as many lines as it needs.
void append_in_lines(std::string_view comment, std::string_view slash, std::string& out) {
  const bool is_bracketed = comment.starts_with('(');
  std::string_view text = comment.substr(1, comment.size() - (is_bracketed ? 2 : 1));
  std::size_t n_most = kMaxLine - slash.size() - (is_bracketed ? 2 : 1);
  std::string_view leader;
  do {
    const std::size_t n = fitting(text, n_most);
    out += slash;
    out += comment.front();
    out += leader;
    out += text.substr(0, n);
    out += is_bracketed ? ")\n" : "\n";
    text.remove_prefix(n);
    if (leader.empty()) n_most -= kGoesOn.size();
    leader = kGoesOn;
  } while (!text.empty());
}

}  // namespace

void GcodeLines::put(const GcodeBlock& block) {
  if (block.text.size() > kMaxLine) return put_long(block);
  text_ += block.text;
  text_ += '\n';
}

/// Without the blanks, and with the comments in lines of their own before it: the control obeys
/// those first (LinuxCNC, Order of Execution).
void GcodeLines::put_long(const GcodeBlock& block) {
  if (!block.rest.empty()) put_comments(block);
  if (block.words.empty() && !block.rest.empty()) return;
  line_ = block.is_deleted ? "/" : "";
  for (const GcodeWord& word : block.words) {
    if (&word != &block.words.front()) line_ += ' ';
    for (const char c : block.text.substr(word.begin, word.end - word.begin)) {
      if (c != ' ' && c != '\t') line_ += c;
    }
  }
  end_line();
}

void GcodeLines::put_comments(const GcodeBlock& block) {
  const std::string_view slash = block.is_deleted ? "/" : "";
  if (slash.size() + block.rest.size() <= kMaxLine) {
    text_ += fmt::format("{}{}\n", slash, block.rest);
    return;
  }
  std::string_view rest = block.rest;
  while (!rest.empty()) {
    const std::size_t n = rest.front() == '%'   ? 1
                          : rest.front() == '(' ? rest.find(')') + 1
                                                : rest.size();
    if (rest.front() == '%') {
      text_ += "%\n";
    } else {
      append_in_lines(rest.substr(0, n), slash, text_);
    }
    rest.remove_prefix(n);
  }
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
  line_ = kMotionWords[static_cast<std::size_t>(kind)];
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
  put_coordinate(letter, value_mm, counting, decimals(counting));
}

void GcodeLines::put_standing(const Counting& counting) {
  put_coordinate('X', told_.x_mm.value_or(0), counting, kMostDecimals);
  put_coordinate('Y', told_.y_mm.value_or(0), counting, kMostDecimals);
}

void GcodeLines::put_height(char letter, double value_mm, const Counting& counting) {
  put_coordinate(letter,
                 value_mm,
                 counting,
                 counting.unit_mm == 1 ? kHeightDecimals_mm : kHeightDecimals_inch);
}

void GcodeLines::put_offset(char letter, double value_mm, const Counting& counting) {
  put_number(letter, value_mm / counting.unit_mm, decimals(counting));
}

void GcodeLines::put_word(const GcodeBlock& block, char letter) {
  const GcodeWord* const word = block.find(letter);
  if (word != nullptr) put_text(block.text.substr(word->begin, word->end - word->begin));
}

void GcodeLines::put_text(std::string_view word) {
  if (!line_.empty()) line_ += ' ';
  line_ += word;
}

int GcodeLines::decimals(const Counting& counting) const {
  return counting.unit_mm == 1 ? n_decimals_ : std::min(kMostDecimals, n_decimals_ + 1);
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
  put_text({&letter, 1});
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

void GcodeLines::begin_block(const GcodeBlock& block, std::optional<MotionKind> kind) {
  put_others(block, false, kind);
}

void GcodeLines::end_block(const GcodeBlock& block) {
  put_others(block, true, std::nullopt);
  if (block.rest.empty()) return end_line();
  // New coordinates may have more digits.
  if (line_.size() + 1 + block.rest.size() > kMaxLine) {
    put_comments(block);
  } else {
    line_ += " " + block.rest;
  }
  end_line();
}

void GcodeLines::put_others(const GcodeBlock& block, bool after, std::optional<MotionKind> kind) {
  for (const GcodeWord& word : block.words) {
    const bool is_after =
        word.letter == 'M' && std::ranges::find(kAfterMove, word.value) != kAfterMove.end();
    const bool is_coordinate = kCoordinates.find(word.letter) != std::string_view::npos;
    if (is_coordinate || is_after != after) continue;
    const bool is_motion = word.letter == 'G' && (word.value == 0 || word.value == 1 ||
                                                  word.value == 2 || word.value == 3);
    const bool is_other = kind && is_motion && word.value != static_cast<double>(*kind);
    put_text(is_other ? kMotionWords[static_cast<std::size_t>(*kind)]
                      : block.text.substr(word.begin, word.end - word.begin));
    if (is_motion) kind.reset();
  }
  if (kind) put_text(kMotionWords[static_cast<std::size_t>(*kind)]);
}

}  // namespace panelcal::gcode
