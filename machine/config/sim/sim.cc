// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sim/sim.h"

#include <array>
#include <cmath>
#include <limits>

#include "machine/config/sim/surface.h"
#include "machine/config/toml/ranges.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::array<std::string_view, 35> kSimKeys = {"background",
                                                       "bit_depth",
                                                       "blur_px",
                                                       "board_offset_sigma_um",
                                                       "board_rotation_sigma_mrad",
                                                       "burrs_um",
                                                       "camera",
                                                       "coupon",
                                                       "debris",
                                                       "focus_depth_mm",
                                                       "focus_z_mm",
                                                       "hot_pixels",
                                                       "lamp",
                                                       "light_gradient",
                                                       "light_gradient_y",
                                                       "neighbors",
                                                       "noise",
                                                       "panel_offset_mm",
                                                       "panel_rotation_mrad",
                                                       "picture_px",
                                                       "ring_offset_sigma_um",
                                                       "seed",
                                                       "shot_noise",
                                                       "slot_length_mm",
                                                       "spindle_camera_offset_mm",
                                                       "stretch_ppm",
                                                       "surface",
                                                       "table",
                                                       "table_surface",
                                                       "target_level",
                                                       "tilt_axis_deg",
                                                       "tilt_deg",
                                                       "vignetting",
                                                       "weave_amplitude",
                                                       "weave_period_mm"};
constexpr std::array<std::string_view, 4> kSimCameraKeys = {
    "axis_px", "k1_per_px2", "rotation_rad", "scale_mm_per_px"};
constexpr std::array<std::string_view, 7> kDebrisKeys = {"brightest",
                                                         "darkest",
                                                         "rim_share",
                                                         "scratch_length_mm",
                                                         "scratch_width_um",
                                                         "scratches",
                                                         "size_um"};

constexpr std::array<std::string_view, 10> kCouponKeys = {"backlash_um",
                                                          "cold_um",
                                                          "drill_wander_um",
                                                          "mark_mm",
                                                          "mark_tool",
                                                          "stage_repeatability_um",
                                                          "swing_decay_s",
                                                          "swing_hz",
                                                          "swing_um",
                                                          "warm_up_s"};

constexpr std::array<std::string_view, 5> kSimTableKeys = {
    "bow_radius_mm", "bow_um", "center_mm", "scale_ppm", "squareness_urad"};

constexpr int kMaxPictureSide_px = 10'000;
constexpr Range kSimShare{0, 1};
constexpr Range kSimPpm{-1e5, 1e5};
constexpr Range kStage_ppm{-1e4, 1e4};
constexpr Range kSimHeight_um{-1e5, 1e5};
constexpr Range kScatter_um{0, 1e4};

Expected<void> read_panel(const TomlTable& table, SimConfig& sim) {
  const Range place{-kMaxPlace_mm, kMaxPlace_mm};
  PANELCAL_TRY(const auto offset_mm, table.pair("panel_offset_mm", place));
  if (offset_mm) sim.panel_offset = displacement_mm<frame::Actual>(*offset_mm);
  PANELCAL_TRY(const double rotation_mrad, table.number_or("panel_rotation_mrad", {-1e4, 1e4}, 0));
  sim.panel_rotation = rad(rotation_mrad * 1e-3);
  PANELCAL_TRY(const auto stretch_ppm, table.pair("stretch_ppm", kSimPpm));
  if (stretch_ppm) {
    sim.stretch_x_ppm = stretch_ppm->x();
    sim.stretch_y_ppm = stretch_ppm->y();
  }
  PANELCAL_TRY(const double offset_um, table.number_or("board_offset_sigma_um", {0, 1e5}, 0));
  sim.board_offset_sigma = um(offset_um);
  PANELCAL_TRY(const double sigma_mrad, table.number_or("board_rotation_sigma_mrad", {0, 1e3}, 0));
  sim.board_rotation_sigma = rad(sigma_mrad * 1e-3);
  PANELCAL_TRY(const auto spindle_mm, table.pair("spindle_camera_offset_mm", place));
  if (spindle_mm) sim.spindle_camera_offset = displacement_mm<frame::Machine>(*spindle_mm);
  return {};
}

Expected<void> read_picture_size(const TomlTable& table,
                                 const std::optional<CameraCalibration>& camera,
                                 SimConfig& sim) {
  if (camera) {
    sim.width_px = camera->picture_width_px;
    sim.height_px = camera->picture_height_px;
  }
  PANELCAL_TRY(const auto size, table.pair("picture_px", {16, kMaxPictureSide_px}));
  if (!size) return {};
  const auto is_whole = [](double v) { return v == std::floor(v); };
  if (!is_whole(size->x()) || !is_whole(size->y())) {
    return failure(table.problem("picture_px", "whole pixels"));
  }
  const Eigen::Vector2d calibrated(sim.width_px, sim.height_px);
  if (camera && *size != calibrated) {
    return failure(table.problem(
        "picture_px",
        fmt::format("[{}, {}], for which [camera] is calibrated", sim.width_px, sim.height_px)));
  }
  sim.width_px = static_cast<int>(size->x());
  sim.height_px = static_cast<int>(size->y());
  return {};
}

Expected<void> read_light(const TomlTable& table, SimConfig& sim) {
  // Below 0.3 px the renderer's quadrature would need far more nodes; no lens is that sharp.
  PANELCAL_TRY(sim.blur_px, table.number_or("blur_px", {0.3, 20}, sim.blur_px));
  PANELCAL_TRY(sim.noise, table.number_or("noise", {0, 255}, sim.noise));
  PANELCAL_TRY(sim.background, table.number_or("background", kSimShare, sim.background));
  PANELCAL_TRY(sim.target_level, table.number_or("target_level", kSimShare, sim.target_level));
  PANELCAL_TRY(sim.light_gradient, table.number_or("light_gradient", {-1, 1}, sim.light_gradient));
  PANELCAL_TRY(sim.light_gradient_y,
               table.number_or("light_gradient_y", {-1, 1}, sim.light_gradient_y));
  PANELCAL_TRY(sim.vignetting, table.number_or("vignetting", kSimShare, sim.vignetting));
  PANELCAL_TRY(sim.weave_amplitude,
               table.number_or("weave_amplitude", kSimShare, sim.weave_amplitude));
  PANELCAL_TRY(const auto neighbors, table.integer("neighbors", 0, 100));
  sim.neighbors = static_cast<int>(neighbors.value_or(0));
  if (sim.target_level <= sim.background) {
    return failure(
        table.has("target_level")
            ? table.problem("target_level",
                            fmt::format("more than background = {}", sim.background))
            : table.problem("background",
                            fmt::format("less than target_level = {}", sim.target_level)));
  }
  return {};
}

Expected<void> read_sensor(const TomlTable& table, SimConfig& sim) {
  PANELCAL_TRY(sim.shot_noise, table.number_or("shot_noise", {0, 100}, sim.shot_noise));
  PANELCAL_TRY(sim.hot_pixels, table.number_or("hot_pixels", {0, 0.1}, sim.hot_pixels));
  PANELCAL_TRY(const auto bits, table.integer("bit_depth", 8, 16));
  if (!bits) return {};
  if (*bits != 8 && *bits != 16) return failure(table.problem("bit_depth", "8 or 16"));
  sim.full_scale = *bits == 8 ? Image::kFullScale8 : Image::kFullScale16;
  return {};
}

/// Reads the errors of the board and its marks.
Expected<void> read_board(const TomlTable& table, SimConfig& sim) {
  PANELCAL_TRY(const double period_mm,
               table.number_or("weave_period_mm", {0.01, 100}, sim.weave_period.in_mm()));
  sim.weave_period = mm(period_mm);
  PANELCAL_TRY(const double burrs_um, table.number_or("burrs_um", {0, 1000}, 0));
  sim.burrs = um(burrs_um);
  PANELCAL_TRY(const double offset_um, table.number_or("ring_offset_sigma_um", {0, 1e4}, 0));
  sim.ring_offset_sigma = um(offset_um);
  PANELCAL_TRY(const auto slot_mm, table.number("slot_length_mm", {0, 1000, true}));
  if (slot_mm) sim.slot_length = mm(*slot_mm);
  PANELCAL_TRY(const double tilt_deg, table.number_or("tilt_deg", {0, 60}, 0));
  sim.tilt = deg(tilt_deg);
  PANELCAL_TRY(const double axis_deg, table.number_or("tilt_axis_deg", {-360, 360}, 0));
  sim.tilt_axis = deg(axis_deg);
  return {};
}

Expected<void> read_debris(const TomlTable& sim, DebrisOptions& debris) {
  PANELCAL_TRY(const auto table, sim.table("debris", "[sim.debris]", {kDebrisKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(debris.rim_share, table->number_or("rim_share", {0, 0.95}, debris.rim_share));
  PANELCAL_TRY(const double size_um, table->number_or("size_um", {10, 1e4}, debris.size.in_um()));
  debris.size = um(size_um);
  PANELCAL_TRY(debris.darkest, table->number_or("darkest", kSimShare, debris.darkest));
  PANELCAL_TRY(debris.brightest, table->number_or("brightest", kSimShare, debris.brightest));
  if (debris.brightest < debris.darkest) {
    const bool is_dark = table->has("darkest");
    return failure(table->problem(is_dark ? "darkest" : "brightest",
                                  is_dark ? fmt::format("at most brightest = {}", debris.brightest)
                                          : fmt::format("at least darkest = {}", debris.darkest)));
  }
  PANELCAL_TRY(const auto scratches, table->integer("scratches", 0, 100));
  debris.scratches = static_cast<int>(scratches.value_or(0));
  PANELCAL_TRY(const double width_um,
               table->number_or("scratch_width_um", {0, 1e4, true}, debris.scratch_width.in_um()));
  debris.scratch_width = um(width_um);
  PANELCAL_TRY(
      const double length_mm,
      table->number_or("scratch_length_mm", {0, 100, true}, debris.scratch_length.in_mm()));
  debris.scratch_length = mm(length_mm);
  return {};
}

/// Reads the effect of lamp and focus orders; without a word they do nothing.
Expected<void> read_lamp_and_focus(const TomlTable& table, SimConfig& sim) {
  PANELCAL_TRY(sim.lamp, table.number("lamp", {.low = 0, .low_is_open = true}));
  PANELCAL_TRY(const auto z_mm, table.number("focus_z_mm", {-kMaxPlace_mm, kMaxPlace_mm}));
  if (z_mm) sim.focus_z = mm(*z_mm);
  PANELCAL_TRY(const double depth_mm,
               table.number_or("focus_depth_mm", {0, 100, true}, sim.focus_depth.in_mm()));
  sim.focus_depth = mm(depth_mm);
  return {};
}

/// The real camera: a missing key is as calibrated.
Expected<void> read_sim_camera(const TomlTable& table,
                               const std::optional<CameraCalibration>& calibrated,
                               SimConfig& sim) {
  PANELCAL_TRY(const auto camera, table.table("camera", "[sim.camera]", {kSimCameraKeys, {}}));
  if (!camera) {
    if (!calibrated || !calibrated->needs_model()) return {};
    return failure(table.missing(
        "[sim.camera], and [camera] is calibrated with a tilt or a lens that is not simulated",
        "[sim.camera], and [sim] tilt_deg for a board that leans"));
  }
  if (!calibrated) {
    return failure(table.missing("[camera] to compare [sim.camera] with", "[camera] calibration"));
  }
  CameraMapping::Parameters real = calibrated->parameters;
  PANELCAL_TRY(real.scale_mm_per_px,
               camera->number_or("scale_mm_per_px", {0, 100, true}, real.scale_mm_per_px));
  PANELCAL_TRY(real.rotation_rad, camera->number_or("rotation_rad", {-10, 10}, real.rotation_rad));
  PANELCAL_TRY(real.k1_per_px2, camera->number_or("k1_per_px2", {-1, 1}, real.k1_per_px2));
  PANELCAL_TRY(const auto axis_px, camera->pair("axis_px", {-1e5, 1e5}));
  if (axis_px) real.axis_px = *axis_px;
  for (const double x_px : {-0.5, sim.width_px - 0.5}) {
    for (const double y_px : {-0.5, sim.height_px - 0.5}) {
      const double r2 = (Eigen::Vector2d(x_px, y_px) - real.axis_px).squaredNorm();
      if (1 + 3 * real.k1_per_px2 * r2 > 0) continue;
      const bool is_its_own = camera->has("k1_per_px2");
      const TomlTable& cause = is_its_own ? *camera : table;
      return failure(cause.problem(is_its_own ? "k1_per_px2" : "camera",
                                   "1 + 3 k1 r^2 above 0 everywhere in the picture",
                                   "the lens model folds over inside the picture"));
    }
  }
  sim.camera = real;
  return {};
}

/// Reads the mark that is fixed to its table.
Expected<void> read_sim_mark(const TomlTable& table, SimCouponOptions& coupon) {
  PANELCAL_TRY(const auto mark_mm, table.pair("mark_mm", {-kMaxPlace_mm, kMaxPlace_mm}));
  if (mark_mm) coupon.mark = position_mm<frame::Machine>(*mark_mm);
  PANELCAL_TRY(const auto tool, table.integer("mark_tool", 1, kMaxToolNumber));
  if (tool && !mark_mm) {
    return failure(table.problem("mark_tool", "mark_mm as well", "there is no mark to show"));
  }
  if (tool) coupon.mark_tool = static_cast<int>(*tool);
  return {};
}

/// Reads how its stage comes to rest, and how it warms up: without a word, at once and not at all.
Expected<void> read_sim_motion(const TomlTable& table, SimCouponOptions& coupon) {
  PANELCAL_TRY(const double swing_um, table.number_or("swing_um", kScatter_um, 0));
  coupon.swing = um(swing_um);
  PANELCAL_TRY(const double decay_s,
               table.number_or("swing_decay_s", {0, 3600, true}, coupon.swing_decay.in_s()));
  coupon.swing_decay = seconds(decay_s);
  PANELCAL_TRY(coupon.swing_hz, table.number_or("swing_hz", {0, 1e4}, coupon.swing_hz));
  PANELCAL_TRY(const auto cold_um, table.pair("cold_um", kSimHeight_um));
  if (cold_um) coupon.cold = displacement_mm<frame::Machine>(1e-3 * *cold_um);
  PANELCAL_TRY(const double warm_up_s,
               table.number_or("warm_up_s", {0, 1e6, true}, coupon.warm_up.in_s()));
  coupon.warm_up = seconds(warm_up_s);
  return {};
}

/// Reads the errors of its holes and stops: without a word, perfectly.
Expected<void> read_sim_coupon(const TomlTable& sim, SimCouponOptions& coupon) {
  PANELCAL_TRY(const auto table, sim.table("coupon", "[sim.coupon]", {kCouponKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const double wander_um, table->number_or("drill_wander_um", kScatter_um, 0));
  coupon.wander = um(wander_um);
  PANELCAL_TRY(const double stage_um, table->number_or("stage_repeatability_um", kScatter_um, 0));
  coupon.stage_repeatability = um(stage_um);
  PANELCAL_TRY(const auto backlash_um, table->pair("backlash_um", kScatter_um));
  if (backlash_um) coupon.backlash = displacement_mm<frame::Machine>(1e-3 * *backlash_um);
  PANELCAL_CHECK(read_sim_mark(*table, coupon));
  return read_sim_motion(*table, coupon);
}

/// Reads the errors of the stage.
Expected<void> read_sim_table(const TomlTable& sim, std::optional<SimTable>& out) {
  PANELCAL_TRY(const auto table, sim.table("table", "[sim.table]", {kSimTableKeys, {}}));
  if (!table) return {};
  SimTable& error = out.emplace();
  PANELCAL_TRY(const auto scale_ppm, table->pair("scale_ppm", kStage_ppm));
  if (scale_ppm) {
    error.scale_x_ppm = scale_ppm->x();
    error.scale_y_ppm = scale_ppm->y();
  }
  PANELCAL_TRY(const double urad, table->number_or("squareness_urad", kStage_ppm, 0));
  error.squareness = rad(urad * 1e-6);
  PANELCAL_TRY(const auto bow_um, table->pair("bow_um", {-1e4, 1e4}));
  if (bow_um) {
    error.bow_x = um(bow_um->x());
    error.bow_y = um(bow_um->y());
  }
  PANELCAL_TRY(const auto radius_mm, table->number("bow_radius_mm", {1, kMaxPlace_mm}));
  if (radius_mm) error.bow_radius = mm(*radius_mm);
  PANELCAL_TRY(const auto center_mm, table->pair("center_mm", {-kMaxPlace_mm, kMaxPlace_mm}));
  if (center_mm) error.center = position_mm<frame::Machine>(*center_mm);
  return {};
}

}  // namespace

Expected<std::optional<SimConfig>> read_sim_config(const TomlTable& top,
                                                   const std::optional<CameraCalibration>& camera,
                                                   Length surface_height) {
  PANELCAL_TRY(const auto table, top.table("sim", "[sim]", {kSimKeys, {}}));
  if (!table) return std::nullopt;
  SimConfig sim;
  PANELCAL_TRY(const auto seed,
               table->integer("seed", 0, std::numeric_limits<std::int64_t>::max()));
  if (seed) sim.seed = static_cast<std::uint64_t>(*seed);
  PANELCAL_CHECK(read_panel(*table, sim));
  PANELCAL_CHECK(read_picture_size(*table, camera, sim));
  PANELCAL_CHECK(read_light(*table, sim));
  PANELCAL_CHECK(read_sensor(*table, sim));
  PANELCAL_CHECK(read_board(*table, sim));
  PANELCAL_CHECK(read_debris(*table, sim.debris));
  PANELCAL_CHECK(read_lamp_and_focus(*table, sim));
  PANELCAL_CHECK(read_sim_camera(*table, camera, sim));
  sim.surface.seed = sim.seed;
  sim.surface.height = surface_height;
  sim.surface.noise_sigma = Length();
  PANELCAL_CHECK(read_sim_surface(*table, sim.surface));
  PANELCAL_CHECK(read_sim_table_surface(*table, sim.seed, sim.table_surface));
  sim.coupon.seed = sim.seed;
  PANELCAL_CHECK(read_sim_coupon(*table, sim.coupon));
  PANELCAL_CHECK(read_sim_table(*table, sim.table));
  return sim;
}

}  // namespace panelcal::internal
