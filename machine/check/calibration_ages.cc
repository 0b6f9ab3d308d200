// SPDX-License-Identifier: Apache-2.0
#include "machine/check/calibration_ages.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "calib/base/clock.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr double kDay_s = 86400;

/// Holds one calibration after another against the nights' limit.
class AgeCheck {
 public:
  AgeCheck(const NightlyConfig& nightly, std::chrono::sys_seconds now, DiagnosticLog& log)
      : nightly_(nightly), now_(now), log_(log) {}

  bool covers(std::string_view kind) const {
    return std::ranges::find(nightly_.calibrate, kind) != nightly_.calibrate.end();
  }

  void look_at(const std::string& subject, std::chrono::sys_seconds date) {
    const double age_days = static_cast<double>((now_ - date).count()) / kDay_s;
    const double limit_days = nightly_.limits.old.trusted.in_s() / kDay_s;
    if (age_days <= limit_days) return;
    log_.add({Code::CalibrationOld,
              nightly_.place,
              fmt::format("{} is of {}, {:.1f} days ago", subject, iso_8601(date), age_days),
              fmt::format("one of the last {:.4g} days ([nightly.drift] trusted_days): see why the "
                          "nights install none",
                          limit_days)});
  }

 private:
  const NightlyConfig& nightly_;
  std::chrono::sys_seconds now_;
  DiagnosticLog& log_;
};

}  // namespace

void check_calibration_ages(const MachineConfig& config,
                            std::chrono::sys_seconds now,
                            DiagnosticLog& log) {
  if (!config.nightly) return;
  AgeCheck check(*config.nightly, now, log);
  if (check.covers("camera")) {
    if (config.camera) check.look_at("the camera's calibration", config.camera->date);
    for (const auto& [level, camera] : config.zooms) {
      check.look_at(fmt::format("the camera's calibration at zoom {}", level), camera.date);
    }
  }
  if (check.covers("spindle-camera") && config.offset_date) {
    check.look_at("the spindle-camera offset", config.offset_date->date);
  }
  if (check.covers("table") && config.table_date) {
    check.look_at("the table's calibration", *config.table_date);
  }
}

}  // namespace panelcal
