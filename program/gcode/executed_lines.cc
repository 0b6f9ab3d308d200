// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/executed_lines.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <utility>

#include "program/text/gaps.h"

namespace panelcal::gcode {
namespace {

/// More than a shift of drilling; a repetition of repetitions has it in a few lines.
constexpr long kMostLines = 1'000'000;
constexpr std::size_t kMostFrames = 100;

/// In lower case, without blanks and comments: as the control reads it.
std::string squeezed(std::string_view text) {
  std::string out;
  bool is_comment = false;
  for (const char c : text) {
    if (c == ';' && !is_comment) break;
    is_comment = is_comment || c == '(';
    if (!is_comment && !is_gap(c)) {
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    is_comment = is_comment && c != ')';
  }
  return out;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

}  // namespace

tl::unexpected<Diagnostic> ExecutedLines::problem(const SourceLine& line,
                                                  Code code,
                                                  std::string expected) const {
  const std::size_t begin = line.text.find_first_not_of(" \t");
  return failure({code,
                  {program_.file, line.number, line.column + static_cast<int>(begin)},
                  quoted(line.text.substr(begin)),
                  std::move(expected)});
}

std::optional<ExecutedLines::Order> ExecutedLines::read_order(std::string_view text) const {
  const std::string squeezed_text = squeezed(text);
  std::string_view rest = squeezed_text;
  if (rest.starts_with('/')) rest.remove_prefix(1);
  if (rest.starts_with('n')) {
    rest.remove_prefix(1);
    while (!rest.empty() && is_digit(rest.front())) rest.remove_prefix(1);
  }
  if (!rest.starts_with('o')) return std::nullopt;
  rest.remove_prefix(1);
  const std::size_t n_name =
      rest.starts_with('<')
          ? std::min(rest.find('>'), rest.size() - 1) + 1
          : static_cast<std::size_t>(std::ranges::find_if_not(rest, is_digit) - rest.begin());
  Order order;
  order.name = rest.substr(0, n_name);
  rest.remove_prefix(n_name);
  const auto n_keyword = static_cast<std::size_t>(
      std::ranges::find_if_not(rest, [](char c) { return c >= 'a' && c <= 'z'; }) - rest.begin());
  order.keyword = rest.substr(0, n_keyword);
  order.argument = rest.substr(n_keyword);
  return order;
}

Expected<std::optional<ExecutedLine>> ExecutedLines::next() {
  if (cursor_.at_end()) {
    if (frames_.empty()) return std::nullopt;
    const SourceLine last = last_line(program_.bytes);
    return failure({Code::CommandUnknown,
                    {program_.file, last.number, 1},
                    "the program ends inside o" + frames_.back().name,
                    frames_.back().is_call ? "endsub before it" : "endrepeat before it"});
  }
  const bool is_inside =
      std::ranges::any_of(frames_, [](const Frame& frame) { return frame.is_call; });
  const SourceLine line = cursor_.next();
  if (++n_lines_ > kMostLines) {
    return problem(line, Code::NotSupported, "at most 1,000,000 lines as they are executed");
  }
  const std::optional<Order> order = read_order(line.text);
  if (order) PANELCAL_CHECK(obey(line, *order));
  return ExecutedLine{line, order.has_value(), is_inside};
}

Expected<void> ExecutedLines::obey(const SourceLine& line, const Order& order) {
  const std::size_t slash = line.text.find_first_not_of(" \t");
  const bool takes_argument = order.keyword == "repeat";
  if (order.name.empty() || line.text[slash] == '/' ||
      (!takes_argument && !order.argument.empty())) {
    return problem(line,
                   Code::NotSupported,
                   "o#, a number or <name>, sub, call, return or repeat, without arguments");
  }
  if (order.keyword == "sub") return define(line, order);
  if (order.keyword == "call") return call(line, order);
  if (order.keyword == "endsub" || order.keyword == "return") return return_from(line, order);
  if (order.keyword == "repeat") return repeat(line, order);
  if (order.keyword == "endrepeat") return repeat_again(line, order);
  return problem(line,
                 Code::NotSupported,
                 "sub, call, return or repeat: what else the program does depends on variables");
}

Expected<void> ExecutedLines::define(const SourceLine& line, const Order& order) {
  if (!frames_.empty()) {
    return problem(line, Code::NotSupported, "a subprogram outside of others");
  }
  subprograms_[order.name] = cursor_.place();
  return skip_to(line, order, "endsub");
}

Expected<void> ExecutedLines::call(const SourceLine& line, const Order& order) {
  const auto found = subprograms_.find(order.name);
  if (found == subprograms_.end()) {
    return problem(line, Code::NotSupported, "a subprogram that stands above in this file");
  }
  for (const Frame& frame : frames_) {
    if (frame.is_call && frame.name == order.name) {
      return problem(line, Code::SubprogramRecursive, "a subprogram that does not call itself");
    }
  }
  frames_.push_back({.name = order.name, .is_call = true, .back = cursor_.place()});
  cursor_ = LineCursor(program_.bytes, found->second);
  return {};
}

/// `return` also leaves repetitions.
Expected<void> ExecutedLines::return_from(const SourceLine& line, const Order& order) {
  while (!frames_.empty() && !frames_.back().is_call && order.keyword == "return") {
    frames_.pop_back();
  }
  if (frames_.empty() || !frames_.back().is_call || frames_.back().name != order.name) {
    return problem(line, Code::CommandUnknown, order.keyword + " of the subprogram that it is in");
  }
  cursor_ = LineCursor(program_.bytes, frames_.back().back);
  frames_.pop_back();
  return {};
}

Expected<void> ExecutedLines::repeat(const SourceLine& line, const Order& order) {
  std::string_view argument = order.argument;
  long n_times = -1;
  if (argument.starts_with('[') && argument.ends_with(']')) {
    argument = argument.substr(1, argument.size() - 2);
    const auto [end, error] =
        std::from_chars(argument.data(), argument.data() + argument.size(), n_times);
    if (error != std::errc() || end != argument.data() + argument.size()) n_times = -1;
  }
  if (n_times < 0) return problem(line, Code::NotSupported, "repeat [#], a number as it is");
  if (frames_.size() == kMostFrames) {
    return problem(line, Code::NotSupported, "at most 100 repetitions inside each other");
  }
  if (n_times == 0) return skip_to(line, order, "endrepeat");
  frames_.push_back(
      {.name = order.name, .is_call = false, .back = cursor_.place(), .n_further = n_times - 1});
  return {};
}

Expected<void> ExecutedLines::repeat_again(const SourceLine& line, const Order& order) {
  if (frames_.empty() || frames_.back().is_call || frames_.back().name != order.name) {
    return problem(line, Code::CommandUnknown, "endrepeat of the repetition that it is in");
  }
  Frame& frame = frames_.back();
  if (frame.n_further > 0) {
    --frame.n_further;
    cursor_ = LineCursor(program_.bytes, frame.back);
  } else {
    frames_.pop_back();
  }
  return {};
}

Expected<void> ExecutedLines::skip_to(const SourceLine& line,
                                      const Order& order,
                                      std::string_view keyword) {
  while (!cursor_.at_end()) {
    const std::optional<Order> found = read_order(cursor_.next().text);
    if (found && found->name == order.name && found->keyword == keyword) return {};
  }
  return problem(line, Code::CommandUnknown, std::string(keyword) + " below it");
}

}  // namespace panelcal::gcode
