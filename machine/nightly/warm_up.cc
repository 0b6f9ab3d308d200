// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/machine/external_program.h"
#include "panelcal/machine/nightly/self_test.h"

namespace panelcal {
namespace {

/// Between two moves, so that the machine is moved and not hurried.
constexpr Time kPause = seconds(5);

/// Two places, far apart, that the stage can certainly reach.
Expected<std::array<Position<frame::Machine>, 2>> ends_of(const MachineConfig& config,
                                                          const NightlyConfig& nightly) {
  if (config.travel) {
    const Displacement<frame::Machine> way = config.travel->high - config.travel->low;
    return std::array{config.travel->low + 0.25 * way, config.travel->low + 0.75 * way};
  }
  if (config.coupon) {
    const auto places = places_of_row(*config.coupon, 0);
    return std::array{places.front(), places.back()};
  }
  return failure({Code::ConfigValue,
                  nightly.place,
                  "[nightly] warm_up_s is given, and nothing says where the stage may move",
                  "[machine] travel_low_mm and travel_high_mm"});
}

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

Expected<Time> warm_up(const MachineConfig& config,
                       const NightlyConfig& nightly,
                       const CalibrationDevices& devices,
                       const Clock& clock) {
  if (!(nightly.warm_up > seconds(0))) return seconds(0);
  PANELCAL_TRY(const auto ends, ends_of(config, nightly));
  const std::chrono::sys_seconds started = clock();
  const auto n_moves = static_cast<long>(std::ceil(nightly.warm_up.in_s() / kPause.in_s()));
  double waited_s = 0;
  for (long i = 0; i < n_moves; ++i) {
    const double passed_s = static_cast<double>((clock() - started).count());
    if (passed_s >= nightly.warm_up.in_s()) break;
    PANELCAL_CHECK(devices.stage.move_to(ends[static_cast<std::size_t>(i % 2)]));
    const double pause_s = std::min(kPause.in_s(), nightly.warm_up.in_s() - waited_s);
    if (devices.wait) devices.wait(seconds(pause_s));
    waited_s += pause_s;
  }
  const double passed_s = static_cast<double>((clock() - started).count());
  return seconds(std::max(passed_s, devices.wait ? waited_s : 0.0));
}

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
