// SPDX-License-Identifier: Apache-2.0
#include "machine/check/machine_check.h"

#include <set>
#include <string>
#include <utility>

#include "machine/calibrate/kinds/kinds.h"
#include "machine/calibrate/spindle/calibration.h"
#include "machine/calibrate/spindle/coupon.h"
#include "machine/check/calibration_ages.h"
#include "machine/check/coupon_rules.h"
#include "machine/check/file_rules.h"
#include "machine/check/vision_rules.h"
#include "machine/config/plate/plate.h"
#include "machine/look/mark_sights.h"
#include "machine/nightly/checks/mark_look.h"
#include "machine/nightly/record/noted_heads.h"
#include "machine/plate/pictures.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string point_text(const Position<frame::Machine>& place) {
  return fmt::format("({:.3f}, {:.3f}) mm", place.in_mm().x(), place.in_mm().y());
}

/// The first run of the coupon that leaves the travel, and with it all those behind.
void check_coupon(const MachineConfig& config, const Coupon& coupon, DiagnosticLog& log) {
  const int n_runs = coupon.rows / coupon.rows_per_run;
  for (int run = 0; run < n_runs; ++run) {
    const int i_row = run * coupon.rows_per_run;
    const auto checked = check_coupon_job(config, coupon, places_of_row(coupon, i_row));
    if (checked) continue;
    Diagnostic problem = checked.error();
    if (problem.code == Code::TravelExceeded && run > 0) {
      problem.place = coupon.rows_place;
      problem.what = fmt::format(
          "rows for {} calibrations, and {} (calibration {})", n_runs, problem.what, run + 1);
      problem.expected = fmt::format("at most {} rows, or a coupon that lies elsewhere", i_row);
    }
    return log.add(std::move(problem));
  }
}

/// Each calibration by itself, so that all problems are found.
void check_calibration(const MachineConfig& config,
                       const NightlyConfig& nightly,
                       const std::string& kind,
                       DiagnosticLog& log) {
  NightlyConfig alone = nightly;
  alone.calibrate = {kind};
  const auto calibrations = NightCalibrations::make(config, alone);
  if (!calibrations) return log.add(calibrations.error());
  for (const Calibration* calibration : calibrations->all()) {
    const auto checked = calibration->check();
    if (!checked) log.add(checked.error());
  }
  if (kind != "table") return;
  const auto plate = read_plate(nightly.table.plate);
  if (!plate) return;
  if (auto travel = check_plate_travel(config, *plate); !travel) {
    log.add(std::move(travel).error());
  }
}

/// An older copy of the ledger does not know which rows of the coupon are drilled.
void check_ledger(const MachineConfig& config, DiagnosticLog& log) {
  const auto noted = check_noted_heads(config);
  if (!noted) log.add(noted.error());
}

void check_mark(const MachineConfig& config, const NightlyConfig& nightly, DiagnosticLog& log) {
  if (!nightly.mark || !config.camera) return;
  const auto looker = MarkLooker::make(config, nightly, {});
  if (looker) return;
  Diagnostic problem = looker.error();
  problem.place = nightly.mark_place;
  log.add(std::move(problem));
}

}  // namespace

void check_machine(const MachineConfig& config,
                   const StatedKeys& keys,
                   std::chrono::sys_seconds now,
                   DiagnosticLog& log) {
  check_vision_rules(config, keys, log);
  check_coupon_rules(config, keys, log);
  if (config.coupon && config.camera) check_coupon(config, *config.coupon, log);
  if (!config.nightly) return;
  check_mark(config, *config.nightly, log);
  for (const std::string& kind : config.nightly->calibrate) {
    check_calibration(config, *config.nightly, kind, log);
  }
  check_file_rules(config, keys, log);
  check_ledger(config, log);
  check_calibration_ages(config, now, log);
}

void check_targets(const MachineConfig& config,
                   const Program& program,
                   const Survey& nominal,
                   DiagnosticLog& log) {
  if (!config.camera) return;
  std::set<int> unknown;
  bool has_left_travel = false;
  for (const Measurement& measurement : nominal.measurements) {
    const MeasurementRequest& request = measurement.request;
    const Place place{request.file.empty() ? program.source.file : request.file, request.line, 1};
    for (const int tool : request.settings.tools) {
      if (config.vision_tools.contains(tool) || !unknown.insert(tool).second) continue;
      log.add({Code::VisionToolUndefined,
               place,
               fmt::format("{} with vision tool {}", request.command, tool),
               "a [[vision.tool]] of that number in machine.toml"});
    }
    const auto spindle = config.spindle_camera.spindle_to_see(request.expected_in_machine());
    if (has_left_travel || is_in_travel(config, spindle)) continue;
    has_left_travel = true;
    log.add({Code::TravelExceeded,
             place,
             fmt::format("to see the target at nominal ({:.4f}, {:.4f}) mm the spindle goes to {}",
                         request.nominal.in_mm().x(),
                         request.nominal.in_mm().y(),
                         point_text(spindle)),
             "targets that the camera, which stands by camera_offset_mm beside the spindle, sees "
             "within [machine] travel"});
  }
}

}  // namespace panelcal
