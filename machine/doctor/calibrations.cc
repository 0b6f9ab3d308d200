// SPDX-License-Identifier: Apache-2.0
// What is known of the machine: assumed or measured, when, and how well.
#include <cmath>
#include <string>
#include <string_view>

#include "calib/base/clock.h"
#include "calib/correction/breaking_probability.h"
#include "machine/doctor/checks.h"
#include "program/judge/job_decision.h"
#include "program/text/gaps.h"
#include <fmt/format.h>

namespace panelcal::doctor {
namespace {

std::string age_text(std::chrono::sys_seconds date, std::chrono::sys_seconds now) {
  constexpr double kDay_s = 86400;
  const double age_days = static_cast<double>((now - date).count()) / kDay_s;
  return fmt::format("of {}, {:.1f} days ago", iso_8601(date), age_days);
}

/// A year: laboratories calibrate their instruments at least so often. What nights renew has the
/// limit of [nightly.drift] (machine/check/calibration_ages.h).
constexpr std::chrono::hours kOld{365 * 24};
/// Time zones and clocks that are a little fast.
constexpr std::chrono::hours kFuture{24};

/// Of something that was measured: well, unless its date cannot be right or is long ago.
void check_date(const std::string& subject,
                const std::string& text,
                std::chrono::sys_seconds date,
                std::chrono::sys_seconds now,
                const std::string& measure,
                Findings& findings) {
  if (date > now + kFuture) {
    findings.fail(
        subject, text + ": a date in the future", "the clocks set right, then " + measure);
  } else if (now - date > kOld) {
    findings.warn(subject, text + ": more than a year", measure);
  } else {
    findings.ok(subject, text);
  }
}

void check_camera_file(const std::string& subject,
                       const std::filesystem::path& file,
                       const CameraCalibration& camera,
                       std::chrono::sys_seconds now,
                       Findings& findings) {
  const std::string text = file.string() + " " + age_text(camera.date, now);
  const std::string measure = "panelcal calibrate camera -m machine.toml --camera ADDRESS --at X,Y";
  // The words of assumed_camera().
  if (camera.provenance.starts_with("assumed")) {
    findings.warn(subject, text + ": assumed, not measured", measure);
  } else {
    check_date(subject, text, camera.date, now, measure, findings);
  }
}

void check_offset(const MachineConfig& config, std::chrono::sys_seconds now, Findings& findings) {
  constexpr const char* kSubject = "spindle-camera offset";
  const SpindleSetting& setting = config.spindle_setting;
  if (!setting.is_calibrated) {
    return findings.fail(kSubject,
                         setting.file.string() + " does not have spindle " +
                             std::to_string(setting.spindle) + ": no hole may be drilled",
                         "panelcal calibrate spindle-camera -m machine.toml --install");
  }
  if (config.offset_date) {
    check_date(kSubject,
               age_text(config.offset_date->date, now),
               config.offset_date->date,
               now,
               "panelcal calibrate spindle-camera -m machine.toml --install",
               findings);
  } else if (config.camera) {
    findings.warn(kSubject,
                  "without a date: its age is unknown, and its drift is not counted",
                  "[spindle] camera_offset_date, or panelcal calibrate spindle-camera");
  }
}

/// A part of the error of every hole.
struct Term {
  std::string_view name;
  Eigen::Matrix2d cov_mm2;
  std::string_view remedy;
};

/// Of a target in the middle of the picture, where the calibration errs least.
Eigen::Matrix2d camera_mm2(const MachineConfig& config) {
  if (!config.camera) return Eigen::Matrix2d::Zero();
  const CameraMapping mapping = config.camera->mapping();
  const CameraJacobian by =
      mapping.by_parameters(position_px<frame::Image>(mapping.parameters().axis_px));
  return by * config.walk.uncertainty.camera * by.transpose();
}

}  // namespace

void check_assumptions(std::string_view machine_toml, Findings& findings) {
  constexpr std::string_view kMark = "# assumed; ";
  int i_line = 0;
  while (!machine_toml.empty()) {
    std::string_view line = machine_toml.substr(0, machine_toml.find('\n'));
    machine_toml.remove_prefix(std::min(machine_toml.size(), line.size() + 1));
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++i_line;
    const std::size_t mark = line.find(kMark);
    const std::size_t equals = line.find('=');
    if (mark == std::string_view::npos || equals == std::string_view::npos || equals > mark ||
        trimmed(line).starts_with('#')) {
      continue;
    }
    const std::string_view value = line.substr(equals + 1, mark - equals - 1);
    findings.warn(
        fmt::format("machine.toml line {}", i_line),
        fmt::format(
            "{} = {} is assumed, not measured", trimmed(line.substr(0, equals)), trimmed(value)),
        std::string(trimmed(line.substr(mark + kMark.size()))));
  }
}

void check_calibrations(const MachineConfig& config,
                        std::chrono::sys_seconds now,
                        Findings& findings) {
  if (config.camera) check_camera_file("camera", config.camera_file, *config.camera, now, findings);
  for (const auto& [level, camera] : config.zooms) {
    check_camera_file(
        fmt::format("camera zoom {}", level), config.zoom_files.at(level), camera, now, findings);
  }
  check_offset(config, now, findings);
  if (config.table_date) {
    check_date("table",
               config.table_file.string() + " " + age_text(*config.table_date, now),
               *config.table_date,
               now,
               "panelcal calibrate table -m machine.toml --install",
               findings);
  }
}

void check_error_budget(const MachineConfig& config, Findings& findings) {
  constexpr const char* kSubject = "tolerance";
  const MachineUncertainty& uncertainty = config.walk.uncertainty;
  const Tolerances& tolerances = config.walk.tolerances;
  if (!tolerances.position) {
    if (tolerances.asks_positions()) return;  // each tool's own, which needs a program
    return findings.warn(kSubject,
                         "[tolerance] position_um is missing: no job is held for a place that is "
                         "not sure enough",
                         "[tolerance] position_um");
  }
  if (const auto unstated = uncertainty.unstated(); !unstated.empty()) {
    findings.warn(
        kSubject,
        fmt::format("[uncertainty] lacks {}: risks are too small", fmt::join(unstated, ", ")),
        "state it, be it as zero");
  }
  const Term terms[] = {
      {"spindle-camera offset",
       uncertainty.spindle_camera_mm2,
       "panelcal calibrate spindle-camera"},
      {"drift of the offset", uncertainty.drift_mm2, "panelcal calibrate spindle-camera"},
      {"camera", camera_mm2(config), "panelcal calibrate camera"},
      {"stage", uncertainty.stage_mm2(), "a machine that repeats better"},
      {"table", uncertainty.table_mm2(), "panelcal calibrate table"},
      {"drill", uncertainty.wander_mm2(), "a stiffer drill, or a wider [tolerance]"}};
  Eigen::Matrix2d sum_mm2 = uncertainty.rounding_mm2();
  const Term* largest = terms;
  for (const Term& term : terms) {
    sum_mm2 += term.cov_mm2;
    if (term.cov_mm2.trace() > largest->cov_mm2.trace()) largest = &term;
  }
  const Length radius = *tolerances.position;
  const double risk = breaking_probability(sum_mm2, radius);
  const std::string text = fmt::format(
      "with perfect targets a hole's sigma is {:.1f} um, most of it by the {}; off by more than "
      "{:g} um with probability {}",
      principal_sigmas(sum_mm2).large.in_um(),
      largest->name,
      radius.in_um(),
      risk_text(risk));
  if (risk > tolerances.hold_above) {
    findings.fail(kSubject, text + ": every job is held", std::string(largest->remedy));
  } else if (risk > tolerances.warn_above) {
    findings.warn(kSubject, text, std::string(largest->remedy));
  } else {
    findings.ok(kSubject, text);
  }
}

}  // namespace panelcal::doctor
