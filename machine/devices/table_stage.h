// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "calib/base/expected.h"
#include "calib/correction/table_correction.h"
#include "machine/config/machine_config.h"
#include "machine/devices/stage.h"

namespace panelcal {

/// A stage with its table's error taken back: it is sent to places, and the stage below it is told
/// the commands that lead there. So a measurement with it need not know of the table.
///
/// See    calib/correction/table_correction.h; tests/machine/devices/table_stage_test.cc
class TableStage final : public Stage {
 public:
  /// Precondition: both are there
  TableStage(std::shared_ptr<Stage> told, std::shared_ptr<const TableCorrection> table)
      : told_(std::move(told)), table_(std::move(table)) {}

  /// Fails  travel-exceeded, before anything moves; device-stage
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& place) override;
  bool can_set(CameraSetting setting) const override { return told_->can_set(setting); }
  Expected<void> set(CameraSetting setting, double value) override {
    return told_->set(setting, value);
  }

 private:
  std::shared_ptr<Stage> told_;
  std::shared_ptr<const TableCorrection> table_;
};

/// The stage to measure with: `told` itself without a table.
std::shared_ptr<Stage> measuring_stage(std::shared_ptr<Stage> told,
                                       std::shared_ptr<const TableCorrection> table);

/// Place of the optical axis when a list of pictures states the place to which it was sent.
///
/// In     listed: x, y of images.csv, which are the command and the spindle-camera offset
/// Fails  travel-exceeded
Expected<Position<frame::Machine>> axis_from_listed(const MachineConfig& config,
                                                    const Position<frame::Machine>& listed);
/// The other way round: what a list says of a picture whose axis stood there.
Expected<Position<frame::Machine>> listed_from_axis(const MachineConfig& config,
                                                    const Position<frame::Machine>& axis);

}  // namespace panelcal
