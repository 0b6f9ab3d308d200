// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/commands/command_stage.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "machine/devices/commands/external_program.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// No machine has axes of a kilometre: such a number is a mistake, or in another unit.
constexpr double kFarthest_mm = 1e6;

std::optional<Position<frame::Machine>> parse_place(std::string_view text) {
  const auto x_mm = internal::take_number(text);
  if (!x_mm) return std::nullopt;
  const auto y_mm = internal::take_number(text);
  if (!y_mm || !text.empty()) return std::nullopt;
  return position_mm<frame::Machine>(*x_mm, *y_mm);
}

}  // namespace

namespace internal {

std::string place_text(double v_mm) {
  std::string text = fmt::format("{:.6f}", v_mm);
  // Some controllers refuse a negative zero.
  return text == "-0.000000" ? "0.000000" : text;
}

std::optional<double> take_number(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !(std::abs(value) <= kFarthest_mm)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  const bool ends = text.empty() || std::string_view(" \t\r\n").find(text[0]) != text.npos;
  return ends ? std::optional(value) : std::nullopt;
}

CommandWords filled(CommandWords words,
                    const std::vector<std::pair<std::string_view, std::string>>& values) {
  for (std::string& word : words) {
    for (const auto& [placeholder, value] : values) {
      for (auto at = word.find(placeholder); at != std::string::npos;
           at = word.find(placeholder, at + value.size())) {
        word.replace(at, placeholder.size(), value);
      }
    }
  }
  return words;
}

}  // namespace internal

Expected<Position<frame::Machine>> CommandStage::move_to(const Position<frame::Machine>& spindle) {
  const CommandWords words = internal::filled(commands_.move,
                                              {{"{x}", internal::place_text(spindle.in_mm().x())},
                                               {"{y}", internal::place_text(spindle.in_mm().y())}});
  PANELCAL_TRY(const std::string answer, internal::run_program(words, commands_.limit));
  if (answer.empty()) return spindle;
  if (const auto place = parse_place(answer)) return *place;
  return failure({Code::DeviceStage,
                  {words.front(), 0, 0},
                  "answers " + quoted(answer),
                  "where the spindle stands, \"x y\" in mm, or nothing"});
}

const CommandWords& CommandStage::command_of(CameraSetting setting) const {
  switch (setting) {
    case CameraSetting::Lamp:
      return commands_.lamp;
    case CameraSetting::Zoom:
      return commands_.zoom;
    case CameraSetting::Focus:
      return commands_.focus;
    case CameraSetting::Exposure:
      break;
  }
  static const CommandWords kNone;  // a machine exposes nothing
  return kNone;
}

Expected<void> CommandStage::set(CameraSetting setting, double value) {
  const CommandWords& command = command_of(setting);
  if (command.empty()) return Stage::set(setting, value);
  const bool is_place = setting == CameraSetting::Focus;
  const std::string placeholder = is_place ? "{z}" : fmt::format("{{{}}}", name(setting));
  const std::string text = is_place ? internal::place_text(value) : fmt::format("{}", value);
  PANELCAL_CHECK(
      internal::run_program(internal::filled(command, {{placeholder, text}}), commands_.limit));
  return {};
}

}  // namespace panelcal
