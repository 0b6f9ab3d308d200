// SPDX-License-Identifier: Apache-2.0
#include "machine/job/text_variables.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>

#include "calib/base/clock.h"

namespace panelcal {
namespace {

/// Digits and signs only, so no locale shows.
constexpr const char* kForm = "%Y-%m-%dT%H:%M:%S";
constexpr std::size_t kLength = std::string_view("2026-11-21T13:45:00").size();

bool names_the_time(std::string_view text) {
  return text.find("&D") != std::string_view::npos || text.find("&T") != std::string_view::npos;
}

}  // namespace

Expected<std::string> wall_time(std::string_view clock,
                                std::chrono::sys_seconds now,
                                const std::string& command) {
  if (!clock.empty()) {
    // A wall has no time zone; only the form and the calendar are checked.
    if (from_iso_8601(std::string(clock) + "Z")) return std::string(clock);
    return failure({Code::Usage,
                    {command, 0, 0},
                    "--clock " + quoted(clock),
                    "a date and a time, such as 2026-11-21T13:45:00"});
  }
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  std::tm local{};
  std::array<char, kLength + 1> text{};
  if (localtime_r(&seconds, &local) == nullptr ||
      std::strftime(text.data(), text.size(), kForm, &local) != kLength) {
    return failure({Code::Usage,
                    {command, 0, 0},
                    "this computer's clock has no date of four digits for a year",
                    "--clock"});
  }
  return std::string(text.data());
}

void set_text_variables(std::string_view path,
                        std::string_view time,
                        sieb_meyer::TextVariables& text) {
  const auto part = [&](std::size_t at, std::size_t n) { return std::string(time.substr(at, n)); };
  text.date = part(8, 2) + "/" + part(5, 2) + "/" + part(0, 4);
  text.time = part(11, 8);
  if (path == "-") return;
  const std::filesystem::path file(path);
  text.file = file.stem().string();
  text.extension = file.extension().string();
  if (!text.extension.empty()) text.extension.erase(0, 1);
}

bool drills_the_time(const Program& program) {
  if (program.dialect != Dialect::SiebMeyer) return false;
  return names_the_time(program.source.bytes) ||
         std::ranges::any_of(program.patterns,
                             [](const auto& named) { return names_the_time(named.second.bytes); });
}

}  // namespace panelcal
