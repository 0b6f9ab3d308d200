// SPDX-License-Identifier: Apache-2.0
// Lines of format 5000: coordinates, tools, feeds, texts and the $ table.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "program/sieb_meyer/figures/drill_patterns.h"
#include "program/writers/fixed_point.h"
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
  constexpr int kUsualDecimals = 3;
  if (n_decimals == kUsualDecimals) return write_fixed_as<kUsualDecimals>(at, value, ".");
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

}  // namespace

/// Source SIEB & MEYER CNC 8x.00 Command Set, M49 ("remain active after the execution is
/// finished"); M99, the subprogram RESET
void SiebMeyerWriter::state_control(int axis_version) {
  states_control_ = true;
  write_in_axes(axis_version);
  line(fmt::format("M49,FV{}", axis_version));
  // Slots (G85) are drilled as `run` lists them, whatever the control was left with.
  const std::string roughness =
      number_text(sieb_meyer::Nibbling{}.roughness_mm, digits().n_decimals);
  nibbling_ = {"M49,NONIBO", "M49,NIB" + roughness};
  for (const std::string& command : nibbling_) line(command);
  line("M49,NORA");
  line("M49,NOSA");
}

SiebMeyerWriter::Steps SiebMeyerWriter::steps(const Eigen::Vector2d& at_mm) const {
  const Eigen::Vector2d written = written_from_work() * at_mm / digits().step().in_mm();
  return {std::llround(written.x()), std::llround(written.y())};
}

void SiebMeyerWriter::append_number(double value) {
  const std::string text = number_text(value, digits().n_decimals);
  check_digits(text);
  line_ += text;
}

std::string SiebMeyerWriter::plane_text(Length height) const {
  return number_text(height.in_mm(), digits().n_decimals);
}

void SiebMeyerWriter::append_point(const Eigen::Vector2d& at_mm,
                                   std::string_view letters,
                                   int n_decimals) {
  const Eigen::Vector2d written = written_from_work() * at_mm;
  std::array<char, 2 * (kFixedChars + 2)> chars;
  char* end = chars.data();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    *end++ = letters[axis];
    const char* const begin = end;
    end = write_with_point(end, written[static_cast<Eigen::Index>(axis)], n_decimals);
    check_digits({begin, static_cast<std::size_t>(end - begin)});
  }
  line_.append(chars.data(), static_cast<std::size_t>(end - chars.data()));
}

/// A line that works at a place; the tool that is to do it is changed in the same line.
void SiebMeyerWriter::open_line(const Eigen::Vector2d& at_mm) {
  finish_line();
  append_point(at_mm, "XY");
  if (pending_tool_) line_ += fmt::format("T{}", *std::exchange(pending_tool_, std::nullopt));
  if (has_place_words()) say_place_words();
  line_source_.number = source_line();
  if (line_source_.file != source_file()) line_source_.file = source_file();
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

// --- words for a place -------------------------------------------------------------------------

SiebMeyerWriter::PlaceWords& SiebMeyerWriter::place_words() {
  if (!is_of(place_words_.line)) {
    settle_place_words();
    place_words_.line = {source_line(), std::string(source_file())};
  }
  return place_words_;
}

/// M20 stops before the coordinate of its line, M21 holds while it is executed.
/// Source SIEB & MEYER CNC 8x.00 Command Set, M20, M21
void SiebMeyerWriter::say_place_words() {
  if (std::exchange(place_words_.may_stop, false)) line_ += "M20";
  if (place_words_.has_output) line_ += "M21";
  if (place_words_.skips_grid) line_ += "G77";
  place_words_.is_said = true;
}

/// The line that they belong to is done. The cutter may have been raised at its place already.
void SiebMeyerWriter::settle_place_words() {
  const PlaceWords words = place_words_;
  const bool has_line =
      line_source_.number == words.line.number && line_source_.file == words.line.file;
  if (has_place_words() && !words.is_said && is_tool_up_line_ && has_line) {
    say_place_words();
  } else if (has_place_words()) {
    if (words.may_stop) line("M20");
    if (words.has_output && !words.is_said) lose("M21 at a place that is not worked at");
  }
  place_words_ = {};
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
  std::string wanted = number_text(m_per_min(rout.feed), digits().n_decimals);
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
  } else if (contradict(tool, known)) {
    lose(fmt::format("another rate, dwell or hit count of tool {} than before", tool.number));
  }
  fill_missing(known, tool);
  if (known.magazines.empty()) known.magazines = tool.magazines;
}

/// A letter without a number sets the control's datum to zero; one that the source leaves out stays
/// as the control has it. A file without a table would count as cut off.
/// Source SIEB & MEYER CNC 8x.00 Command Set, A.7.1, Tool Parameters
void SiebMeyerWriter::write_tool_table() {
  std::erase_if(tools_, [](const auto& tool) { return tool.first < 1 || tool.first > kMostTools; });
  line("$");
  for (const auto& [number, tool] : tools_) {
    finish_line();
    line_ = fmt::format("T{}", number);
    const auto put = [&](char letter, std::optional<double> value) {
      if (!value && tool.zeroed.find(letter) == std::string::npos) return;
      line_ += letter;
      if (value) append_number(*value);
    };
    const auto in = [](const auto& datum, auto unit) {
      return datum ? std::optional<double>(unit(*datum)) : std::nullopt;
    };
    put('D', in(tool.diameter, [](Length l) { return l.in_mm(); }));
    put('S', in(tool.speed, [](SpindleSpeed s) { return s.in_rpm() / 1000; }));
    put('F', in(tool.infeed, m_per_min));
    put('R', in(tool.retract, m_per_min));
    if (tool.max_hits) {
      line_ += fmt::format("N{}", *tool.max_hits);
    } else {
      put('N', std::nullopt);
    }
    put('A', in(tool.dwell, [](Time t) { return t.in_s(); }));
    put('Z', in(tool.depth_offset, [](Length l) { return l.in_mm(); }));
    write_magazines(tool);
  }
  line("$");
}

/// Ten in a line.
void SiebMeyerWriter::write_magazines(const Tool& tool) {
  constexpr std::size_t kInLine = 10;
  for (std::size_t i = 0; i < tool.magazines.size(); ++i) {
    if (i % kInLine == 0) finish_line();
    line_ += fmt::format("M{}", tool.magazines[i]);
  }
}

}  // namespace panelcal
