// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/sections/line_role.h"

#include <algorithm>
#include <array>

#include "program/sieb_meyer/text/cnc_commands.h"

namespace panelcal::sieb_meyer {
namespace {

/// M49 of a line.
void take_cnc_command(const Block& block, LineRole& role) {
  const auto command = find_cnc_command(block.argument);
  if (!command) return;
  switch (command->info->code) {
    case CncCode::BlockDelete:
    case CncCode::NoBlockDelete:
      role.deletes_blocks = command->info->code == CncCode::BlockDelete;
      break;
    case CncCode::AxisVersion:
      role.states_axes = block.n_words == 1;
      break;
    // They act on placed coordinates: no copy's places are those of another, moved by the offset.
    // NOSA and NORA matter only where one was on before the section.
    case CncCode::Scale:
    case CncCode::Rotation:
      role.has.own_copies = true;
      break;
    default:
      break;
  }
}

bool is_area(Command command) {
  return command == Command::CheckAreaX || command == Command::CheckAreaY ||
         command == Command::ForbiddenArea;
}

}  // namespace

LineRole role_of(const Block& block) {
  LineRole role;
  bool routs = false;
  for (const Word& word : block.all()) {
    if (word.letter == 'X' || word.letter == 'Y') role.moves = true;
    if (word.letter == 'F') role.has.feeds = true;
    const auto command = word.letter == 'G' || word.letter == 'M' ? command_of(word) : std::nullopt;
    if (command != Command::OpenSection && command != Command::CloseSection) role.works = true;
    if (!command) continue;
    routs |= is_routing(*command);
    if (*command == Command::OpenSection) role.closes_first |= role.n_close > 0;
    if (*command == Command::OpenSection) ++role.n_open;
    if (*command == Command::CloseSection) ++role.n_close;
    if (is_offset(*command)) role.is_offset = true;
    if (info(*command).command_class == CommandClass::Measurement || is_camera(*command) ||
        *command == Command::Subprogram || *command == Command::SurfaceOn) {
      role.has.measurements = true;
    }
    if (*command == Command::Subprogram) role.moves = role.has.calls = true;
    if (*command == Command::CncCommand) take_cnc_command(block, role);
    if (is_area(*command)) role.has.own_copies = true;
    if (*command == Command::TextX || *command == Command::TextY) {
      role.has.own_copies |= block.argument.find("&R") != std::string_view::npos;
    }
  }
  role.has.old_feed = routs && !role.has.feeds;
  if (role.n_close > 0) role.works = role.moves;
  return role;
}

bool has_coordinate(std::string_view line) {
  const auto at = line.find_first_of("XY(");
  return at != std::string_view::npos && line[at] != '(';
}

bool may_matter(std::string_view line) {
  constexpr auto kSigns = [] {
    std::array<bool, 256> signs{};
    for (const char c : {'M', 'G', 'F', '/'}) signs[static_cast<unsigned char>(c)] = true;
    return signs;
  }();
  return std::ranges::any_of(line, [&](char c) { return kSigns[static_cast<unsigned char>(c)]; });
}

}  // namespace panelcal::sieb_meyer
