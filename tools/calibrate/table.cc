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
#include <fmt/format.h>

namespace panelcal::calibrate {
namespace {

using facts::Json;

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

/// The map's error, and its covariance, at places all over its rectangle, row by row from below.
Json map_facts(const TableFit& fit) {
  constexpr int kPerSide = 15;
  const TableGrid& grid = fit.map.grid();
  const Eigen::Vector2d step_mm = (grid.high_mm - grid.low_mm) / (kPerSide - 1.0);
  Json errors = Json::array(), covariances = Json::array();
  for (int i = 0; i < kPerSide * kPerSide; ++i) {
    const Eigen::Vector2d steps(i % kPerSide, i / kPerSide);
    const auto at = position_mm<frame::Machine>(grid.low_mm + steps.cwiseProduct(step_mm));
    errors.push_back(facts::point(1e3 * fit.map.error_mm(at)));
    covariances.push_back(facts::covariance(1e6 * fit.covariance_at(at)));
  }
  return {{"first_mm", facts::point(grid.low_mm)},
          {"step_mm", facts::point(step_mm)},
          {"columns", kPerSide},
          {"rows", kPerSide},
          {"error_um", std::move(errors)},
          {"covariance_um2", std::move(covariances)}};
}

Json table_facts(const TableRun& run, const std::string& calibration, bool is_applied) {
  const TableData& data = run.sights.data;
  Json left_out = Json::array();
  for (const MissedPicture& picture : run.sights.left_out) {
    left_out.push_back({{"picture", picture.picture}, {"reason", picture.reason}});
  }
  Json out = {{"poses", run.fit.poses.size()},
              {"chi_square", facts::number(run.fit.chi_square)},
              {"degrees_of_freedom", facts::number(run.fit.degrees_of_freedom)},
              {"rms_um", facts::number(1e3 * run.fit.rms_mm)},
              {"held_out_rms_um", Json()},
              {"excess", facts::number(run.excess)},
              {"undetermined", run.fit.undetermined},
              {"left_out", run.left_out},
              {"pictures_left_out", std::move(left_out)},
              {"pictures_without_tag", run.sights.without_tag},
              {"applied", is_applied},
              {"map", map_facts(run.fit)}};
  if (run.fit.held_out_rms_mm) out["held_out_rms_um"] = 1e3 * *run.fit.held_out_rms_mm;
  Json& residuals = out["residuals"] = Json::array();
  for (std::size_t i = 0; i < run.fit.residuals.size(); ++i) {
    const TableObservation& seen = data.seen[i];
    const PlateView& view = data.views[seen.i_view];
    residuals.push_back({{"pose", view.i_pose},
                         {"dot", seen.i_dot},
                         {"at_mm", facts::point(view.axis_at.in_mm() + seen.seen.position.in_mm())},
                         {"residual_um", facts::point(1e3 * run.fit.residuals[i].in_mm())}});
  }
  out["calibration"] = Json::parse(calibration);
  return out;
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
  return session.answer(text + session.verdict_line() + applied_line(options, config, applies),
                        table_facts(run, draft.result, applies),
                        context);
}

}  // namespace panelcal::calibrate
