// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "machine/calibrate/place_record.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/nightly/record/night_calibration.h"

namespace panelcal {

/// The calibrations that [nightly] calibrate lists. They share a copy of the machine's
/// configuration, so that an offset is measured with the camera that was installed a minute before.
class NightCalibrations {
 public:
  /// Fails  config-value (what a calibration needs is missing)
  static Expected<NightCalibrations> make(const MachineConfig& config,
                                          const NightlyConfig& nightly);

  const std::vector<NightCalibration*>& all() const { return all_; }
  /// The copy: as machine.toml has it, with the camera that is installed, and with the longer wait
  /// where a settle time was found that machine.toml's is too short for.
  const MachineConfig& config() const { return *config_; }

 private:
  std::shared_ptr<MachineConfig> config_;
  std::vector<std::unique_ptr<NightCalibration>> owned_;
  std::vector<NightCalibration*> all_;
};

namespace internal {

/// A report's lines, without their ends.
std::vector<std::string> lines_of(const std::string& text);

/// In     config: outlives what is made of it
Expected<std::unique_ptr<NightCalibration>> spindle_camera_night(
    std::shared_ptr<MachineConfig> config, const NightlyConfig& nightly);
/// Focus, lamp level or settle time, at the mark.
Expected<std::unique_ptr<NightCalibration>> trial_night(TrialKind kind,
                                                        std::shared_ptr<MachineConfig> config,
                                                        const NightlyConfig& nightly);
/// Levels of [[camera.zoom]] that have a calibration of their own.
std::vector<double> zooms_of_nights(const MachineConfig& config);
/// In     zoom: absent: as the camera stands
Expected<std::unique_ptr<NightCalibration>> camera_night(std::shared_ptr<MachineConfig> config,
                                                         const NightlyConfig& nightly,
                                                         const std::optional<double>& zoom);

/// The table, on a plate that is fixed to the machine.
Expected<std::unique_ptr<NightCalibration>> table_night(std::shared_ptr<MachineConfig> config,
                                                        const NightlyConfig& nightly);

/// The table's surface, by probing.
Expected<std::unique_ptr<NightCalibration>> surface_night(std::shared_ptr<MachineConfig> config,
                                                          const NightlyConfig& nightly);

}  // namespace internal

}  // namespace panelcal
