// SPDX-License-Identifier: Apache-2.0
#include "machine/config/machine_config.h"

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/config/nightly/coupon.h"
#include "machine/config/nightly/nightly.h"
#include "machine/config/sections/gcode.h"
#include "machine/config/sections/program.h"
#include "machine/config/sections/spindle.h"
#include "machine/config/sections/stage.h"
#include "machine/config/sections/table.h"
#include "machine/config/sections/target.h"
#include "machine/config/sections/tolerance.h"
#include "machine/config/sections/uncertainty.h"
#include "machine/config/sections/vision.h"
#include "machine/config/sim/sim.h"
#include "machine/config/toml/ranges.h"
#include "machine/config/toml/required_keys.h"
#include "machine/config/toml/toml_table.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::kMaxToolNumber;
using internal::Range;
using internal::TomlKeys;
using internal::TomlSource;
using internal::TomlTable;
using Words = std::string_view;

constexpr std::array<Words, 18> kMachineFileKeys = {"camera",
                                                    "coupon",
                                                    "depth",
                                                    "diameter_page",
                                                    "gates",
                                                    "gcode",
                                                    "ledger",
                                                    "machine",
                                                    "nightly",
                                                    "program",
                                                    "reference_scaling",
                                                    "sim",
                                                    "spindle",
                                                    "surface",
                                                    "table",
                                                    "tolerance",
                                                    "uncertainty",
                                                    "vision"};
constexpr std::array<Words, 11> kMachineKeys = {"command_limit_s",
                                                "drill_command",
                                                "focus_command",
                                                "lamp_command",
                                                "name",
                                                "probe_command",
                                                "settle_s",
                                                "stage_command",
                                                "travel_high_mm",
                                                "travel_low_mm",
                                                "zoom_command"};
constexpr std::array<Words, 1> kMachinePlanned = {"drivers"};
constexpr std::array<Words, 22> kVisionKeys = {"algorithms",
                                               "ambiguity_margin",
                                               "cama",
                                               "default_tool",
                                               "four_view_limit_um",
                                               "four_views",
                                               "inspections",
                                               "max_blur_px",
                                               "max_clipped",
                                               "max_lobes",
                                               "max_oval",
                                               "max_roughness",
                                               "min_contrast",
                                               "min_score",
                                               "min_visible",
                                               "mode",
                                               "model",
                                               "rotate",
                                               "scale",
                                               "search_area_mm",
                                               "search_radius_mm",
                                               "tool"};
constexpr std::array<Words, 8> kCameraKeys = {
    "bayer", "bits", "calibration", "focus_mm", "focus_range_mm", "lamp", "patience_s", "zoom"};
constexpr std::array<Words, 9> kGateKeys = {"false_alarm",
                                            "max_dropped",
                                            "mirror",
                                            "nested",
                                            "offset_mm",
                                            "residual_um",
                                            "rotation_mrad",
                                            "stretch_ppm",
                                            "turned_deg"};
constexpr std::array<Words, 7> kNestedGateKeys = {"false_alarm",
                                                  "max_dropped",
                                                  "mirror",
                                                  "offset_mm",
                                                  "residual_um",
                                                  "rotation_mrad",
                                                  "stretch_ppm"};

constexpr Range kGateShare{0, 1};
constexpr Range kAboveZero{.low = 0, .low_is_open = true};
/// A limit of 0 holds every panel: nothing measured is without error. More than a metre, half a
/// turn or a tenth is no limit, but a wrong unit: "off" is one.
constexpr Range kRotation_mrad{.low = 0, .high = 3142, .low_is_open = true};
constexpr Range kStretch_ppm{.low = 0, .high = 1e5, .low_is_open = true};
constexpr Range kOffset_mm{.low = 0, .high = internal::kMaxPlace_mm, .low_is_open = true};
constexpr Range kFalseAlarm{.low = 0, .high = 0.5, .low_is_open = true};
constexpr int kMaxSeries = 1000;

Expected<void> read_machine(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table,
               top.table("machine", "[machine]", {kMachineKeys, kMachinePlanned}));
  if (!table) return {};
  PANELCAL_TRY(const auto name, table->text("name"));
  config.name = name.value_or("");
  PANELCAL_CHECK(internal::read_stage_config(*table, config));
  return internal::read_travel(*table, config);
}

Expected<void> read_camera(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("camera", "[camera]", {kCameraKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto file, table->text("calibration"));
  if (!file) return failure(table->missing("calibration", "calibration = \"NAME.cal.json\""));
  if (file->empty()) return failure(table->problem("calibration", "the name of a file"));
  config.camera_file = config.file.parent_path() / *file;
  PANELCAL_TRY(config.camera, read_camera_calibration(config.camera_file));
  PANELCAL_TRY(const double patience_s,
               table->number_or("patience_s", {0, 3600}, config.camera_patience.in_s()));
  config.camera_patience = seconds(patience_s);
  PANELCAL_TRY(const auto bayer, table->text("bayer"));
  PANELCAL_TRY(const auto bits, table->integer("bits", 9, 16));
  if (bits) config.picture_form.bits = static_cast<int>(*bits);
  if (bayer) {
    config.picture_form.bayer = bayer_pattern_from_name(*bayer);
    if (!config.picture_form.bayer) {
      return failure(table->problem("bayer", "\"RG\", \"GR\", \"GB\" or \"BG\""));
    }
  }
  return internal::read_zoom_and_focus(*table, config);
}

/// A number sets the limit, "off" takes it away; a key that is left out keeps what it has.
template <class Limit, class Unit>
Expected<void> read_limit(const TomlTable& table,
                          std::string_view key,
                          const Range& range,
                          Unit unit,
                          std::optional<Limit>& limit) {
  if (table.is_off(key)) {
    limit.reset();
    return {};
  }
  const auto number = table.number(key, range);
  if (!number) return failure(table.problem(key, range.text() + ", or \"off\""));
  if (*number) limit = unit(**number);
  return {};
}

Expected<void> read_limits(const TomlTable& table, GateLimits& limits) {
  const auto mrad = [](double value) { return rad(value * 1e-3); };
  PANELCAL_CHECK(read_limit(table, "residual_um", internal::kAboveZero_um, um, limits.residual));
  PANELCAL_CHECK(read_limit(table, "rotation_mrad", kRotation_mrad, mrad, limits.rotation));
  PANELCAL_CHECK(
      read_limit(table, "stretch_ppm", kStretch_ppm, std::identity(), limits.stretch_ppm));
  PANELCAL_CHECK(read_limit(table, "offset_mm", kOffset_mm, mm, limits.offset));
  PANELCAL_CHECK(
      read_limit(table, "false_alarm", kFalseAlarm, std::identity(), limits.false_alarm));
  PANELCAL_TRY(const auto mirror, table.text("mirror"));
  if (mirror && *mirror != "off" && *mirror != "refused") {
    return failure(table.problem("mirror", "\"refused\" or \"off\""));
  }
  if (mirror) limits.refuses_mirror = *mirror == "refused";
  PANELCAL_TRY(const auto max_dropped, table.integer("max_dropped", 0, kMaxSeries));
  if (max_dropped) limits.max_dropped = static_cast<int>(*max_dropped);
  return {};
}

Expected<void> read_gates(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("gates", "[gates]", {kGateKeys, {}}));
  if (!table) return {};
  PANELCAL_CHECK(read_limits(*table, config.walk.base_limits));
  if (!config.walk.base_limits.refuses_mirror && config.walk.bends_panel) {
    return failure(table->problem(
        "mirror", "\"refused\", or another model", "model = \"smooth\" fits no turned panel"));
  }
  config.walk.nested_limits = config.walk.base_limits;
  // A board lies on its panel as the program says, whichever way that lies.
  config.walk.nested_limits.refuses_mirror = true;
  PANELCAL_TRY(const auto turned_deg, table->integer("turned_deg", 0, 270));
  if (turned_deg && *turned_deg % 90 != 0) {
    return failure(table->problem("turned_deg", "0, 90, 180 or 270"));
  }
  config.walk.base_limits.turned_deg = static_cast<int>(turned_deg.value_or(0));
  PANELCAL_TRY(const auto nested, table->table("nested", "[gates.nested]", {kNestedGateKeys, {}}));
  if (!nested) return {};
  return read_limits(*nested, config.walk.nested_limits);
}

Expected<void> read_model(const TomlTable& vision, WalkOptions& walk) {
  PANELCAL_TRY(const auto model, vision.text("model"));
  if (!model) return {};
  const std::string_view word(*model);
  walk.chooses_model = word == "auto";
  walk.bends_panel = word == "smooth";
  if (walk.chooses_model || walk.bends_panel) return {};
  walk.model = panel_model_from_name(word);
  if (walk.model) return {};
  return failure(vision.problem(
      "model",
      "\"auto\", \"offset\", \"rigid\", \"similarity\", \"stretch\", \"affine\" or \"smooth\""));
}

/// Settings of the measurements of G32, G33 and G36 of SIEB & MEYER programs.
Expected<void> read_optical(const TomlTable& vision, WalkOptions& walk) {
  sieb_meyer::Settings& settings = walk.sieb_meyer;
  PANELCAL_TRY(const auto mode, vision.integer("mode", 1, 5));
  if (mode == 4) return failure(vision.problem("mode", "1, 2, 3 or 5"));
  if (mode) settings.measurement_mode = static_cast<int>(*mode);
  PANELCAL_TRY(const auto cama, vision.truth("cama"));
  settings.pattern_mode = cama.value_or(settings.pattern_mode);
  PANELCAL_TRY(const auto scale, vision.truth("scale"));
  settings.fits_scale = scale.value_or(settings.fits_scale);
  if (settings.fits_scale &&
      (walk.model == PanelModel::Offset || walk.model == PanelModel::Rigid)) {
    return failure(vision.problem(
        "scale", "model = \"similarity\" or a softer one", "the model has no scale"));
  }
  PANELCAL_TRY(const auto tool, vision.integer("default_tool", 1, kMaxToolNumber));
  if (tool) settings.vision_tool = static_cast<int>(*tool);
  return {};
}

Expected<void> read_vision(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("vision", "[vision]", {kVisionKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto rotate, table->integer("rotate", 1, kMaxSeries));
  if (rotate) config.walk.series_size = static_cast<int>(*rotate);
  PANELCAL_TRY(const auto inspections, table->integer("inspections", 1, kMaxInspections));
  if (inspections) config.walk.inspections = static_cast<int>(*inspections);
  PANELCAL_CHECK(read_model(*table, config.walk));
  PANELCAL_CHECK(read_optical(*table, config.walk));
  PANELCAL_CHECK(internal::read_vision_options(*table, config.vision));
  LocateOptions& locate = config.locate;
  PANELCAL_TRY(locate.min_score, table->number_or("min_score", kGateShare, locate.min_score));
  PANELCAL_TRY(locate.min_contrast,
               table->number_or("min_contrast", kGateShare, locate.min_contrast));
  PANELCAL_TRY(locate.min_visible, table->number_or("min_visible", kGateShare, locate.min_visible));
  PANELCAL_TRY(locate.max_blur_px, table->number_or("max_blur_px", kAboveZero, locate.max_blur_px));
  PANELCAL_TRY(locate.max_clipped, table->number_or("max_clipped", kGateShare, locate.max_clipped));
  PANELCAL_TRY(locate.max_lobes, table->number_or("max_lobes", kGateShare, locate.max_lobes));
  PANELCAL_TRY(locate.max_oval, table->number_or("max_oval", kGateShare, locate.max_oval));
  PANELCAL_TRY(locate.max_roughness,
               table->number_or("max_roughness", kGateShare, locate.max_roughness));
  PANELCAL_TRY(locate.ambiguity_margin,
               table->number_or("ambiguity_margin", kGateShare, locate.ambiguity_margin));

  PANELCAL_TRY(const auto tools, table->tables("tool", "[[vision.tool]]", internal::kTargetKeys));
  for (const TomlTable& tool : tools) {
    PANELCAL_TRY(const Target target,
                 internal::read_target(tool, config.camera, config.file.parent_path()));
    if (!config.vision_tools.emplace(target.number, target).second) {
      return failure(tool.problem("number", "each number once", "another tool has it"));
    }
  }
  const bool is_stated = table->has("default_tool");
  if (is_stated && !tools.empty() &&
      !config.vision_tools.contains(config.walk.sieb_meyer.vision_tool)) {
    return failure(
        table->problem("default_tool", "the number of a [[vision.tool]]", "no tool has it"));
  }
  return {};
}

Expected<MachineConfig> read_sections(const TomlTable& top, const std::filesystem::path& file) {
  MachineConfig config;
  config.file = file;
  PANELCAL_CHECK(read_machine(top, config));
  PANELCAL_CHECK(read_camera(top, config));
  PANELCAL_CHECK(internal::read_spindle_config(top, config));
  PANELCAL_CHECK(internal::read_ledger_config(top, config));
  PANELCAL_CHECK(internal::read_table_config(top, config));
  PANELCAL_CHECK(internal::read_uncertainty_config(top, config));
  PANELCAL_TRY(config.coupon, internal::read_coupon_config(top, file.parent_path()));
  config.walk.has_coupon = config.coupon && config.camera;
  config.walk.moves_offset = config.camera.has_value();
  PANELCAL_TRY(config.nightly, internal::read_nightly_config(top, file.parent_path()));
  PANELCAL_CHECK(read_vision(top, config));
  PANELCAL_CHECK(read_gates(top, config));
  PANELCAL_TRY(config.walk.tolerances, internal::read_tolerances(top));
  PANELCAL_TRY(config.gcode, internal::read_gcode_config(top));
  PANELCAL_CHECK(internal::read_program_config(top, config));
  PANELCAL_TRY(
      config.sim,
      internal::read_sim_config(top, config.camera, config.walk.sieb_meyer.surface_height));
  return config;
}

}  // namespace

Expected<MachineConfig> parse_machine_config(std::string_view text,
                                             const std::filesystem::path& file) {
  const TomlSource source{file.string(), text};
  PANELCAL_TRY(const toml::table document, internal::parse_toml(source));
  PANELCAL_TRY(
      const TomlTable top,
      TomlTable::make(document, "machine.toml", document.source(), {kMachineFileKeys, {}}, source));
  Expected<MachineConfig> config = read_sections(top, file);
  if (config) return config;
  return failure(internal::with_all_missing_keys(std::move(config).error(), document, source));
}

Expected<MachineConfig> read_machine_config(const std::filesystem::path& file) {
  PANELCAL_TRY(const std::string text, read_file(file, kMaxConfigBytes));
  return parse_machine_config(text, file);
}

}  // namespace panelcal
