// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/grbl/grbl.h"

#include <utility>

#include "machine/devices/controls/grbl/machine.h"
#include "machine/devices/controls/line_link.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using SharedGrbl = std::shared_ptr<grbl::Machine>;

class GrblStage final : public Stage {
 public:
  explicit GrblStage(SharedGrbl machine) : machine_(std::move(machine)) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    PANELCAL_TRY(const Eigen::Vector2d at_mm, machine_->move_to(spindle.in_mm()));
    return position_mm<frame::Machine>(at_mm);
  }

 private:
  SharedGrbl machine_;
};

class GrblProbe final : public ProbeSource {
 public:
  GrblProbe(SharedGrbl machine, Length z0) : machine_(std::move(machine)), z0_(z0) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    PANELCAL_TRY(const double z_mm, machine_->probe_at(request.expected_in_machine().in_mm()));
    return ProbeReading{request, ProbeStatus::Found, {{mm(z_mm) - z0_, Length()}}, {}};
  }

 private:
  SharedGrbl machine_;
  Length z0_;
};

}  // namespace

Expected<OpenedControl> open_grbl(const MachineConfig& config) {
  const ControlSetting& setting = config.control;
  constexpr Time kConnectLimit = seconds(5);
  constexpr int kTelnet = 23;
  PANELCAL_TRY(
      std::unique_ptr<LineLink> link,
      setting.device.empty()
          ? LineLink::tcp(setting.host, setting.port == 0 ? kTelnet : setting.port, kConnectLimit)
          : LineLink::serial(setting.device, setting.baud));
  PANELCAL_TRY(grbl::Machine opened, grbl::Machine::open(grbl::Talk(std::move(link)), setting));
  const auto machine = std::make_shared<grbl::Machine>(std::move(opened));
  OpenedControl control;
  control.words = machine->words();
  control.stage = std::make_shared<GrblStage>(machine);
  if (setting.probe) control.probe = std::make_shared<GrblProbe>(machine, setting.probe->z0);
  return control;
}

}  // namespace panelcal
