// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/machine_config.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/machine/program_config.h"
#include "panelcal/machine/sim_config.h"
#include "panelcal/machine/toml_table.h"

namespace panelcal {
namespace {

using internal::kMaxPlace_mm;
using internal::Range;
using internal::TomlKeys;
using internal::TomlSource;
using internal::TomlTable;
using Words = std::string_view;

constexpr std::array<Words, 10> kTopKeys = {"camera",
                                            "diameter_page",
                                            "gates",
                                            "machine",
                                            "program",
                                            "reference_scaling",
                                            "sim",
                                            "spindle",
                                            "surface",
                                            "vision"};
constexpr std::array<Words, 1> kTopPlanned = {"coupon"};
constexpr std::array<Words, 3> kMachineKeys = {"name", "travel_high_mm", "travel_low_mm"};
constexpr std::array<Words, 1> kMachinePlanned = {"drivers"};
constexpr std::array<Words, 11> kVisionKeys = {"ambiguity_margin",
                                               "cama",
                                               "default_tool",
                                               "min_contrast",
                                               "min_score",
                                               "mode",
                                               "model",
                                               "rotate",
                                               "scale",
                                               "search_radius_mm",
                                               "tool"};
constexpr std::array<Words, 1> kVisionPlanned = {"inspections"};
constexpr std::array<Words, 8> kToolKeys = {
    "inner_mm", "inner_px", "number", "polarity", "shape", "size_mm", "size_px", "size_tolerance"};
constexpr std::array<Words, 1> kToolPlanned = {"algorithm"};
constexpr std::array<Words, 5> kShapesPlanned = {"apriltag", "cross", "hole", "square", "template"};
constexpr std::array<Words, 1> kCameraKeys = {"calibration"};
constexpr std::array<Words, 2> kSpindleKeys = {"camera_offset_mm", "camera_offset_sigma_um"};
constexpr std::array<Words, 5> kGateKeys = {
    "nested", "offset_mm", "residual_um", "rotation_mrad", "stretch_ppm"};
constexpr std::array<Words, 4> kNestedGateKeys = {
    "offset_mm", "residual_um", "rotation_mrad", "stretch_ppm"};

constexpr Range kShare{0, 1};
constexpr Range kPlace{-kMaxPlace_mm, kMaxPlace_mm};
constexpr Range kAboveZero{.low = 0, .low_is_open = true};
constexpr Range kFromZero{.low = 0};
constexpr int kMaxSeries = 1000;
constexpr int kMaxToolNumber = 1'000'000;

Expected<void> read_machine(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table,
               top.table("machine", "[machine]", {kMachineKeys, kMachinePlanned}));
  if (!table) return {};
  PANELCAL_TRY(const auto name, table->text("name"));
  config.name = name.value_or("");
  return internal::read_travel(*table, config);
}

Expected<void> read_camera(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("camera", "[camera]", {kCameraKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto file, table->text("calibration"));
  if (!file) return failure(table->missing("calibration", "calibration = \"NAME.cal.json\""));
  if (file->empty()) return failure(table->problem("calibration", "the name of a file"));
  PANELCAL_TRY(config.camera, read_camera_calibration(config.file.parent_path() / *file));
  return {};
}

Expected<void> read_spindle(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("spindle", "[spindle]", {kSpindleKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto offset_mm, table->pair("camera_offset_mm", kPlace));
  if (offset_mm) config.spindle_camera.offset = displacement_mm<frame::Machine>(*offset_mm);
  PANELCAL_TRY(const double sigma_um, table->number_or("camera_offset_sigma_um", {0, 1e6}, 0));
  const double sigma_mm = um(sigma_um).in_mm();
  config.spindle_camera.cov_mm2 = sigma_mm * sigma_mm * Eigen::Matrix2d::Identity();
  return {};
}

/// A limit that is left out keeps what `limits` already has.
Expected<void> read_limits(const TomlTable& table, GateLimits& limits) {
  PANELCAL_TRY(const auto residual_um, table.number("residual_um", kFromZero));
  if (residual_um) limits.residual = um(*residual_um);
  PANELCAL_TRY(const auto rotation_mrad, table.number("rotation_mrad", kFromZero));
  if (rotation_mrad) limits.rotation = rad(*rotation_mrad * 1e-3);
  PANELCAL_TRY(const auto stretch_ppm, table.number("stretch_ppm", kFromZero));
  if (stretch_ppm) limits.stretch_ppm = *stretch_ppm;
  PANELCAL_TRY(const auto offset_mm, table.number("offset_mm", kFromZero));
  if (offset_mm) limits.offset = mm(*offset_mm);
  return {};
}

Expected<void> read_gates(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("gates", "[gates]", {kGateKeys, {}}));
  if (!table) return {};
  PANELCAL_CHECK(read_limits(*table, config.walk.base_limits));
  config.walk.nested_limits = config.walk.base_limits;
  PANELCAL_TRY(const auto nested, table->table("nested", "[gates.nested]", {kNestedGateKeys, {}}));
  if (!nested) return {};
  return read_limits(*nested, config.walk.nested_limits);
}

Expected<void> read_model(const TomlTable& vision, WalkOptions& walk) {
  PANELCAL_TRY(const auto model, vision.text("model"));
  if (!model || *model == "auto") return {};
  walk.model = panel_model_from_name(*model);
  if (walk.model) return {};
  return failure(vision.problem(
      "model", "\"auto\", \"offset\", \"rigid\", \"similarity\", \"stretch\" or \"affine\""));
}

Expected<Shape> read_shape(const TomlTable& table) {
  PANELCAL_TRY(const auto word, table.text("shape"));
  if (!word) return failure(table.missing("shape", "shape = \"disc\" or \"ring\""));
  if (const auto shape = shape_from_name(*word)) return *shape;
  if (std::ranges::find(kShapesPlanned, *word) != kShapesPlanned.end()) {
    return failure(table.not_supported("shape", "\"disc\" or \"ring\""));
  }
  return failure(table.problem("shape", "\"disc\" or \"ring\""));
}

Expected<void> read_sizes(const TomlTable& table, bool has_camera, Target& target) {
  PANELCAL_TRY(const auto size_mm, table.number("size_mm", kAboveZero));
  PANELCAL_TRY(const auto size_px, table.number("size_px", kAboveZero));
  PANELCAL_TRY(const auto inner_mm, table.number("inner_mm", kAboveZero));
  PANELCAL_TRY(const auto inner_px, table.number("inner_px", kAboveZero));
  if (!size_mm && !size_px) {
    return failure(table.missing("size", "size_mm, the outer diameter (size_px without [camera])"));
  }
  if (size_mm && size_px) {
    return failure(table.problem("size_px", "one of the two", "size_mm is given as well"));
  }
  if (size_mm && !has_camera) {
    return failure(table.problem(
        "size_mm", "[camera] calibration, or size_px", "pictures are not in mm without a camera"));
  }
  const std::string_view inner_key = inner_mm ? "inner_mm" : "inner_px";
  if (inner_mm || inner_px) {
    if (target.shape != Shape::Ring) {
      return failure(table.problem(inner_key, "none", "only rings have an inner diameter"));
    }
    if ((inner_mm && !size_mm) || (inner_px && !size_px)) {
      return failure(table.problem(inner_key, "both sizes in the same unit"));
    }
    if ((inner_mm && *inner_mm >= *size_mm) || (inner_px && *inner_px >= *size_px)) {
      return failure(table.problem(inner_key, "less than the outer diameter"));
    }
  }
  if (size_mm) target.size = mm(*size_mm);
  if (size_px) target.size_px = px(*size_px);
  if (inner_mm) target.inner_size = mm(*inner_mm);
  if (inner_px) target.inner_size_px = px(*inner_px);
  return {};
}

Expected<Target> read_tool(const TomlTable& table, bool has_camera) {
  Target target;
  PANELCAL_TRY(const auto number, table.integer("number", 1, kMaxToolNumber));
  if (!number) return failure(table.missing("number", "number = 1, as in G34,1"));
  target.number = static_cast<int>(*number);
  PANELCAL_TRY(target.shape, read_shape(table));
  PANELCAL_CHECK(read_sizes(table, has_camera, target));
  PANELCAL_TRY(const auto polarity, table.text("polarity"));
  if (polarity) {
    const auto known = polarity_from_name(*polarity);
    if (!known) return failure(table.problem("polarity", "\"bright\" or \"dark\""));
    target.polarity = *known;
  }
  PANELCAL_TRY(target.size_tolerance,
               table.number_or("size_tolerance", {0, 0.5, true}, target.size_tolerance));
  PANELCAL_CHECK(target.validate());
  return target;
}

/// How G32, G33 and G36 of SIEB & MEYER programs measure.
Expected<void> read_optical(const TomlTable& vision, sieb_meyer::Settings& settings) {
  PANELCAL_TRY(const auto mode, vision.integer("mode", 1, 5));
  if (mode == 4) return failure(vision.problem("mode", "1, 2, 3 or 5"));
  if (mode) settings.measurement_mode = static_cast<int>(*mode);
  PANELCAL_TRY(const auto cama, vision.truth("cama"));
  settings.pattern_mode = cama.value_or(settings.pattern_mode);
  PANELCAL_TRY(const auto scale, vision.truth("scale"));
  settings.fits_scale = scale.value_or(settings.fits_scale);
  PANELCAL_TRY(const auto tool, vision.integer("default_tool", 1, kMaxToolNumber));
  if (tool) settings.vision_tool = static_cast<int>(*tool);
  return {};
}

Expected<void> read_vision(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("vision", "[vision]", {kVisionKeys, kVisionPlanned}));
  if (!table) return {};
  PANELCAL_TRY(const auto rotate, table->integer("rotate", 1, kMaxSeries));
  if (rotate) config.walk.series_size = static_cast<int>(*rotate);
  PANELCAL_CHECK(read_model(*table, config.walk));
  PANELCAL_CHECK(read_optical(*table, config.walk.sieb_meyer));
  PANELCAL_TRY(const auto radius_mm, table->number("search_radius_mm", {0, kMaxPlace_mm, true}));
  if (radius_mm) config.search_radius = mm(*radius_mm);
  LocateOptions& locate = config.locate;
  PANELCAL_TRY(locate.min_score, table->number_or("min_score", kShare, locate.min_score));
  PANELCAL_TRY(locate.min_contrast, table->number_or("min_contrast", kShare, locate.min_contrast));
  PANELCAL_TRY(locate.ambiguity_margin,
               table->number_or("ambiguity_margin", kShare, locate.ambiguity_margin));

  PANELCAL_TRY(const auto tools,
               table->tables("tool", "[[vision.tool]]", {kToolKeys, kToolPlanned}));
  for (const TomlTable& tool : tools) {
    PANELCAL_TRY(const Target target, read_tool(tool, config.camera.has_value()));
    if (!config.vision_tools.emplace(target.number, target).second) {
      return failure(tool.problem("number", "each number once", "another tool has it"));
    }
  }
  return {};
}

}  // namespace

Expected<MachineConfig> parse_machine_config(std::string_view text,
                                             const std::filesystem::path& file) {
  const TomlSource source{file.string(), text};
  PANELCAL_TRY(const toml::table document, internal::parse_toml(source));
  PANELCAL_TRY(const TomlTable top,
               TomlTable::make(
                   document, "machine.toml", document.source(), {kTopKeys, kTopPlanned}, source));
  MachineConfig config;
  config.file = file;
  PANELCAL_CHECK(read_machine(top, config));
  PANELCAL_CHECK(read_camera(top, config));
  PANELCAL_CHECK(read_spindle(top, config));
  PANELCAL_CHECK(read_vision(top, config));
  PANELCAL_CHECK(read_gates(top, config));
  PANELCAL_CHECK(internal::read_program_config(top, config));
  PANELCAL_TRY(
      config.sim,
      internal::read_sim_config(top, config.camera, config.walk.sieb_meyer.surface_height));
  return config;
}

Expected<MachineConfig> read_machine_config(const std::filesystem::path& file) {
  PANELCAL_TRY(const std::string text, read_file(file, kMaxConfigBytes));
  return parse_machine_config(text, file);
}

}  // namespace panelcal
