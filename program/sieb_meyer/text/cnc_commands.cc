// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/cnc_commands.h"

#include <charconv>
#include <cmath>
#include <cstddef>

#include "program/text/number_format.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

constexpr auto kTable = std::to_array<CncInfo>({
#define SIEB_MEYER_CNC(name, text, treatment, numbers, effect) \
  {CncCode::name, text, Treatment::treatment, CncNumbers::numbers, effect},
#include "program/sieb_meyer/text/cnc_commands.def"
});

/// A name ends before what is no letter, or before a coordinate; those that are the machine's own
/// affair also before a list of tools (CHEKT1T2).
bool ends_name(std::string_view rest, Treatment treatment) {
  if (rest.empty()) return true;
  const char c = rest.front();
  const bool is_letter = c >= 'A' && c <= 'Z';
  return !is_letter || c == 'X' || c == 'Y' || (c == 'T' && treatment == Treatment::Passed);
}

/// Check holes are at places, but for a list of tools.
CncNumbers numbers_of(const CncCommand& command) {
  const bool lists_tools =
      command.info->code == CncCode::CheckHoles &&
      command.argument.find_first_not_of("T0123456789") == std::string_view::npos;
  return lists_tools ? CncNumbers::NoLengths : command.info->numbers;
}

/// The double of a product of decimals may lie a hair below the decimal that is meant.
double rounded_down(double value, int n_decimals) {
  constexpr double kHair = 1e-6;  // of a step
  const double steps = std::pow(10, n_decimals);
  return std::floor(value * steps + kHair) / steps;
}

}  // namespace

std::string_view name(Treatment treatment) {
  constexpr std::array<std::string_view, 3> kNames = {"obeyed", "passed on", "refused"};
  return kNames[static_cast<std::size_t>(treatment)];
}

std::span<const CncInfo> cnc_table() {
  return kTable;
}

std::optional<CncCommand> find_cnc_command(std::string_view text) {
  const CncInfo* best = nullptr;
  for (const CncInfo& row : kTable) {
    if (!text.starts_with(row.name)) continue;
    if (!ends_name(text.substr(row.name.size()), row.treatment)) continue;
    if (best == nullptr || row.name.size() > best->name.size()) best = &row;
  }
  if (best == nullptr) return std::nullopt;
  std::string_view argument = text.substr(best->name.size());
  if (!argument.empty() && argument.front() == ',') argument.remove_prefix(1);
  return CncCommand{best, argument};
}

bool states_lengths(const CncCommand& command) {
  const CncNumbers numbers = numbers_of(command);
  return numbers == CncNumbers::Length || numbers == CncNumbers::Tolerance ||
         numbers == CncNumbers::Place;
}

std::optional<std::string> command_in_mm(std::string_view text, Length unit, int n_decimals) {
  const auto command = find_cnc_command(text);
  const bool has_number = text.find_first_of("0123456789") != std::string_view::npos;
  const CncNumbers numbers = command ? numbers_of(*command) : CncNumbers::Undescribed;
  if (!has_number || numbers == CncNumbers::NoLengths) return std::string(text);
  const bool is_tolerance = numbers == CncNumbers::Tolerance;
  if (!is_tolerance && numbers != CncNumbers::Length) return std::nullopt;
  const std::size_t begin = text.find_first_of("+-.0123456789", command->info->name.size());
  const auto value = read_plain_number(text.substr(begin));
  if (!value || is_bare(text.substr(begin))) return std::nullopt;
  const double value_mm = *value * unit.in_mm();
  std::string number = fmt::format(
      "{:.{}f}", is_tolerance ? rounded_down(value_mm, n_decimals) : value_mm, n_decimals);
  const bool is_zero = number.find_first_of("123456789") == std::string::npos;
  if (is_zero && *value != 0) return std::nullopt;
  number.erase(number.find_last_not_of('0') + 1);
  return std::string(text.substr(0, begin)) + number;
}

std::optional<double> read_plain_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  if (text.empty() || text.find_first_not_of("-.0123456789") != std::string_view::npos) {
    return std::nullopt;
  }
  double value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::array<std::optional<double>, 2>> read_xy(std::string_view argument) {
  std::array<std::optional<double>, 2> xy;
  while (!argument.empty()) {
    const char letter = argument.front();
    if (letter != 'X' && letter != 'Y') return std::nullopt;
    argument.remove_prefix(1);
    const auto end = argument.find_first_of("XY");
    const std::string_view number = argument.substr(0, end);
    argument = end == std::string_view::npos ? std::string_view() : argument.substr(end);
    const auto value = number.empty() ? std::optional(0.0) : read_plain_number(number);
    if (!value) return std::nullopt;
    xy[letter == 'X' ? 0 : 1] = value;
  }
  return xy;
}

}  // namespace panelcal::sieb_meyer
