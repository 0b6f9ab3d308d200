// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/open/open_control.h"

#include <optional>
#include <utility>

#include "machine/devices/commands/command_probe.h"
#include "machine/devices/commands/command_stage.h"
#include "machine/devices/controls/grbl/grbl.h"
#include "machine/devices/controls/linuxcnc/linuxcnc.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// The machine file's own limits, which the control need not know.
Expected<void> check_travel(const std::optional<Travel>& travel,
                            const Position<frame::Machine>& place) {
  const Eigen::Vector2d at_mm = place.in_mm();
  if (!travel || ((at_mm.array() >= travel->low.in_mm().array()).all() &&
                  (at_mm.array() <= travel->high.in_mm().array()).all())) {
    return {};
  }
  return failure({Code::TravelExceeded,
                  {"stage", 0, 0},
                  fmt::format("[{:.3f}, {:.3f}] mm is outside the travel", at_mm.x(), at_mm.y()),
                  "a place between [machine] travel_low_mm and travel_high_mm"});
}

/// A control moves; programs set lamp, zoom and focus.
class StageWithCommands final : public Stage {
 public:
  StageWithCommands(std::shared_ptr<Stage> control, const MachineConfig& config)
      : control_(std::move(control)), travel_(config.travel), commands_(config.stage) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    PANELCAL_CHECK(check_travel(travel_, spindle));
    return control_->move_to(spindle);
  }
  bool can_set(CameraSetting setting) const override { return commands_.can_set(setting); }
  Expected<void> set(CameraSetting setting, double value) override {
    return commands_.set(setting, value);
  }

 private:
  std::shared_ptr<Stage> control_;
  std::optional<Travel> travel_;
  CommandStage commands_;
};

class ProbeInTravel final : public ProbeSource {
 public:
  ProbeInTravel(std::shared_ptr<ProbeSource> control, std::optional<Travel> travel)
      : control_(std::move(control)), travel_(travel) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    PANELCAL_CHECK(check_travel(travel_, request.expected_in_machine()));
    return control_->probe(request);
  }

 private:
  std::shared_ptr<ProbeSource> control_;
  std::optional<Travel> travel_;
};

Expected<OpenedControl> open_by_driver(const MachineConfig& config) {
  switch (*config.control.driver) {
    case ControlKind::Grbl:
      return open_grbl(config);
    case ControlKind::LinuxCnc:
      return internal::open_linuxcnc(config);
  }
  return failure({Code::NotSupported, {config.file.string(), 0, 0}, "[machine] driver", ""});
}

}  // namespace

Expected<OpenedControl> open_control(const MachineConfig& config) {
  if (!config.control.driver) {
    OpenedControl commands{std::make_shared<CommandStage>(config.stage), nullptr, ""};
    if (config.can_probe()) commands.probe = std::make_shared<CommandProbe>(config.stage);
    return commands;
  }
  PANELCAL_TRY(OpenedControl control, open_by_driver(config));
  control.stage = std::make_shared<StageWithCommands>(std::move(control.stage), config);
  if (control.probe) {
    control.probe = std::make_shared<ProbeInTravel>(std::move(control.probe), config.travel);
  }
  return control;
}

}  // namespace panelcal
