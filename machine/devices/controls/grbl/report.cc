// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/grbl/report.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>

namespace panelcal::grbl {
namespace {

/// No machine has axes of a kilometre.
constexpr double kFarthest = 1e6;

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(at);
    parts.push_back(text.substr(0, end));
    if (end == text.npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return std::abs(value) <= kFarthest ? std::optional(value) : std::nullopt;
}

/// The first three axes; further ones are no concern of ours.
std::optional<Eigen::Vector3d> axes(std::string_view text) {
  const auto parts = split(text, ',');
  if (parts.size() < 3) return std::nullopt;
  Eigen::Vector3d values;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto value = number(parts[static_cast<std::size_t>(i)]);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return values;
}

/// The text between two ends; empty: they are not there.
std::optional<std::string_view> between(std::string_view line,
                                        std::string_view begin,
                                        std::string_view end) {
  if (line.size() < begin.size() + end.size() || !line.starts_with(begin) || !line.ends_with(end)) {
    return std::nullopt;
  }
  return line.substr(begin.size(), line.size() - begin.size() - end.size());
}

bool is_state(std::string_view text) {
  return !text.empty() && text.size() < 20 && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ':';
  });
}

/// Puts one value of a report; false: it is damaged.
bool take_value(std::string_view key, std::string_view value, Report& report) {
  if (key == "MPos") return (report.machine = axes(value)).has_value();
  if (key == "WPos") return (report.work = axes(value)).has_value();
  if (key == "WCO") return (report.offset = axes(value)).has_value();
  if (key == "Pn") {
    report.is_probe_tripped = value.find('P') != value.npos;
    report.is_probe_known = value.find('O') == value.npos;
  }
  if (key == "H") report.is_homed = value.starts_with('1');
  return true;
}

}  // namespace

std::optional<Report> parse_report(std::string_view line) {
  const auto inside = between(line, "<", ">");
  if (!inside) return std::nullopt;
  const auto parts = split(*inside, '|');
  if (!is_state(parts.front())) return std::nullopt;
  Report report;
  report.state = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const std::size_t colon = std::min(parts[i].find(':'), parts[i].size());
    const std::string_view value = parts[i].substr(std::min(colon + 1, parts[i].size()));
    if (!take_value(parts[i].substr(0, colon), value, report)) return std::nullopt;
  }
  if (!report.machine && !report.work) return std::nullopt;
  return report;
}

std::optional<Touch> parse_touch(std::string_view line) {
  const auto inside = between(line, "[PRB:", "]");
  if (!inside) return std::nullopt;
  const auto parts = split(*inside, ':');
  const auto place = axes(parts.front());
  if (!place || parts.size() != 2 || (parts[1] != "0" && parts[1] != "1")) return std::nullopt;
  return Touch{*place, parts[1] == "1"};
}

std::optional<double> Facts::setting(int number) const {
  const auto found = settings.find(number);
  return found == settings.end() ? std::nullopt : std::optional(found->second);
}

bool Facts::has_mode(std::string_view mode) const {
  return std::ranges::find(modes, mode) != modes.end();
}

void take_identity(const std::vector<std::string>& lines, Facts& facts) {
  std::string version;
  for (const std::string& line : lines) {
    if (const auto text = between(line, "[VER:", "]")) {
      version = text->substr(0, text->find(':'));
      if (const auto at = version.find("FluidNC "); at != version.npos) {
        facts.firmware = Firmware::FluidNc;
        version = version.substr(at + 8);
      }
    } else if (line == "[FIRMWARE:grblHAL]") {
      facts.firmware = Firmware::GrblHal;
    } else if (const auto options = between(line, "[OPT:", "]")) {
      facts.has_forced_origin = options->substr(0, options->find(',')).find('Z') != options->npos;
    }
  }
  const std::string_view kind = facts.firmware == Firmware::Grbl      ? "GRBL "
                                : facts.firmware == Firmware::GrblHal ? "grblHAL "
                                                                      : "FluidNC ";
  facts.name = std::string(kind) + version;
}

void take_settings(const std::vector<std::string>& lines, Facts& facts) {
  for (const std::string& line : lines) {
    if (!line.starts_with('$')) continue;
    const std::string_view text = std::string_view(line).substr(1);
    const std::size_t equals = text.find('=');
    if (equals == text.npos) continue;
    const auto key = number(text.substr(0, equals));
    // GRBL 0.9 and some others write "$13=0 (report inches, bool)".
    const std::string_view value = text.substr(equals + 1);
    const auto stated = number(value.substr(0, value.find(' ')));
    if (key && stated) facts.settings[static_cast<int>(*key)] = *stated;
  }
}

void take_offsets(const std::vector<std::string>& lines, Facts& facts) {
  for (const std::string& line : lines) {
    const auto inside = between(line, "[", "]");
    if (!inside) continue;
    const std::size_t colon = std::min(inside->find(':'), inside->size());
    const std::string_view key = inside->substr(0, colon);
    const bool is_offset = key.starts_with("G5") || key == "G92" || key == "TLO";
    if (!is_offset) continue;
    const auto values = split(inside->substr(std::min(colon + 1, inside->size())), ',');
    const bool is_zero = std::ranges::all_of(
        values, [](std::string_view value) { return number(value).value_or(1) == 0; });
    // A work zero counts only if it is the chosen one.
    if (is_zero || (key.starts_with("G5") && !facts.has_mode(key))) continue;
    facts.offsets.emplace_back(key == "TLO" ? std::string_view("tool length") : key);
  }
}

bool take_modes(const std::vector<std::string>& lines, Facts& facts) {
  for (const std::string& line : lines) {
    const auto inside = between(line, "[GC:", "]");
    if (!inside) continue;
    facts.modes.clear();
    for (const std::string_view word : split(*inside, ' ')) facts.modes.emplace_back(word);
    return true;
  }
  return false;
}

}  // namespace panelcal::grbl
