// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/devices.h"

#include <cmath>
#include <utility>

#include "calib/base/interruption.h"
#include "machine/devices/cameras/camera_settings.h"
#include "machine/devices/table_stage.h"
#include "tools/calibrate/session.h"

namespace panelcal::calibrate {

Expected<DeviceSet> open_devices(const CalibrateOptions& options,
                                 const MachineConfig& config,
                                 Console& console) {
  if (options.machine_driver == "sim") return DeviceSet::simulated(config);
  if (!options.camera.empty()) {
    heed_interruptions();
    PANELCAL_TRY(DeviceSet live, DeviceSet::live(config, options.camera));
    for (const Diagnostic& risk : live.risks()) console.print(risk);
    return live;
  }
  return failure(usage("there is no SOURCE to calibrate with", "--camera or --machine-driver"));
}

Expected<PlaceDevices> PlaceDevices::open(const CalibrateOptions& options,
                                          const MachineConfig& config,
                                          Console& console) {
  PlaceDevices out;
  const auto& at_mm = options.at_mm;
  if (at_mm.size() != 2 || !std::isfinite(at_mm[0]) || !std::isfinite(at_mm[1])) {
    return failure(usage("there is no place of a mark to drive to", "--at X,Y"));
  }
  out.place_ = position_mm<frame::Machine>(at_mm[0], at_mm[1]);
  if (options.machine_driver != "sim") {
    PANELCAL_TRY(out.live_, open_devices(options, config, console));
    PANELCAL_CHECK(set_camera_as_stated(config, out.devices()));
    return out;
  }
  SimPlateOptions plate;
  plate.vision_tool = options.tool;
  plate.marks = {out.place_};
  if (config.sim) {
    static_cast<SimStops&>(plate) = config.sim->coupon;
    plate.seed = config.sim->seed;
    if (config.sim->table) {
      plate.error_mm = [table = *config.sim->table](const Position<frame::Machine>& command) {
        return table.error_mm(command);
      };
    }
  }
  PANELCAL_TRY(SimPlate sim, SimPlate::create(config, std::move(plate)));
  out.sim_ = std::make_shared<SimPlate>(std::move(sim));
  out.sim_stage_ = measuring_stage(out.sim_, config.walk.table);
  PANELCAL_CHECK(set_camera_as_stated(config, out.devices()));
  return out;
}

CalibrationDevices PlaceDevices::devices() {
  if (live_) return live_->devices();
  return CalibrationDevices{*sim_stage_,
                            *sim_,
                            *sim_,
                            [this](Time time) { sim_->wait(time); },
                            {},
                            {},
                            [this] { return sim_->now(); }};
}

}  // namespace panelcal::calibrate
