// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <string_view>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/sections/target.h"
#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

constexpr Range kShare{0, 1};
constexpr Range kAboveZero{.low = 0, .low_is_open = true};
constexpr Range kDistance_mm{0, kMaxPlace_mm, true};

bool put_model(MachineConfig& config, const FieldValue& value) {
  WalkOptions& walk = config.walk;
  walk.chooses_model = value.text == "auto";
  walk.bends_panel = value.text == "smooth";
  if (walk.chooses_model || walk.bends_panel) return true;
  walk.model = panel_model_from_name(value.text);
  return walk.model.has_value();
}

bool put_algorithms(MachineConfig& config, const FieldValue& value) {
  config.vision.algorithms.clear();
  for (const double number : value.numbers) {
    if (number != std::floor(number)) return false;
    config.vision.algorithms.push_back(static_cast<int>(number));
  }
  return true;
}

std::optional<FourViews> four_views_from_word(std::string_view word) {
  if (word == "axes") return FourViews::Axes;
  if (word == "corners") return FourViews::Corners;
  return std::nullopt;
}

#include "machine/config/sections/vision.def"

Expected<void> check_optical(const TomlTable& vision, const WalkOptions& walk) {
  if (walk.sieb_meyer.measurement_mode == 4) {
    return failure(vision.problem("mode", "1, 2, 3 or 5"));
  }
  if (walk.sieb_meyer.fits_scale &&
      (walk.model == PanelModel::Offset || walk.model == PanelModel::Rigid)) {
    return failure(vision.problem(
        "scale", "model = \"similarity\" or a softer one", "the model has no scale"));
  }
  return {};
}

Expected<void> read_vision(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.read_table(kVision, config));
  if (!table) return {};
  PANELCAL_CHECK(check_optical(*table, config.walk));
  PANELCAL_CHECK(read_targets(*table, config));
  const bool is_stated = table->has("default_tool") && !config.vision_tools.empty();
  if (is_stated && !config.vision_tools.contains(config.walk.sieb_meyer.vision_tool)) {
    return failure(
        table->problem("default_tool", "the number of a [[vision.tool]]", "no tool has it"));
  }
  return {};
}

}  // namespace

Section vision_section() {
  return {kVisionTables, read_vision};
}

}  // namespace panelcal::internal
