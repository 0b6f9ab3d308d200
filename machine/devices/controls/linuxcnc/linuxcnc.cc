// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/linuxcnc/linuxcnc.h"

#include <memory>
#include <optional>
#include <utility>

#include "machine/devices/controls/linuxcnc/drive.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

class LinuxCncStage final : public Stage {
 public:
  explicit LinuxCncStage(std::shared_ptr<LinuxCncDrive> drive) : drive_(std::move(drive)) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    PANELCAL_TRY(const LinuxCncPlace standing, drive_->move_to(spindle.in_mm()));
    return position_mm<frame::Machine>(standing.actual_mm.x(), standing.actual_mm.y());
  }

 private:
  std::shared_ptr<LinuxCncDrive> drive_;
};

class LinuxCncProbe final : public ProbeSource {
 public:
  LinuxCncProbe(std::shared_ptr<LinuxCncDrive> drive, const ControlProbe& setting)
      : drive_(std::move(drive)), setting_(setting) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    PANELCAL_TRY(const std::optional<double> touch_mm,
                 drive_->touch_at(request.expected_in_machine().in_mm()));
    if (touch_mm) {
      return ProbeReading{
          request, ProbeStatus::Found, {{mm(*touch_mm) - setting_.z0, Length()}}, {}};
    }
    return ProbeReading{
        request,
        ProbeStatus::NotFound,
        {},
        fmt::format("nothing was touched down to Z {:g} of the machine", setting_.to.in_mm())};
  }

 private:
  std::shared_ptr<LinuxCncDrive> drive_;
  ControlProbe setting_;
};

}  // namespace

Expected<OpenedControl> open_linuxcnc(const MachineConfig& config) {
  auto drive = std::make_shared<LinuxCncDrive>(config.control);
  PANELCAL_CHECK(drive->make_ready());
  OpenedControl out;
  out.words = "LinuxCNC at " + drive->name();
  if (config.control.probe) {
    out.probe = std::make_shared<LinuxCncProbe>(drive, *config.control.probe);
  }
  out.stage = std::make_shared<LinuxCncStage>(std::move(drive));
  return out;
}

}  // namespace panelcal::internal
