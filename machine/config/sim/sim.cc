// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <limits>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/sim/surface.h"
#include "machine/config/toml/ranges.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr Range kSimShare{0, 1};
constexpr Range kStage_ppm{-1e4, 1e4};
constexpr Range kScatter_um{0, 1e4};

bool put_bit_depth(SimConfig& sim, const FieldValue& value) {
  sim.full_scale = value.whole == 8 ? Image::kFullScale8 : Image::kFullScale16;
  return value.whole == 8 || value.whole == 16;
}

bool put_picture_size(SimConfig& sim, const FieldValue& value) {
  sim.width_px = static_cast<int>(value.numbers[0]);
  sim.height_px = static_cast<int>(value.numbers[1]);
  return sim.width_px == value.numbers[0] && sim.height_px == value.numbers[1];
}

#include "machine/config/sim/sim.def"

Expected<void> check_picture_size(const TomlTable& table,
                                  const std::optional<CameraCalibration>& camera,
                                  const SimConfig& sim) {
  if (!camera ||
      (sim.width_px == camera->picture_width_px && sim.height_px == camera->picture_height_px)) {
    return {};
  }
  return failure(table.problem("picture_px",
                               fmt::format("[{}, {}], for which [camera] is calibrated",
                                           camera->picture_width_px,
                                           camera->picture_height_px)));
}

Expected<void> check_light(const TomlTable& table, const SimConfig& sim) {
  if (sim.target_level > sim.background) return {};
  return failure(
      table.has("target_level")
          ? table.problem("target_level", fmt::format("more than background = {}", sim.background))
          : table.problem("background",
                          fmt::format("less than target_level = {}", sim.target_level)));
}

Expected<void> read_debris(const TomlTable& sim, DebrisOptions& debris) {
  PANELCAL_TRY(const auto table, sim.read_table(kDebris, debris));
  if (!table || debris.brightest >= debris.darkest) return {};
  const bool is_dark = table->has("darkest");
  return failure(table->problem(is_dark ? "darkest" : "brightest",
                                is_dark ? fmt::format("at most brightest = {}", debris.brightest)
                                        : fmt::format("at least darkest = {}", debris.darkest)));
}

/// The real camera: a missing key is as calibrated.
Expected<void> read_sim_camera(const TomlTable& table,
                               const std::optional<CameraCalibration>& calibrated,
                               SimConfig& sim) {
  CameraMapping::Parameters real =
      calibrated ? calibrated->parameters : CameraMapping::Parameters();
  PANELCAL_TRY(const auto camera, table.table(kLens));
  if (!camera) {
    if (!calibrated || !calibrated->needs_model()) return {};
    return failure(table.missing(
        "[sim.camera], and [camera] is calibrated with a tilt or a lens that is not simulated",
        "[sim.camera], and [sim] tilt_deg for a board that leans"));
  }
  if (!calibrated) {
    return failure(table.missing("[camera] to compare [sim.camera] with", "[camera] calibration"));
  }
  PANELCAL_CHECK(camera->read(kLens, real));
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

Expected<void> read_sim_coupon(const TomlTable& sim, SimCouponOptions& coupon) {
  PANELCAL_TRY(const auto table, sim.read_table(kSimCoupon, coupon));
  if (!table || coupon.mark || !table->has("mark_tool")) return {};
  return failure(table->problem("mark_tool", "mark_mm as well", "there is no mark to show"));
}

/// Precondition: [camera] and [surface] have been read
Expected<void> read_sim(const TomlTable& top, MachineConfig& config) {
  const std::optional<CameraCalibration>& camera = config.camera;
  SimConfig sim;
  if (camera) {
    sim.width_px = camera->picture_width_px;
    sim.height_px = camera->picture_height_px;
  }
  PANELCAL_TRY(const auto table, top.read_table(kSim, sim));
  if (!table) return {};
  PANELCAL_CHECK(check_picture_size(*table, camera, sim));
  PANELCAL_CHECK(check_light(*table, sim));
  PANELCAL_CHECK(read_debris(*table, sim.debris));
  PANELCAL_CHECK(read_sim_camera(*table, camera, sim));
  sim.surface.seed = sim.seed;
  sim.surface.height = config.walk.sieb_meyer.surface_height;
  sim.surface.noise_sigma = Length();
  PANELCAL_CHECK(read_sim_surface(*table, sim.surface));
  PANELCAL_CHECK(read_sim_table_surface(*table, sim.seed, sim.table_surface));
  sim.coupon.seed = sim.seed;
  PANELCAL_CHECK(read_sim_coupon(*table, sim.coupon));
  SimTable stage;
  PANELCAL_TRY(const auto stage_table, table->read_table(kSimTable, stage));
  if (stage_table) sim.table = stage;
  config.sim = sim;
  return {};
}

}  // namespace

Section sim_section() {
  return {kSimTables, read_sim};
}

}  // namespace panelcal::internal
