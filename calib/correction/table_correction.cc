// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/table_correction.h"

#include <fmt/format.h>

namespace panelcal {

bool TableCorrection::holds_at(const Position<frame::Machine>& command) const {
  const Eigen::Vector2d& c_mm = command.in_mm();
  const TableGrid& grid = map_.grid();
  // Written so that a NaN is outside.
  return (c_mm.array() >= grid.low_mm.array() - hold_.in_mm()).all() &&
         (c_mm.array() <= grid.high_mm.array() + hold_.in_mm()).all();
}

std::optional<Position<frame::Machine>> TableCorrection::command_for(
    const Position<frame::Machine>& place) const {
  const auto command = map_.command_for(position_mm<frame::Table>(place.in_mm()));
  return command && holds_at(*command) ? command : std::nullopt;
}

std::optional<Position<frame::Machine>> TableCorrection::place_of(
    const Position<frame::Machine>& command) const {
  if (!holds_at(command)) return std::nullopt;
  return nearest_place_of(command);
}

Position<frame::Machine> TableCorrection::nearest_command_for(
    const Position<frame::Machine>& place) const {
  return map_.command_for(position_mm<frame::Table>(place.in_mm())).value_or(place);
}

Position<frame::Machine> TableCorrection::nearest_place_of(
    const Position<frame::Machine>& command) const {
  return position_mm<frame::Machine>(map_(command).in_mm());
}

Diagnostic TableCorrection::refusal(const Position<frame::Machine>& at) const {
  const TableGrid& grid = map_.grid();
  const std::string beyond =
      hold_ > Length() ? fmt::format(", or up to [table] hold_mm = {} beyond", hold_.in_mm()) : "";
  return {Code::TravelExceeded,
          {file_.string(), 0, 0},
          fmt::format(
              "the table's map does not reach ({:.3f}, {:.3f}) mm", at.in_mm().x(), at.in_mm().y()),
          fmt::format("spindle places from ({:.3f}, {:.3f}) to ({:.3f}, {:.3f}) mm{}",
                      grid.low_mm.x(),
                      grid.low_mm.y(),
                      grid.high_mm.x(),
                      grid.high_mm.y(),
                      beyond)};
}

}  // namespace panelcal
