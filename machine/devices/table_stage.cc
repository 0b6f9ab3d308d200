// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/table_stage.h"

namespace panelcal {

Expected<Position<frame::Machine>> TableStage::move_to(const Position<frame::Machine>& place) {
  const auto command = table_->command_for(place);
  if (!command) return failure(table_->refusal(place));
  PANELCAL_TRY(const Position<frame::Machine> standing, told_->move_to(*command));
  return table_->nearest_place_of(standing);
}

std::shared_ptr<Stage> measuring_stage(std::shared_ptr<Stage> told,
                                       std::shared_ptr<const TableCorrection> table) {
  if (table == nullptr) return told;
  return std::make_shared<TableStage>(std::move(told), std::move(table));
}

Expected<Position<frame::Machine>> axis_from_listed(const MachineConfig& config,
                                                    const Position<frame::Machine>& listed) {
  if (config.walk.table == nullptr) return listed;
  const auto command = config.spindle_camera.spindle_to_see(listed);
  const auto place = config.walk.table->place_of(command);
  if (!place) return failure(config.walk.table->refusal(command));
  return config.spindle_camera.optical_axis(*place);
}

Expected<Position<frame::Machine>> listed_from_axis(const MachineConfig& config,
                                                    const Position<frame::Machine>& axis) {
  if (config.walk.table == nullptr) return axis;
  const auto place = config.spindle_camera.spindle_to_see(axis);
  const auto command = config.walk.table->command_for(place);
  if (!command) return failure(config.walk.table->refusal(place));
  return config.spindle_camera.optical_axis(*command);
}

}  // namespace panelcal
