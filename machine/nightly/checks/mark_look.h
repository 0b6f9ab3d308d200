// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "calib/base/expected.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/look/picture_locator.h"
#include <Eigen/Core>

namespace panelcal {

/// One look at the mark of [nightly].
struct MarkSighting {
  std::optional<Eigen::Vector2d> place_mm;  ///< machine, as the present calibrations have it
  std::string missed;                       ///< the reason if it was not found
  double clipped_share = 0;                 ///< of the picture's pixels, at the scale's end
};

/// Looks at the mark of [nightly], coming each time anew from the same side.
class MarkLooker {
 public:
  /// In     config, nightly: outlive this; observer: sees every picture
  /// Fails  config-value (no mark, no [camera]); vision-tool-undefined; travel-exceeded. Nothing
  ///        has moved then
  static Expected<MarkLooker> make(const MachineConfig& config,
                                   const NightlyConfig& nightly,
                                   PictureObserver observer);

  /// Fails  device-stage; device-frame; picture-mismatch
  Expected<MarkSighting> look(const CalibrationDevices& devices) const;

 private:
  MarkLooker(const MachineConfig& config, const NightlyConfig& nightly, PictureLocator locator)
      : config_(config), nightly_(nightly), locator_(std::move(locator)) {}

  const MachineConfig& config_;
  const NightlyConfig& nightly_;
  PictureLocator locator_;
};

}  // namespace panelcal
