// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <string_view>
#include <system_error>

#include "calib/base/files/atomic_file.h"
#include "machine/devices/commands/external_program.h"
#include "machine/nightly/checks/self_test.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::optional<double> number_in(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return std::nullopt;
  text = text.substr(first, text.find_last_not_of(kSpace) - first + 1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

Expected<std::optional<double>> read_temperature(const NightlyConfig& nightly) {
  constexpr std::size_t kMostBytes = 4096;
  std::optional<double> none;
  std::string text;
  if (!nightly.temperature_file.empty()) {
    PANELCAL_TRY(text, read_file(nightly.temperature_file, kMostBytes));
  } else if (!nightly.temperature_command.empty()) {
    PANELCAL_TRY(text, internal::run_program(nightly.temperature_command, seconds(30)));
  } else {
    return none;
  }
  constexpr double kColdest = -50;
  constexpr double kHottest = 100;
  const std::optional<double> value = number_in(text);
  if (value && *value >= kColdest && *value <= kHottest) return value;
  return failure({Code::ConfigValue,
                  nightly.place,
                  "the temperature reads " + quoted(std::string_view(text)),
                  fmt::format("one number from {} to {}, in degrees Celsius", kColdest, kHottest)});
}

}  // namespace panelcal
