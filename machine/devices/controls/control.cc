// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/control.h"

#include <utility>

#include "machine/devices/commands/command_stage.h"
#include "machine/devices/controls/linuxcnc/linuxcnc.h"

namespace panelcal {
namespace {

/// A control moves; programs set lamp, zoom and focus.
class StageWithCommands final : public Stage {
 public:
  StageWithCommands(std::shared_ptr<Stage> control, const StageCommands& commands)
      : control_(std::move(control)), commands_(commands) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    return control_->move_to(spindle);
  }
  bool can_set(CameraSetting setting) const override { return commands_.can_set(setting); }
  Expected<void> set(CameraSetting setting, double value) override {
    return commands_.set(setting, value);
  }

 private:
  std::shared_ptr<Stage> control_;
  CommandStage commands_;
};

Expected<OpenedControl> open_by_driver(const MachineConfig& config) {
  switch (*config.control.driver) {
    case ControlKind::Grbl:
      break;
    case ControlKind::LinuxCnc:
      return internal::open_linuxcnc(config);
  }
  return failure({Code::NotSupported, {config.file.string(), 0, 0}, "[machine] driver", ""});
}

}  // namespace

Expected<OpenedControl> open_control(const MachineConfig& config) {
  PANELCAL_TRY(OpenedControl control, open_by_driver(config));
  control.stage = std::make_shared<StageWithCommands>(std::move(control.stage), config.stage);
  return control;
}

}  // namespace panelcal
