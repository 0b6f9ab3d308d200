// SPDX-License-Identifier: Apache-2.0
#include "machine/check/vision_rules.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

#include "calib/base/amount.h"
#include "calib/panel/smooth_panel.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Diameter or side of the smallest mark that vision/round and vision/polygon measure.
constexpr double kLeastMark_px = 6;
/// With one target left, an offset has no equation to spare.

/// Size of the pictures of one calibration.
struct FieldOfView {
  double scale_mm_per_px = 0;
  double longer_px = 0;

  double longer_mm() const { return longer_px * scale_mm_per_px; }
};

FieldOfView field_of_view(const CameraCalibration& camera) {
  return {camera.parameters.scale_mm_per_px,
          static_cast<double>(std::max(camera.picture_width_px, camera.picture_height_px))};
}

/// The views with the smallest and with the largest pixel: of [camera] and of every zoom.
struct FieldsOfView {
  FieldOfView finest;
  FieldOfView widest;
};

FieldsOfView fields_of_view(const MachineConfig& config) {
  const FieldOfView first = field_of_view(*config.camera);
  FieldsOfView views = {first, first};
  for (const auto& [level, camera] : config.zooms) {
    const FieldOfView view = field_of_view(camera);
    if (view.scale_mm_per_px < views.finest.scale_mm_per_px) views.finest = view;
    if (view.longer_mm() > views.widest.longer_mm()) views.widest = view;
  }
  return views;
}

bool has_detector_limit(Shape shape) {
  return shape == Shape::Disc || shape == Shape::Hole || shape == Shape::Ring ||
         shape == Shape::Square || shape == Shape::Diamond || shape == Shape::Cross ||
         shape == Shape::Slot;
}

std::string size_key(const Target& target) {
  return fmt::format("vision.tool.{}.{}", target.number, target.size ? "size_mm" : "size_px");
}

void check_tool_size(const Target& target,
                     const FieldsOfView& views,
                     const Place& place,
                     DiagnosticLog& log) {
  const double in_finest_px =
      target.size ? target.size->in_mm() / views.finest.scale_mm_per_px : target.size_px->in_px();
  const double in_widest_px =
      target.size ? target.size->in_mm() / views.widest.scale_mm_per_px : target.size_px->in_px();
  const std::string size = target.size
                               ? fmt::format("size_mm in [[vision.tool]] is {:.4g}, {:.4g} px",
                                             target.size->in_mm(),
                                             in_finest_px)
                               : fmt::format("size_px in [[vision.tool]] is {:.4g}", in_finest_px);
  if (in_widest_px > views.widest.longer_px) {
    log.add({Code::ConfigValue,
             place,
             fmt::format("{}: the picture has {:.0f} px ({:.4g} mm)",
                         size,
                         views.widest.longer_px,
                         views.widest.longer_mm()),
             "a mark that the picture of [camera] holds"});
  }
  const double largest_px = in_finest_px * (1 + target.size_tolerance);
  if (has_detector_limit(target.shape) && largest_px < kLeastMark_px) {
    log.add({Code::ConfigValue,
             place,
             fmt::format("{}: too small to be measured", size),
             fmt::format("{:.0f} px or more ({:.4g} mm)",
                         kLeastMark_px,
                         kLeastMark_px * views.finest.scale_mm_per_px)});
  }
}

void check_search_radius(const MachineConfig& config,
                         const FieldsOfView& views,
                         const StatedKeys& keys,
                         DiagnosticLog& log) {
  const auto& radius = config.vision.search_radius;
  if (!radius || radius->in_mm() >= views.finest.scale_mm_per_px) return;
  log.add({Code::ConfigValue,
           keys.place("vision.search_radius_mm"),
           fmt::format("search_radius_mm in [vision] is {:.4g}, less than a pixel ({:.4g} mm)",
                       radius->in_mm(),
                       views.finest.scale_mm_per_px),
           "how far targets may be from their expected places"});
}

/// A model that series of [vision] rotate never get.
void check_model(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  const int n = config.walk.series_size;
  if (!keys.has("vision.model")) return;
  const auto refuse = [&](std::string_view model, const std::string& expected) {
    log.add({Code::ConfigValue,
             keys.place("vision.rotate"),
             fmt::format("rotate in [vision] is {}, and model is \"{}\"", n, model),
             expected});
  };
  if (config.walk.bends_panel && (n < kLeastSmoothTargets || n > kMostSmoothTargets)) {
    refuse("smooth",
           fmt::format("series of {} to {} targets, or another model",
                       kLeastSmoothTargets,
                       kMostSmoothTargets));
  }
  // `stretch` is at most that: a series of two is rigid.
  if (config.walk.model == PanelModel::Affine && n < 3) {
    refuse(name(PanelModel::Affine), "series of 3 targets or more, or another model");
  }
}

}  // namespace

void check_vision_rules(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  if (config.camera) {
    const FieldsOfView views = fields_of_view(config);
    for (const auto& [number, target] : config.vision_tools) {
      check_tool_size(target, views, keys.place(size_key(target)), log);
    }
    check_search_radius(config, views, keys, log);
  }
}

void check_stated_series(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  if (!keys.has("vision.rotate")) return;
  check_model(config, keys, log);
}

}  // namespace panelcal
