// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/place_table.h"

#include <algorithm>
#include <limits>

#include "calib/correction/error_budget.h"

namespace panelcal {

void PlaceTable::begin(const ProgramInfo& info) {
  *this = PlaceTable();
  static_cast<void>(info);
}

void PlaceTable::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    add(operation, Kind::Hole, drill->tool, *drill);
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    add(operation, Kind::SlotEnd, slot->tool, slot->start);
    add(operation, Kind::SlotEnd, slot->tool, slot->end);
  } else if (const auto* steps = std::get_if<StepSlot>(&operation.what)) {
    add(operation, Kind::SlotEnd, steps->tool, steps->start);
    add(operation, Kind::SlotEnd, steps->tool, steps->end);
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    router_ = *move;
  } else if (const auto* plunge = std::get_if<Plunge>(&operation.what)) {
    add(operation, Kind::RoutCorner, plunge->tool, router_);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    add(operation, Kind::RoutCorner, rout->tool, *rout);
    router_ = *rout;
  }
}

void PlaceTable::add(const Operation& operation,
                     Kind place_kind,
                     int place_tool,
                     const PlacedPoint& place) {
  const Eigen::Vector2d nominal_mm = place.nominal.in_mm();
  const Eigen::Vector2d shift_mm = place.corrected.in_mm() - nominal_mm;
  kind.push_back(static_cast<std::uint8_t>(place_kind));
  nominal_x_mm.push_back(nominal_mm.x());
  nominal_y_mm.push_back(nominal_mm.y());
  shift_x_um.push_back(static_cast<float>(shift_mm.x() * 1e3));
  shift_y_um.push_back(static_cast<float>(shift_mm.y() * 1e3));
  sigma_um.push_back(static_cast<float>(largest_sigma(place.cov_mm2).in_um()));
  risk.push_back(place.risk ? static_cast<float>(*place.risk)
                            : std::numeric_limits<float>::quiet_NaN());
  line.push_back(static_cast<std::uint32_t>(operation.line));
  tool.push_back(static_cast<std::uint32_t>(place_tool));
  // Places of one board come one behind the other.
  if (boards.empty() || !std::ranges::equal(boards[board.back()], operation.path)) {
    InstancePath path(operation.path.begin(), operation.path.end());
    const auto next = static_cast<std::uint32_t>(boards.size());
    const auto [at, is_new] = i_board_.try_emplace(path, next);
    if (is_new) boards.push_back(std::move(path));
    board.push_back(at->second);
  } else {
    board.push_back(board.back());
  }
  if (files.empty()) files.emplace_back();
  if (operation.file != files[file.empty() ? 0 : file.back()]) {
    const auto known = std::ranges::find(files, operation.file);
    file.push_back(static_cast<std::uint32_t>(known - files.begin()));
    if (known == files.end()) files.emplace_back(operation.file);
  } else {
    file.push_back(file.empty() ? 0 : file.back());
  }
}

}  // namespace panelcal
