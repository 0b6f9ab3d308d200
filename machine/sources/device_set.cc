// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/device_set.h"

#include <chrono>
#include <cstdint>
#include <utility>

#include "calib/base/interruption.h"
#include "calib/base/statistics/random.h"
#include "machine/calibrate/spindle/coupon.h"
#include "machine/devices/cameras/camera_uri.h"
#include "machine/devices/cameras/patient_camera.h"
#include "machine/devices/commands/command_spindle.h"
#include "machine/devices/controls/open/open_control.h"
#include "machine/devices/table_stage.h"
#include "machine/sim/sim_coupon.h"
#include "machine/sim/sim_table.h"
#include "machine/sim/sim_table_surface.h"
#include "machine/sim/simulated_probe.h"

namespace panelcal {
namespace {

Time steady_now() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return seconds(std::chrono::duration<double>(since).count());
}

}  // namespace

/// Stage, spindle, camera and probe; of a virtual machine the one behind the stage is the next two.
struct DeviceSet::Owned {
  std::shared_ptr<SimCoupon> simulated;
  std::shared_ptr<Stage> stage;
  std::unique_ptr<Spindle> spindle;
  std::unique_ptr<CameraDevice> camera;
  std::shared_ptr<ProbeSource> probe;  ///< null: the machine cannot probe
};

DeviceSet::DeviceSet(std::shared_ptr<Owned> owned, std::string words)
    : owned_(std::move(owned)), words_(std::move(words)) {
}

Expected<DeviceSet> DeviceSet::simulated(const MachineConfig& config,
                                         std::chrono::sys_seconds now) {
  SimCouponOptions options = config.sim ? config.sim->coupon : SimCouponOptions{};
  if (config.coupon) {
    PANELCAL_TRY(const UsedRows used, used_rows(config));
    Random nights = Random(options.seed).fork(static_cast<std::uint64_t>(used.count()));
    options.seed = static_cast<std::uint64_t>(nights.uniform() * 0x1p53);
    options.vision_tool = config.coupon->vision_tool;
  }
  PANELCAL_TRY(SimCoupon machine, SimCoupon::create(config, options));
  auto owned = std::make_shared<Owned>();
  owned->simulated = std::make_shared<SimCoupon>(std::move(machine));
  owned->stage =
      measuring_stage(simulated_stage(owned->simulated, config.sim->table), config.walk.table);
  if (config.sim->table_surface) {
    PANELCAL_TRY(SimulatedProbe probe,
                 SimulatedProbe::create(surface_at(*config.sim->table_surface, now)));
    owned->probe = std::make_unique<SimulatedProbe>(std::move(probe));
  }
  return DeviceSet(std::move(owned), "the simulated machine of " + config.file.string());
}

Expected<DeviceSet> DeviceSet::live(const MachineConfig& config, std::string_view camera_uri) {
  // Before a device is touched.
  PANELCAL_CHECK(parse_camera_uri(camera_uri));
  if (!config.can_move()) {
    return failure({Code::ConfigValue,
                    {config.file.string(), 0, 0},
                    "there is no [machine] driver or stage_command that drives the machine",
                    "driver = \"grbl\", or stage_command = [\"PROGRAM\", \"{x}\", \"{y}\"]"});
  }
  auto owned = std::make_shared<Owned>();
  PANELCAL_TRY(owned->camera, open_patient_camera(camera_uri, config.camera_patience));
  PANELCAL_TRY(OpenedControl control, open_control(config));
  owned->stage = measuring_stage(std::move(control.stage), config.walk.table);
  owned->spindle = std::make_unique<CommandSpindle>(config.stage.drill, config.stage.limit);
  owned->probe = std::move(control.probe);
  std::string words = "the camera " + owned->camera->name();
  if (!control.words.empty()) words += " and " + control.words;
  return DeviceSet(std::move(owned), std::move(words));
}

std::vector<Diagnostic> DeviceSet::risks() const {
  return owned_->camera ? owned_->camera->risks() : std::vector<Diagnostic>();
}

CalibrationDevices DeviceSet::devices(Prompt prompt) const {
  if (SimCoupon* const machine = owned_->simulated.get()) {
    // No person lays anything on a simulated coupon.
    if (!prompt) prompt = [](std::string_view) -> Expected<void> { return {}; };
    CalibrationDevices out = machine->devices(*owned_->stage, std::move(prompt));
    out.probe = owned_->probe.get();
    return out;
  }
  return {*owned_->stage,
          *owned_->spindle,
          *owned_->camera,
          sleep_for,
          std::move(prompt),
          {},
          steady_now,
          owned_->probe.get()};
}

}  // namespace panelcal
