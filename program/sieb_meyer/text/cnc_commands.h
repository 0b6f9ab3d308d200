// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "calib/base/units.h"

namespace panelcal::sieb_meyer {

enum class CncCode : std::uint8_t {
#define SIEB_MEYER_CNC(name, ...) name,
#include "program/sieb_meyer/text/cnc_commands.def"
};

enum class Treatment : std::uint8_t { Obeyed, Passed, Refused };

std::string_view name(Treatment treatment);

/// The numbers behind the name of a command.
enum class CncNumbers : std::uint8_t {
  Nothing,    ///< the name stands alone
  NoLengths,  ///< axes, factors, angles, runs, times, tools and texts
  Length,     ///< one, at the end
  Tolerance,  ///< the same: the most that is allowed
  Place,      ///< one or two, behind X and Y
  Undescribed,
};

struct CncInfo {
  CncCode code;
  std::string_view name;
  Treatment treatment;
  CncNumbers numbers;
  std::string_view effect;
};

/// The table in the order of cnc_commands.def.
std::span<const CncInfo> cnc_table();

/// A CNC command as M49 gives it.
struct CncCommand {
  const CncInfo* info = nullptr;
  std::string_view argument;  ///< behind the name; a comma between them is left out
};

/// Finds the command whose name a text begins with: what follows the name is no letter, but X or Y,
/// or the name is a longer one's beginning only.
std::optional<CncCommand> find_cnc_command(std::string_view text);

/// The numbers behind the name are lengths, as far as the manual describes them.
bool states_lengths(const CncCommand& command);

/// `X3.Y100.`: numbers behind X and Y, in the unit they are written in; absent if there is anything
/// else. A letter without a number is zero.
std::optional<std::array<std::optional<double>, 2>> read_xy(std::string_view argument);
/// A plain number, with or without a decimal point.
std::optional<double> read_plain_number(std::string_view text);

/// A command of a program in another unit, for one in millimetres: its length converted and
/// rounded, a tolerance down, with a decimal point; what has no length is as it was. Absent for
/// numbers whose meaning the manual does not describe, a length without a point among them, and for
/// a length that rounds to zero.
std::optional<std::string> command_in_mm(std::string_view text, Length unit, int n_decimals);

}  // namespace panelcal::sieb_meyer
