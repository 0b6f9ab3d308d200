// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/calibrations/night_calibrations.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "machine/nightly/nightly.h"

namespace panelcal {

std::vector<std::string> internal::lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Expected<NightCalibrations> NightCalibrations::make(const MachineConfig& config,
                                                    const NightlyConfig& nightly) {
  const auto shared = std::make_shared<MachineConfig>(config);
  const auto is_wanted = [&](std::string_view kind) {
    return std::ranges::find(nightly.calibrate, kind) != nightly.calibrate.end();
  };
  NightCalibrations out;
  out.config_ = shared;
  constexpr std::array<std::pair<std::string_view, TrialKind>, 3> kTrials = {
      {{"focus", TrialKind::Focus}, {"light", TrialKind::Light}, {"settle", TrialKind::Settle}}};
  for (const auto& [name, kind] : kTrials) {
    if (!is_wanted(name)) continue;
    PANELCAL_TRY(auto trial, internal::trial_night(kind, shared, nightly));
    out.owned_.push_back(std::move(trial));
  }
  if (is_wanted("camera")) {
    std::vector<std::optional<double>> zooms = {std::nullopt};
    for (const double level : internal::zooms_of_nights(config)) zooms.emplace_back(level);
    for (const std::optional<double>& zoom : zooms) {
      PANELCAL_TRY(auto camera, internal::camera_night(shared, nightly, zoom));
      out.owned_.push_back(std::move(camera));
    }
  }
  if (is_wanted("spindle-camera")) {
    PANELCAL_TRY(auto offset, internal::spindle_camera_night(shared, nightly));
    out.owned_.push_back(std::move(offset));
  }
  if (is_wanted("table")) {
    PANELCAL_TRY(auto table, internal::table_night(shared, nightly));
    out.owned_.push_back(std::move(table));
  }
  if (is_wanted("surface")) {
    PANELCAL_TRY(auto surface, internal::surface_night(shared, nightly));
    out.owned_.push_back(std::move(surface));
  }
  for (const auto& one : out.owned_) out.all_.push_back(one.get());
  return out;
}

Expected<NightRecord> run_nightly(const NightJob& job) {
  PANELCAL_TRY(const NightCalibrations calibrations,
               NightCalibrations::make(job.config, job.nightly));
  const NightJob shared = {.config = calibrations.config(),
                           .nightly = job.nightly,
                           .devices = job.devices,
                           .clock = job.clock,
                           .software = job.software,
                           .asked_by = job.asked_by,
                           .is_dry_run = job.is_dry_run,
                           .is_again = job.is_again,
                           .temperature_c = job.temperature_c,
                           .progress = job.progress,
                           .lock = job.lock,
                           .notes = job.notes};
  return run_nightly(shared, calibrations.all());
}

}  // namespace panelcal
