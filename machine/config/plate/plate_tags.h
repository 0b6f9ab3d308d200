// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/config/plate/tags.h"
#include "machine/config/toml/toml_table.h"

// Not installed: a part of a plate's file.
namespace panelcal::internal {

/// [tags], [[tag]] of a plate's file.
Tables plate_tag_tables();

/// Reads [tags] and [[tag]] of a plate's file:
///
///   [tags]
///   family = "tag36h11"   size_mm = 12            polarity = "bright"
///   first_id = 0          first_cell = [0.5, 0.5] step_cells = [2, 2]
///   columns = 4           rows = 4                angle_deg = 0
///   [[tag]]
///   id = 40               cell = [3, 3]           angle_deg = 90
///
/// A cell is counted in pitches from dot (0, 0); ids along x first.
///
/// In     top: the file; pitch: of the dots
/// Out    empty if there is no [tags]
/// Fails  config-key-unknown; config-value, with line and column
Expected<std::optional<PlateTags>> read_plate_tags(const TomlTable& top, Length pitch);

}  // namespace panelcal::internal
