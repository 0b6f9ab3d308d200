// SPDX-License-Identifier: Apache-2.0
// Lines of format 5000: coordinates, tools, feeds, texts and the $ table.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "program/writers/sieb_meyer/writer.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Source SIEB & MEYER CNC 8x.00 Command Set, A.7.1
constexpr std::size_t kMaxLineCharacters = 64;
constexpr int kMostTools = 99;

double m_per_min(Feed feed) {
  return feed.in_mm_s() * 60 / 1000;
}

/// Every number has a point: without one it would count steps of the last digit.
char* write_with_point(char* at, double value, int n_decimals) {
  char* end = write_fixed(at, value, n_decimals);
  if (std::find(at, end, '.') == end) *end++ = '.';
  return end;
}

std::string number_text(double value, int n_decimals) {
  std::array<char, kFixedChars + 1> chars;
  return {chars.data(), write_with_point(chars.data(), value, n_decimals)};
}

template <class T>
bool differs_from_before(const std::optional<T>& now, const std::optional<T>& before) {
  return now && before && *now != *before;
}

template <class T>
void fill_unknown(std::optional<T>& known, const std::optional<T>& said) {
  if (!known) known = said;
}

}  // namespace

SiebMeyerWriter::Steps SiebMeyerWriter::steps(const Eigen::Vector2d& at_mm) const {
  constexpr double kPerMm = 1e6;  // kMmDecimals
  const Eigen::Vector2d written = written_from_work() * at_mm * kPerMm;
  return {std::llround(written.x()), std::llround(written.y())};
}

void SiebMeyerWriter::append_number(double value, int n_decimals) {
  line_ += number_text(value, n_decimals);
}

std::string SiebMeyerWriter::plane_text(Length height) {
  return number_text(height.in_mm(), kMmDecimals);
}

void SiebMeyerWriter::append_point(const Eigen::Vector2d& at_mm,
                                   std::string_view letters,
                                   int n_decimals) {
  const Eigen::Vector2d written = written_from_work() * at_mm;
  std::array<char, 2 * (kFixedChars + 2)> chars;
  char* end = chars.data();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    *end++ = letters[axis];
    end = write_with_point(end, written[static_cast<Eigen::Index>(axis)], n_decimals);
  }
  line_.append(chars.data(), static_cast<std::size_t>(end - chars.data()));
}

/// A line that works at a place; the tool that is to do it is changed in the same line.
void SiebMeyerWriter::open_line(const Eigen::Vector2d& at_mm) {
  finish_line();
  append_point(at_mm, "XY", kMmDecimals);
  if (pending_tool_) line_ += fmt::format("T{}", *std::exchange(pending_tool_, std::nullopt));
  up_at_.reset();
  at_mm_ = at_mm;
}

void SiebMeyerWriter::tool_up_line(const Eigen::Vector2d& at_mm) {
  open_line(at_mm);
  line_ += "T0";
  is_tool_up_line_ = true;
  ends_contour_ = false;
  up_at_ = steps(at_mm);
  told_side_ = CompensationSide::Off;
}

void SiebMeyerWriter::finish_line() {
  is_tool_up_line_ = false;
  if (line_.empty()) return;
  if (line_.size() > kMaxLineCharacters) {
    refuse(
        fmt::format("a line of more than {} characters ({})", kMaxLineCharacters, quoted(line_)));
  }
  text() += line_;
  text() += '\n';
  line_.clear();
}

void SiebMeyerWriter::line(std::string_view text) {
  finish_line();
  line_ = text;
  finish_line();
}

/// The tool must not wait for the next coordinate, which belongs to something that is repeated.
void SiebMeyerWriter::say_tool() {
  if (pending_tool_) line(fmt::format("T{}", *std::exchange(pending_tool_, std::nullopt)));
}

/// The feed of a program that sets none is known in Excellon; here it is the machine maker's.
void SiebMeyerWriter::say_feed(const Rout& rout) {
  if (rout.feed_is_default && !is_foreign()) {
    if (feed_) lose_once("the default routing feed, after another one was set");
    return;
  }
  std::string wanted = number_text(m_per_min(rout.feed), kMmDecimals);
  if (feed_ == wanted) return;
  line_ += 'F';
  line_ += wanted;
  feed_ = std::move(wanted);
}

/// The control takes a leading ! or &P for an order of its own.
/// Source SIEB & MEYER CNC 8x.00 Command Set, M47
void SiebMeyerWriter::message(std::string_view text) {
  constexpr std::string_view kCommand = "M47,";
  constexpr std::size_t kMost = kMaxLineCharacters - kCommand.size();
  std::string shown = printable(text);
  if (is_foreign() && (shown.starts_with('!') || shown.starts_with("&P"))) shown.insert(0, "- ");
  do {
    const std::string part = shown.substr(0, kMost);
    shown.erase(0, part.size());
    line(std::string(kCommand) + part);
  } while (!shown.empty());
}

// --- tools -------------------------------------------------------------------------------------

/// The $ table has one set of data for the whole program.
void SiebMeyerWriter::note_tool(const Tool& tool) {
  if (tool.number > kMostTools) {
    refuse(fmt::format("tool {}", tool.number), "tools 1 to 99");
    return;
  }
  Tool& known = tools_[tool.number];
  if (used_tools_.insert(tool.number).second) {
    known = tool;
    return;
  }
  if (differs_from_before(tool.diameter, known.diameter) ||
      differs_from_before(tool.depth_offset, known.depth_offset)) {
    refuse(fmt::format("tool {} with another diameter or depth offset than before", tool.number),
           "one set of data for the tool");
  } else if (differs_from_before(tool.infeed, known.infeed) ||
             differs_from_before(tool.retract, known.retract) ||
             differs_from_before(tool.speed, known.speed) ||
             differs_from_before(tool.max_hits, known.max_hits)) {
    lose(fmt::format("another rate or hit count of tool {} than before", tool.number));
  }
  fill_unknown(known.diameter, tool.diameter);
  fill_unknown(known.infeed, tool.infeed);
  fill_unknown(known.retract, tool.retract);
  fill_unknown(known.speed, tool.speed);
  fill_unknown(known.max_hits, tool.max_hits);
  fill_unknown(known.depth_offset, tool.depth_offset);
}

void SiebMeyerWriter::write_tool_table() {
  std::erase_if(tools_, [](const auto& tool) { return tool.first < 1 || tool.first > kMostTools; });
  if (tools_.empty()) return;
  line("$");
  const auto put = [this](char letter, double value) {
    line_ += letter;
    append_number(value);
  };
  for (const auto& [number, tool] : tools_) {
    finish_line();
    line_ = fmt::format("T{}", number);
    if (tool.diameter) put('D', tool.diameter->in_mm());
    if (tool.speed) put('S', tool.speed->in_rpm() / 1000);
    if (tool.infeed) put('F', m_per_min(*tool.infeed));
    if (tool.retract) put('R', m_per_min(*tool.retract));
    if (tool.max_hits) line_ += fmt::format("N{}", *tool.max_hits);
    if (tool.depth_offset) put('Z', tool.depth_offset->in_mm());
  }
  line("$");
}

}  // namespace panelcal
