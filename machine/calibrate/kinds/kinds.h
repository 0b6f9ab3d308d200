// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "machine/calibrate/calibration.h"
#include "machine/config/machine_config.h"
#include "machine/config/plate/plate.h"
#include "machine/config/settings/nightly_options.h"

namespace panelcal {

/// The calibrations that [nightly] calibrate lists, in the order of the steps in
/// calib/ledger/entry/kinds.def. They share a copy of the machine's configuration, so that an
/// offset is measured with the camera that was installed a minute before.
class NightCalibrations {
 public:
  /// Fails  config-value (what a calibration needs is missing)
  static Expected<NightCalibrations> make(const MachineConfig& config,
                                          const NightlyConfig& nightly);

  const std::vector<Calibration*>& all() const { return all_; }
  /// The copy: as machine.toml has it, with the camera that is installed, and with the longer wait
  /// where a settle time was found that machine.toml's is too short for.
  const MachineConfig& config() const { return *config_; }

 private:
  std::shared_ptr<MachineConfig> config_;
  std::vector<std::unique_ptr<Calibration>> owned_;
  std::vector<Calibration*> all_;
};

/// The camera, driven over the mark of [nightly].
///
/// In     zoom: absent: as the camera stands
std::unique_ptr<Calibration> camera_kind(std::shared_ptr<MachineConfig> config,
                                         const NightlyConfig& nightly,
                                         const std::optional<double>& zoom);

/// The table, on a plate that is fixed to the machine.
///
/// In     file: that is installed
std::unique_ptr<Calibration> table_kind(std::shared_ptr<MachineConfig> config,
                                        const NightlyConfig& nightly,
                                        CalibrationPlate plate,
                                        std::filesystem::path file);

/// The table's own surface, of a backing plate or a reference plate that stays on the machine, by
/// probing the places of [nightly.surface].
std::unique_ptr<Calibration> surface_kind(std::shared_ptr<MachineConfig> config,
                                          const NightlyConfig& nightly);

}  // namespace panelcal
