// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "machine/config/machine_config.h"
#include "machine/sim/sim_plate.h"
#include "machine/sources/device_set.h"
#include "tools/cli/console.h"
#include "tools/cli/options/options.h"

namespace panelcal::calibrate {

/// The devices of SOURCE. What their camera changes by itself is said.
///
/// Fails  usage (no SOURCE); what DeviceSet reports
Expected<DeviceSet> open_devices(const CalibrateOptions& options,
                                 const MachineConfig& config,
                                 Console& console);

/// The machine at the mark of --at: a real one, or a virtual table that has a mark of --tool there.
class PlaceDevices {
 public:
  /// Lamp and focus are then as machine.toml states them.
  ///
  /// Precondition: the caller holds the machine's lock
  /// Fails  usage (no --at, no SOURCE); config-value; what opening the devices reports
  static Expected<PlaceDevices> open(const CalibrateOptions& options,
                                     const MachineConfig& config,
                                     Console& console);

  CalibrationDevices devices();
  const Position<frame::Machine>& place() const { return place_; }

 private:
  Position<frame::Machine> place_;
  std::optional<DeviceSet> live_;
  std::shared_ptr<SimPlate> sim_;
  std::shared_ptr<Stage> sim_stage_;  ///< of `sim_`
};

}  // namespace panelcal::calibrate
