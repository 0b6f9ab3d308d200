// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

namespace panelcal::sieb_meyer {
namespace {

class OrderReader {
 public:
  OrderReader(const Block& block, const OrderContext& context, const Reporter& reporter)
      : block_(block), context_(context), reporter_(reporter) {}

  std::optional<Order> read() {
    choose_parameters();
    for (i_word_ = 0; i_word_ < block_.n_words && is_good_; ++i_word_) {
      const Word& word = block_.words[i_word_];
      if (word.letter == 'G' || word.letter == 'M') {
        read_code(word);
      } else {
        read_letter(word);
      }
    }
    if (!is_good_) return std::nullopt;
    return std::move(order_);
  }

 private:
  void refuse(Code code, const Word& word, std::string expected) {
    reporter_.report(code, block_.in(word), std::move(expected));
    is_good_ = false;
  }

  /// I and J are side lengths and centres of contours, or numbers of peck drilling: the manual
  /// keeps them apart as two sets of variables.
  void choose_parameters() {
    bool routs = context_.is_routing;
    for (const Word& word : block_.all()) {
      if (word.letter == 'T' && parse_count(word.number) == 0) routs = true;
      if (word.letter != 'G') continue;
      const auto command = command_of(word);
      if (command == Command::PeckOn) order_.parameters = ParameterKind::Peck;
      if (command == Command::PulseOn) order_.parameters = ParameterKind::Pulse;
      if (command && (is_routing(*command) || *command == Command::NibbleCircle)) routs = true;
    }
    if (order_.parameters != ParameterKind::Rout || routs) return;
    if (context_.is_pecking) order_.parameters = ParameterKind::Peck;
    if (context_.is_pulsing) order_.parameters = ParameterKind::Pulse;
  }

  template <class T, class V>
  void set(std::optional<T>& to, V value, const Word& word) {
    if (to) {
      reporter_.report(Code::WordRepeated, block_.in(word), "each once in a line");
    }
    to = value;
  }

  std::optional<ParsedNumber> number(const Word& word, Quantity quantity) {
    const ParsedNumber parsed = parse_number(word.number, context_.format, quantity);
    if (parsed.problem == NumberProblem::None) return parsed;
    const Code code = is_open(parsed.problem) ? Code::FormatAmbiguous : Code::NumberMalformed;
    refuse(code, word, expectation(parsed.problem, context_.format, quantity));
    return std::nullopt;
  }

  void value(const Word& word, Quantity quantity, std::optional<double>& to) {
    if (const auto parsed = number(word, quantity)) set(to, parsed->value, word);
  }

  /// Of coordinates, or of radii and centres, with the rounding that they were written with.
  void length(const Word& word, Quantity quantity, std::optional<double>& to, double& step_mm) {
    const auto parsed = number(word, quantity);
    if (!parsed) return;
    constexpr double kFarthest_mm = 1e5;  // no machine is 100 m long
    if (std::abs(parsed->value) > kFarthest_mm) {
      return refuse(Code::NumberTooLong, word, "a length below 100 m");
    }
    set(to, parsed->value, word);
    if (parsed->step <= step_mm) return;
    step_mm = std::max(step_mm, std::min(parsed->step, context_.format.step_mm()));
  }

  bool exists(const Word& word, std::string_view formats) {
    if (formats.find(name(context_.format.file).front()) != std::string_view::npos) return true;
    refuse(Code::CommandFormat,
           word,
           "a command of format " + std::string(name(context_.format.file)));
    return false;
  }

  void read_letter(const Word& word) {
    switch (word.letter) {
      case 'X':
        return length(word, Quantity::Coordinate, order_.xy_mm[0], order_.xy_step_mm);
      case 'Y':
        return length(word, Quantity::Coordinate, order_.xy_mm[1], order_.xy_step_mm);
      case 'T':
        return read_tool(word);
      case 'V':
        return read_pattern(word);
      case 'W':
        return read_w(word);
      case 'R':
        if (!exists(word, "35")) return;
        if (order_.parameters == ParameterKind::Peck) {
          return refuse(Code::ArgumentInvalid, word, "I, P, J and W with G81");
        }
        if (order_.parameters == ParameterKind::Rout) order_.ij_mm = {};
        return length(word, parameter(), order_.r_mm, order_.parameter_step_mm);
      case 'I':
        if (order_.parameters == ParameterKind::Rout) order_.r_mm.reset();
        return length(word, parameter(), order_.ij_mm[0], order_.parameter_step_mm);
      case 'J':
        if (order_.parameters == ParameterKind::Rout) order_.r_mm.reset();
        return length(word, parameter(), order_.ij_mm[1], order_.parameter_step_mm);
      case 'F':
        value(word, Quantity::RoutFeed, order_.feed_m_min);
        if (order_.feed_m_min == 0.0) refuse(Code::ArgumentInvalid, word, "a feed above zero");
        return;
      case 'D':
        return read_d(word);
      case 'H':
        if (exists(word, "35")) value(word, Quantity::Plane, order_.h_mm);
        return;
      case 'K':
        if (exists(word, "35")) value(word, Quantity::Plane, order_.k_mm);
        return;
      case 'Z':
        if (exists(word, "35")) value(word, Quantity::Plane, order_.z_mm);
        return;
      case 'P':
        if (exists(word, "5")) value(word, Quantity::Percent, order_.percent);
        return;
      case 'E':
        if (exists(word, "5")) value(word, Quantity::Milliseconds, order_.dwell_ms);
        return;
      case 'L':
        if (exists(word, "5")) count(word, order_.memory, 0, "L# with a place of the memory");
        return;
      default:
        return refuse(
            Code::CommandUnknown, word, "a command that `panelcal help sieb-meyer` lists");
    }
  }

  Quantity parameter() const {
    return order_.parameters == ParameterKind::Rout ? Quantity::ArcParameter : Quantity::PeckLength;
  }

  void count(const Word& word, std::optional<int>& to, int least, const char* expected) {
    const auto n = parse_count(word.number);
    if (!n || *n < least) return refuse(Code::ArgumentInvalid, word, expected);
    set(to, *n, word);
  }

  void read_tool(const Word& word) {
    const bool has_next = i_word_ + 1 < block_.n_words;
    if (word.number.empty() && has_next && block_.words[i_word_ + 1].letter == 'D' &&
        block_.words[i_word_ + 1].number.empty()) {
      ++i_word_;
      order_.is_dummy_tool = true;
      return;
    }
    const auto n = parse_count(word.number);
    if (!n || *n > 99) return refuse(Code::ArgumentInvalid, word, "T1 to T99, or T0");
    if (*n == 0) {
      order_.is_tool_up = true;
    } else {
      set(order_.tool, *n, word);
    }
  }

  void read_pattern(const Word& word) {
    if (!exists(word, word.number == "1" || word.number == "2" ? "135" : "5")) return;
    const auto n = parse_count(word.number);
    if (!n || *n < 1 || *n > 4) return refuse(Code::ArgumentInvalid, word, "V1, V2, V3 or V4");
    set(order_.v, *n, word);
  }

  void read_w(const Word& word) {
    if (context_.expects_count) {
      return count(word, order_.count, 1, "W# with the number of holes");
    }
    if (order_.parameters == ParameterKind::Peck) {
      return value(word, Quantity::PerMille, order_.permille);
    }
    refuse(Code::ArgumentInvalid, word, "W# behind V1 to V4, with M50, or with G81");
  }

  /// D of a forbidden area may be as large as one likes.
  void read_d(const Word& word) {
    if (exists(word, "35")) value(word, Quantity::ArcParameter, order_.rounding_mm);
  }

  void read_code(const Word& word) {
    const auto found = command_of(word);
    if (!found)
      return refuse(Code::CommandUnknown, word, "a code that `panelcal help sieb-meyer` lists");
    if (!exists(word, info(*found).formats)) return;
    const bool is_last = i_word_ + 1 == block_.n_words;
    if (is_camera(*found) && !is_last) {
      return refuse(
          Code::CameraNotLast, block_.words[i_word_ + 1], code_text(*found) + " last in its line");
    }
    take(word, *found);
  }

  void take_text(const Word& word, Command command) {
    if (block_.argument.empty()) {
      return refuse(Code::ArgumentInvalid, word, code_text(command) + ",text");
    }
    order_.text = command;
  }

  void switch_slm(const Word& word, bool is_on) {
    order_.suspends_depth_control = false;
    set(order_.slm, is_on, word);
  }

  void switch_depth_control(const Word& word, bool is_on) {
    order_.suspends_depth_control = !is_on;
    set(order_.depth_control, is_on, word);
  }

  /// commands.def has the meaning of each.
  void take(const Word& word, Command command) {
    switch (command) {
#define SIEB_MEYER_COMMAND(                                                        \
    name, letter, number, kind, operands, formats, section, effect, test, meaning) \
  case Command::name:                                                              \
    meaning;                                                                       \
    return;
#include "program/sieb_meyer/text/commands.def"
    }
  }

  const Block& block_;
  const OrderContext& context_;
  const Reporter& reporter_;
  Order order_;
  std::size_t i_word_ = 0;
  bool is_good_ = true;
};

}  // namespace

std::uint32_t parts_of(const Order& order) {
  std::uint32_t parts = 0;
  const auto add = [&parts](bool has, Part part) { parts |= has ? part : 0U; };
  add(order.has_xy(), kXy);
  add(order.motion.has_value(), kMotion);
  add(order.nibble.has_value(), kNibble);
  add(order.camera.has_value(), kCamera);
  add(order.surface.has_value(), kSurface);
  add(order.area.has_value(), kArea);
  add(order.v.has_value(), kPattern);
  add(order.memory.has_value(), kMemory);
  add(order.count.has_value(), kCount);
  add(order.is_tool_up, kToolUp);
  add(order.is_dummy_tool, kDummyTool);
  add(order.side.has_value(), kSide);
  add(order.is_ramp, kRamp);
  add(order.clears_area, kCutArea);
  add(order.finishes, kFinish);
  add(order.rounding_mm.has_value(), kRounding);
  add(order.parameters == ParameterKind::Rout && (order.r_mm || order.ij_mm[0] || order.ij_mm[1]),
      kParameters);
  add(order.text.has_value(), kText);
  return parts;
}

std::string_view form_of(std::uint32_t part) {
  constexpr std::array<std::string_view, 18> kForms = {"X# Y#",
                                                       "G1 to G50",
                                                       "G84 and G85",
                                                       "G30 to G36",
                                                       "G72 to G79",
                                                       "M56 to M58",
                                                       "V#",
                                                       "L#",
                                                       "W#",
                                                       "T0",
                                                       "TD",
                                                       "G40 to G42",
                                                       "G6",
                                                       "G43",
                                                       "G11",
                                                       "D#",
                                                       "R#, I# and J#",
                                                       "a text"};
  return kForms.at(static_cast<std::size_t>(std::countr_zero(part)));
}

std::optional<Order> read_order(const Block& block,
                                const OrderContext& context,
                                const Reporter& reporter) {
  return OrderReader(block, context, reporter).read();
}

}  // namespace panelcal::sieb_meyer
