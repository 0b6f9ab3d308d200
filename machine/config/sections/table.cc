// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/table.h"

#include <array>
#include <memory>
#include <string_view>
#include <utility>

#include "calib/table/calibration_file.h"

namespace panelcal::internal {
namespace {

constexpr std::array<std::string_view, 2> kTableKeys = {"calibration", "hold_mm"};
constexpr Range kHold_mm{0, 1000};

}  // namespace

Expected<void> read_table_config(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("table", "[table]", {kTableKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto file, table->text("calibration"));
  if (!file) return failure(table->missing("calibration", "calibration = \"NAME.cal.json\""));
  if (file->empty()) return failure(table->problem("calibration", "the name of a file"));
  PANELCAL_TRY(const double hold_mm, table->number_or("hold_mm", kHold_mm, 0));
  config.table_file = config.file.parent_path() / *file;
  PANELCAL_TRY(TableCalibration calibration, read_table_calibration(config.table_file));
  config.table_date = calibration.date;
  config.walk.uncertainty.table_map = calibration.sigma;
  config.walk.table = std::make_shared<const TableCorrection>(
      std::move(calibration.map), mm(hold_mm), config.table_file);
  return {};
}

}  // namespace panelcal::internal
