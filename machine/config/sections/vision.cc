// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/vision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

constexpr std::array<std::string_view, 2> kZoomKeys = {"calibration", "level"};
constexpr Range kDistance_mm{0, kMaxPlace_mm, true};
constexpr double kMaxAlgorithm = 1e6;
constexpr double kMaxLamp = 1e6;

Expected<void> read_algorithms(const TomlTable& vision, VisionOptions& options) {
  PANELCAL_TRY(const auto numbers, vision.numbers("algorithms", {0, kMaxAlgorithm}));
  if (!numbers) return {};
  options.algorithms.clear();
  for (const double number : *numbers) {
    if (number != std::floor(number)) return failure(vision.problem("algorithms", "whole numbers"));
    options.algorithms.push_back(static_cast<int>(number));
  }
  return {};
}

}  // namespace

Expected<void> read_vision_options(const TomlTable& vision, VisionOptions& options) {
  PANELCAL_TRY(const auto radius_mm, vision.number("search_radius_mm", kDistance_mm));
  if (radius_mm) options.search_radius = mm(*radius_mm);
  PANELCAL_TRY(const auto area_mm, vision.number("search_area_mm", kDistance_mm));
  if (area_mm) options.search_area = mm(*area_mm);
  PANELCAL_TRY(const auto views, vision.text("four_views"));
  if (views && *views != "axes" && *views != "corners") {
    return failure(vision.problem("four_views", "\"axes\" or \"corners\""));
  }
  if (views) options.four_views = *views == "axes" ? FourViews::Axes : FourViews::Corners;
  PANELCAL_TRY(const double limit_um,
               vision.number_or("four_view_limit_um", {0, 1e6}, options.four_view_limit.in_um()));
  options.four_view_limit = um(limit_um);
  return read_algorithms(vision, options);
}

Expected<void> read_zoom_and_focus(const TomlTable& camera, MachineConfig& config) {
  PANELCAL_TRY(const auto range_mm, camera.pair("focus_range_mm", {-kMaxPlace_mm, kMaxPlace_mm}));
  if (range_mm && !(range_mm->x() < range_mm->y())) {
    return failure(camera.problem("focus_range_mm", "[low, high], low below high"));
  }
  if (range_mm) config.vision.focus_range = FocusRange{mm(range_mm->x()), mm(range_mm->y())};
  config.walk.has_focus = config.vision.focus_range.has_value();
  const Range heights =
      range_mm ? Range{range_mm->x(), range_mm->y()} : Range{-kMaxPlace_mm, kMaxPlace_mm};
  PANELCAL_TRY(const auto focus_mm, camera.number("focus_mm", heights));
  if (focus_mm && !range_mm) {
    return failure(
        camera.problem("focus_mm", "focus_range_mm as well", "the range of heights is missing"));
  }
  if (focus_mm) config.vision.focus = mm(*focus_mm);
  PANELCAL_TRY(config.vision.lamp, camera.number("lamp", {.low = 0, .high = kMaxLamp}));

  PANELCAL_TRY(const auto zooms, camera.tables("zoom", "[[camera.zoom]]", {kZoomKeys, {}}));
  for (const TomlTable& zoom : zooms) {
    PANELCAL_CHECK(zoom.require({{"level", "level = 3, as in $uvis,zoom,3"},
                                 {"calibration", "calibration = \"NAME.cal.json\""}}));
    PANELCAL_TRY(const auto level, zoom.number("level", {0, 1e6}));
    PANELCAL_TRY(const auto file, zoom.text("calibration"));
    if (!file || file->empty()) {
      return failure(zoom.missing("calibration", "calibration = \"NAME.cal.json\""));
    }
    const std::filesystem::path path = config.file.parent_path() / *file;
    // A night would calibrate the one level over the other.
    const auto is_same = [&](const auto& other) {
      return other.second.lexically_normal() == path.lexically_normal();
    };
    if (std::ranges::any_of(config.zoom_files, is_same)) {
      return failure(zoom.problem("calibration", "a file for each level", "another zoom has it"));
    }
    PANELCAL_TRY(const CameraCalibration calibration, read_camera_calibration(path));
    if (!config.zooms.emplace(*level, calibration).second) {
      return failure(zoom.problem("level", "each level once", "another zoom has it"));
    }
    config.zoom_files[*level] = path;
  }
  return {};
}

}  // namespace panelcal::internal
