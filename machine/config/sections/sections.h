// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

// Not installed: the sections of machine.toml, each in a file of its own, with its tables in the
// .def beside it.
namespace panelcal::internal {

struct Section {
  Tables tables;
  /// Reads the tables into the configuration, in which the sections before are; null: the section
  /// of the table that these lie in does.
  ///
  /// Fails  config-key-unknown; config-value; what reading a file that is named reports
  Expected<void> (*read)(const TomlTable& top, MachineConfig& config);
};

Section machine_section();
Section camera_section();
Section spindle_section();
Section table_section();
Section uncertainty_section();
Section coupon_section();
Section nightly_section();
Section night_surface_section();
Section vision_section();
Section target_section();
Section gate_section();
Section tolerance_section();
Section gcode_section();
Section program_section();
Section sim_section();
Section sim_surface_section();

}  // namespace panelcal::internal
