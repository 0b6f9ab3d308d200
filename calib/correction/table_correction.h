// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <utility>

#include "calib/base/diagnostic.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/correction/table_map.h"

namespace panelcal {

/// A table's map in force ([table] of machine.toml): which command brings the spindle to a place,
/// and to which place a command brings it.
///
///   place = map(command)
///
/// Places are those of a machine whose stage does not err; whatever is measured, fitted and
/// corrected is in them. Commands are what the stage is told. Beyond the map's rectangle nothing
/// was measured: up to `hold` beyond it the error of its edge holds, farther away there is no
/// answer.
///
/// Cost   as TableMap; nothing allocates but refusal()
/// See    docs/conventions.md, Frames; tests/calib/correction/table_correction_test.cc
class TableCorrection {
 public:
  /// In     file: of the calibration, for messages
  explicit TableCorrection(TableMap map, Length hold = {}, std::filesystem::path file = {})
      : map_(std::move(map)), hold_(hold), file_(std::move(file)) {}

  const TableMap& map() const { return map_; }
  Length hold() const { return hold_; }

  /// Empty where the map does not hold.
  std::optional<Position<frame::Machine>> command_for(const Position<frame::Machine>& place) const;
  std::optional<Position<frame::Machine>> place_of(const Position<frame::Machine>& command) const;
  /// The same wherever it is, by the error of the edge: for what need not be right, since nothing
  /// is made or measured there.
  Position<frame::Machine> nearest_command_for(const Position<frame::Machine>& place) const;
  Position<frame::Machine> nearest_place_of(const Position<frame::Machine>& command) const;

  /// The reason for no answer at a place: travel-exceeded.
  Diagnostic refusal(const Position<frame::Machine>& at) const;

 private:
  bool holds_at(const Position<frame::Machine>& command) const;

  TableMap map_;
  Length hold_;
  std::filesystem::path file_;
};

}  // namespace panelcal
