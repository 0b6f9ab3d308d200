// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/commands/command_probe.h"

#include <optional>
#include <string>
#include <string_view>

#include "machine/devices/commands/external_program.h"

namespace panelcal {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

std::string_view trimmed_blanks(std::string_view text) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

/// "1.6012" or "1.6012 0.003"
std::optional<HeightEstimate> parse_height(std::string_view text) {
  const auto height_mm = internal::take_number(text);
  if (!height_mm) return std::nullopt;
  if (text.empty()) return HeightEstimate{mm(*height_mm), Length()};
  const auto sigma_mm = internal::take_number(text);
  if (!sigma_mm || *sigma_mm < 0 || !text.empty()) return std::nullopt;
  return HeightEstimate{mm(*height_mm), mm(*sigma_mm)};
}

}  // namespace

Expected<ProbeReading> CommandProbe::probe(const ProbeRequest& request) {
  const Eigen::Vector2d place_mm = request.expected_in_machine().in_mm();
  const CommandWords words = internal::filled(
      commands_.probe,
      {{"{x}", internal::place_text(place_mm.x())}, {"{y}", internal::place_text(place_mm.y())}});
  PANELCAL_TRY(const std::string answer, internal::run_program(words, commands_.limit));
  const std::string_view said = trimmed_blanks(answer);
  if (said == "none") {
    return ProbeReading{request, ProbeStatus::NotFound, {}, "nothing was touched"};
  }
  if (const auto height = parse_height(said)) {
    return ProbeReading{request, ProbeStatus::Found, {*height}, {}};
  }
  return failure({Code::DeviceStage,
                  {words.front(), 0, 0},
                  "answers " + quoted(answer),
                  "the height in mm, perhaps with its sigma, or none"});
}

}  // namespace panelcal
