// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

/// A row of [[camera.zoom]].
struct ZoomKeys {
  double level = 0;
  std::filesystem::path calibration;
};

constexpr double kMaxLamp = 1e6;

bool put_focus_range(MachineConfig& config, const FieldValue& value) {
  const Length low = mm(value.numbers[0]);
  const Length high = mm(value.numbers[1]);
  config.vision.focus_range = FocusRange{low, high};
  return low < high;
}

#include "machine/config/sections/camera.def"

Expected<void> read_focus(const TomlTable& camera, MachineConfig& config) {
  const std::optional<FocusRange>& range = config.vision.focus_range;
  config.walk.has_focus = range.has_value();
  const Range heights = range ? Range{range->low.in_mm(), range->high.in_mm()} : kPlace;
  PANELCAL_TRY(const auto focus_mm, camera.number("focus_mm", heights));
  if (!focus_mm) return {};
  if (!range) {
    return failure(
        camera.problem("focus_mm", "focus_range_mm as well", "the range of heights is missing"));
  }
  config.vision.focus = mm(*focus_mm);
  return {};
}

Expected<void> read_zoom(const TomlTable& row, MachineConfig& config) {
  ZoomKeys zoom;
  PANELCAL_CHECK(row.read(kZoom, zoom));
  // A night would calibrate the one level over the other.
  const auto is_same = [&](const auto& other) {
    return other.second.lexically_normal() == zoom.calibration.lexically_normal();
  };
  if (std::ranges::any_of(config.zoom_files, is_same)) {
    return failure(row.problem("calibration", "a file for each level", "another zoom has it"));
  }
  PANELCAL_TRY(const CameraCalibration calibration, read_camera_calibration(zoom.calibration));
  if (!config.zooms.emplace(zoom.level, calibration).second) {
    return failure(row.problem("level", "each level once", "another zoom has it"));
  }
  config.zoom_files[zoom.level] = zoom.calibration;
  return {};
}

Expected<void> read_camera(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.read_table(kCamera, config));
  if (!table) return {};
  PANELCAL_TRY(config.camera, read_camera_calibration(config.camera_file));
  config.walk.moves_offset = true;
  PANELCAL_CHECK(read_focus(*table, config));
  PANELCAL_TRY(const auto zooms, table->tables(kZoom));
  for (const TomlTable& row : zooms) PANELCAL_CHECK(read_zoom(row, config));
  return {};
}

}  // namespace

Section camera_section() {
  return {kCameraTables, read_camera};
}

}  // namespace panelcal::internal
