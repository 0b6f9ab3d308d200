// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/table/linuxcnc_export.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/calibrate/table/run.h"
#include "machine/plate/pictures.h"
#include "tools/calibrate/session.h"
#include "tools/cli/output_paths.h"
#include "tools/figures/arrow_plot.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal::calibrate {
namespace {

constexpr int kArrowsPerSide = 15;

/// The map's error at places all over its rectangle.
std::string table_svg(const TableRun& run) {
  const TableGrid& grid = run.fit.map.grid();
  ArrowPlot plot;
  plot.title = run.fit.summary();
  plot.place_unit = "mm";
  plot.arrow_unit = "um";
  plot.low = grid.low_mm;
  plot.high = grid.high_mm;
  for (int j = 0; j < kArrowsPerSide; ++j) {
    for (int i = 0; i < kArrowsPerSide; ++i) {
      const Eigen::Vector2d part = Eigen::Vector2d(i, j) / (kArrowsPerSide - 1.0);
      const Eigen::Vector2d at_mm = grid.low_mm + part.cwiseProduct(grid.high_mm - grid.low_mm);
      const auto place = position_mm<frame::Machine>(at_mm);
      plot.arrows.push_back({at_mm, 1e3 * run.fit.map.error_mm(place)});
    }
  }
  return arrow_svg(plot);
}

constexpr std::string_view kHalFile = "panelcal.hal";
constexpr std::array<std::string_view, 2> kCompFiles = {"joint0.comp", "joint1.comp"};

/// They are outputs as those that the command line names.
Expected<void> check_linuxcnc(const std::string& folder, const CommandContext& context) {
  if (folder.empty()) return {};
  for (const std::string_view name : {kHalFile, kCompFiles[0], kCompFiles[1]}) {
    const std::filesystem::path file = std::filesystem::path(folder) / name;
    PANELCAL_CHECK(check_output(context.options, context.files, file));
  }
  return {};
}

/// panelcal.hal and the compensation files of the first two joints.
Expected<std::string> write_linuxcnc(const std::string& folder, const TableRun& run) {
  PANELCAL_TRY(const LinuxcncCorrection correction, linuxcnc_correction(run.fit.map, {}));
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder)) {
    return failure({Code::DeviceWrite,
                    {folder, 0, 0},
                    "cannot create the folder: " +
                        (error ? error.message() : std::string("a file has its name")),
                    ""});
  }
  const std::filesystem::path to(folder);
  PANELCAL_CHECK(write_file(to / kHalFile, correction.hal));
  PANELCAL_CHECK(write_file(to / kCompFiles[0], correction.comp_file[0]));
  PANELCAL_CHECK(write_file(to / kCompFiles[1], correction.comp_file[1]));
  return fmt::format("  LinuxCNC files leave {:.2f} um rms of it, {:.2f} um at most\n",
                     1e3 * correction.left_rms_mm,
                     1e3 * correction.left_largest_mm);
}

/// machine.toml names the file that the map was written to.
bool is_applied(const CalibrateOptions& options, const MachineConfig& config, bool is_written) {
  if (!is_written || config.table_file.empty()) return false;
  std::error_code ignored;
  return std::filesystem::equivalent(config.table_file, options.output, ignored);
}

/// A calibration of the table is meant to move holes.
std::string applied_line(const CalibrateOptions& options,
                         const MachineConfig& config,
                         bool is_applied) {
  if (is_applied) {
    return std::string("  [table] names this file: panelcal looks and drills by this map") +
           (options.linuxcnc.empty() ? "" : ", and the control is not to correct by it as well") +
           "\n";
  }
  if (!config.table_file.empty()) {
    return fmt::format("  panelcal looks and drills by another map, {} ([table] calibration)\n",
                       config.table_file.string());
  }
  return "  panelcal does not apply this map: name it in machine.toml ([table] calibration), or "
         "let "
         "the control correct by it (--linuxcnc), not both\n";
}

nlohmann::ordered_json table_json(const TableRun& run,
                                  const std::string& calibration,
                                  const Session& session,
                                  bool is_applied) {
  nlohmann::ordered_json json;
  json["calibration"] = nlohmann::ordered_json::parse(calibration);
  json["looks"] = run.sights.data.seen.size();
  json["poses"] = run.fit.poses.size();
  json["chi_square"] = run.fit.chi_square;
  json["degrees_of_freedom"] = run.fit.degrees_of_freedom;
  json["excess"] = run.excess;
  json["left_out"] = run.left_out;
  json["pictures_left_out"] = nlohmann::ordered_json::array();
  for (const MissedPicture& picture : run.sights.left_out) {
    json["pictures_left_out"].push_back({{"picture", picture.picture}, {"reason", picture.reason}});
  }
  json["pictures_without_tag"] = run.sights.without_tag;
  json["applied"] = is_applied;
  session.put_verdict(json);
  json["residuals_mm"] = nlohmann::ordered_json::array();
  for (const auto& residual : run.fit.residuals) {
    json["residuals_mm"].push_back({residual.in_mm().x(), residual.in_mm().y()});
  }
  return json;
}

/// From pictures through the camera's calibration, or as another vision system measured it.
Expected<TableSights> sights_of(const CalibrateOptions& options,
                                const MachineConfig& config,
                                const CalibrationPlate& plate) {
  TableSights sights;
  if (options.images.empty()) {
    PANELCAL_TRY(sights, read_plate_looks(options.measurements, config, plate));
  } else {
    PANELCAL_TRY(const auto folders, read_plate_folders(options.images, plate));
    PANELCAL_TRY(const MarkSights seen, look_at_plate(config, plate, folders));
    sights = table_sights(config, seen);
    PANELCAL_CHECK(add_inputs({config.camera_file}, sights.inputs));
  }
  PANELCAL_TRY(LedgerInput input, input_of(options.plate, kMaxPlateBytes));
  sights.inputs.push_back(std::move(input));
  return sights;
}

}  // namespace

Expected<Answer> table(const CalibrateOptions& options, CommandContext& context) {
  PANELCAL_CHECK(check_linuxcnc(options.linuxcnc, context));
  PANELCAL_TRY(Session session, Session::begin(options));
  const MachineConfig& config = *session.config();
  PANELCAL_TRY(const CalibrationPlate plate, read_plate(options.plate));
  PANELCAL_CHECK(session.lock(false));
  PANELCAL_CHECK(session.open_ledger());
  PANELCAL_TRY(TableSights sights, sights_of(options, config, plate));
  PANELCAL_TRY(const TableRun run, calibrate_table(config, std::move(sights)));
  if (!options.plot.empty()) PANELCAL_CHECK(write_file(options.plot, table_svg(run)));
  PANELCAL_TRY(const LedgerDraft draft, table_draft(config, run, session.words()));
  PANELCAL_CHECK(session.finish(
      draft, *table_kind(session.config(), {}, plate, options.output), refusal(run)));
  const bool is_refused = !session.refusal().empty();
  std::string text = report(run);
  if (!options.linuxcnc.empty() && !is_refused) {
    PANELCAL_TRY(const std::string line, write_linuxcnc(options.linuxcnc, run));
    text += line;
  }
  const bool applies = is_applied(options, config, !options.output.empty() && !is_refused);
  if (options.json) return session.answer(table_json(run, draft.result, session, applies));
  return session.answer(text + session.verdict_line() + applied_line(options, config, applies));
}

}  // namespace panelcal::calibrate
