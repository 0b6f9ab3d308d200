// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "calib/base/statistics/random.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal::test {

inline constexpr std::chrono::sys_seconds kNight{std::chrono::seconds(1795230000)};
inline constexpr int kNights = 60;
inline constexpr int kRefusedNight = 45;
inline constexpr double kBeyond_mm = 0.214;  ///< error of the refused one

/// Sixty nights of an offset near (62.5, -4) mm that wanders by half a micrometre a night; one of
/// them refused.
inline std::vector<NightPlotPoint> sample_series() {
  Random random(7);
  std::vector<NightPlotPoint> series;
  double x = 62.5;
  double y = -4;
  for (int i = 0; i < kNights; ++i) {
    x += 5e-4 * random.normal();
    y += 5e-4 * random.normal();
    NightPlotPoint point;
    point.time = kNight - std::chrono::days(kNights - 1 - i);
    point.value = {x, y};
    point.sigma = {1.1e-3, 1.2e-3};
    if (i == kRefusedNight) {
      point.is_refused = point.is_alarm = true;
      point.value[0] += kBeyond_mm;
      point.in_force = series.back().in_force;
    } else {
      point.in_force = point.value;
    }
    series.push_back(point);
  }
  return series;
}

inline NightStep sample_step() {
  NightStep step;
  step.kind = "spindle-camera";
  step.subject = "spindle 1 station 1";
  step.state = NightState::Installed;
  step.series = sample_series();
  const NightPlotPoint& before = step.series[kNights - 2];
  const NightPlotPoint& tonight = step.series.back();
  for (std::size_t i = 0; i < 2; ++i) {
    step.axes.push_back({i == 0 ? "x" : "y",
                         "mm",
                         before.value[i],
                         tonight.value[i],
                         tonight.sigma[i],
                         before.value[i] + 2e-4,
                         1.4e-3});
  }
  step.summary = "installed, 0.6 um from the one before";
  step.change = 0.0006;
  step.change_sigma = 0.0016;
  step.decision = NightDecision{NightVerdict::Install,
                                {{"holes", true, "9 of 9 holes used, at least 5"},
                                 {"uncertainty", true, "sigma 1.2 um, limit 3.0 um"},
                                 {"change", true, "0.4 sigma from what was predicted, limit 3.9"}},
                                {},
                                std::nullopt};
  step.qualities.push_back(
      {"holes about the fit", "mm", 0.0031, 0.0030, false, "3.1 um, usually 3.0 um (59 nights)"});
  DrillForecast forecast;
  forecast.answer = DrillAnswer::Until;
  forecast.chance_now = 1e-6;
  forecast.error = Eigen::Vector2d(1e-4, 0);
  forecast.cov = 1e-6 * Eigen::Matrix2d::Identity();
  forecast.now = kNight;
  forecast.until = kNight + std::chrono::hours(90);
  step.forecast = forecast;
  step.forecast_text = "yes, until 2026-11-24T21:00:00Z: within 10.0 um";
  Random random(3);
  for (int i = 0; i < 9; ++i) {
    step.holes.push_back({{200.0 + 5 * (i % 3), 10.0 + 5 * (i / 3)},
                          {3e-3 * random.normal(), 3e-3 * random.normal()},
                          i == 4});
  }
  step.fit_report = {"offset x 62.5012 mm +- 1.1 um", "drill wander 2.9 um"};
  step.file = "spindle.cal.json";
  step.ledger_id = 121;
  step.in_force_id = 121;
  return step;
}

/// A good night.
inline NightRecord sample_night() {
  NightRecord record;
  record.machine = "drill 1";
  record.config_file = "machine.toml";
  record.ledger_file = "drill1.ledger";
  record.night = "2026-11-20";
  record.started = kNight;
  record.finished = kNight + std::chrono::minutes(14);
  record.software = "panelcal 0.1.0";
  record.asked_by = "timer";
  record.temperature_c = 21.4;
  record.checks = {{"disk", true, "20000 MB free, at least 100 MB", 20000, 100, "MB"},
                   {"mark contrast", true, "contrast 0.42, usually 0.41", 0.42, {}, "1"}};
  record.steps = {sample_step()};
  record.outcome = NightOutcome::AllInstalled;
  record.may_drill = true;
  record.drill_until = kNight + std::chrono::hours(90);
  record.verdict = "drill, until 2026-11-24T21:00:00Z";
  record.changes = {"spindle-camera spindle 1 station 1: x +1.2 um (sigma 1.6 um)"};
  record.head = {240, std::string(64, 'a')};
  return record;
}

/// A night that found the camera moved.
inline NightRecord sample_hold() {
  NightRecord record = sample_night();
  NightStep& step = record.steps.front();
  step.state = NightState::Held;
  step.summary = "hold: the change is 152 sigma from what was predicted";
  step.decision->verdict = NightVerdict::Hold;
  step.decision->gates.back() = {"change", false, "152 sigma from what was predicted, limit 3.9"};
  step.decision->reasons = {"change: 152 sigma from what was predicted, limit 3.9"};
  step.alarms = {"a step: tonight is 152 sigma from what the nights before predicted, limit 3.9"};
  step.axes.front().new_value = *step.axes.front().old_value + kBeyond_mm;
  step.series.back().value[0] += kBeyond_mm;
  step.series.back().is_refused = step.series.back().is_alarm = true;
  step.series.back().in_force = step.series[kNights - 2].in_force;
  step.forecast->answer = DrillAnswer::No;
  step.forecast_text = "no: tonight speaks against it";
  record.may_drill = false;
  record.drill_until.reset();
  record.outcome = NightOutcome::Refused;
  record.verdict = "do not drill: spindle-camera spindle 1 station 1: " + step.summary;
  return record;
}

}  // namespace panelcal::test
