// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <memory>
#include <utility>

#include "calib/base/fields/slots.h"
#include "calib/table/calibration_file.h"
#include "machine/config/sections/sections.h"

namespace panelcal::internal {
namespace {

struct TableKeys {
  std::filesystem::path calibration;
  Length hold;
};

#include "machine/config/sections/table.def"

Expected<void> read_stage_table(const TomlTable& top, MachineConfig& config) {
  TableKeys keys;
  PANELCAL_TRY(const auto table, top.read_table(kTable, keys));
  if (!table) return {};
  config.table_file = keys.calibration;
  PANELCAL_TRY(TableCalibration calibration, read_table_calibration(config.table_file));
  config.table_date = calibration.date;
  config.walk.uncertainty.table_map = calibration.sigma;
  config.walk.table = std::make_shared<const TableCorrection>(
      std::move(calibration.map), keys.hold, config.table_file);
  return {};
}

}  // namespace

Section table_section() {
  return {kTableTables, read_stage_table};
}

}  // namespace panelcal::internal
