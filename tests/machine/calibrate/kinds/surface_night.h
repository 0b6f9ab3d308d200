// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/nightly/nightly.h"
#include "machine/sim/sim_table_surface.h"
#include "machine/sim/simulated_probe.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal::test {

/// A machine of which a night needs nothing but the probe.
class OnlyProbe final : public Stage, public Spindle, public CameraDevice {
 public:
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    return spindle;
  }
  Expected<void> drill(int /*tool*/) override { return unwanted(Code::DeviceStage); }
  Expected<Image> take() override { return failure(problem(Code::DeviceFrame)); }
  std::string name() const override { return "none"; }
  bool can_set(CameraSetting /*setting*/) const override { return false; }
  Expected<void> set(CameraSetting /*setting*/, double /*value*/) override {
    return unwanted(Code::NotSupported);
  }

 private:
  static Diagnostic problem(Code code) { return {code, {"test", 0, 0}, "not asked for", ""}; }
  static Expected<void> unwanted(Code code) { return failure(problem(code)); }
};

/// Nights that probe a table which does what a test says.
class SurfaceNights : public ::testing::Test {
 protected:
  SurfaceNights() {
    truth.surface.height = mm(0.2);
    truth.surface.slope_x_ppm = 80;
    truth.surface.slope_y_ppm = -30;
    truth.surface.bow = um(20);
    truth.surface.bow_center = position_mm<frame::Actual>(200, 150);
    truth.surface.bow_radius = mm(150);
    truth.surface.noise_sigma = um(3);
  }

  SimTableSurface truth;
  std::string surface = "columns = 6\nrows = 5\n";  ///< more of [nightly.surface]
  std::string area = "low_mm = [100, 50]\nhigh_mm = [300, 250]\n";
  bool has_probe = true;
  std::uint64_t seed = 1;

  std::string toml() const {
    return fmt::format(R"([machine]
name = "drill 1"
stage_command = ["stage", "{{x}}", "{{y}}"]
probe_command = ["probe", "{{x}}", "{{y}}"]
travel_low_mm = [0, 0]
travel_high_mm = [600, 500]
[ledger]
file = "drill.ledger"
[nightly]
camera = "gige://192.168.1.10"
calibrate = ["surface"]
min_disk_mb = 0
[nightly.surface]
file = "table.json"
{}{})",
                       area,
                       surface);
  }

  Expected<NightRecord> try_run(bool is_dry_run = false) {
    const std::string text = toml();
    PANELCAL_CHECK(write_file(folder_.path() / "machine.toml", text));
    PANELCAL_TRY(const MachineConfig config,
                 parse_machine_config(text, folder_.path() / "machine.toml"));
    truth.surface.seed = seed;
    PANELCAL_TRY(SimulatedProbe probe, SimulatedProbe::create(surface_at(truth, now)));
    OnlyProbe machine;
    CalibrationDevices devices = {machine, machine, machine, {}, {}};
    if (has_probe) devices.probe = &probe;
    return run_nightly({.config = config,
                        .nightly = *config.nightly,
                        .devices = devices,
                        .clock = [this] { return now; },
                        .software = "panelcal test",
                        .asked_by = "timer",
                        .is_dry_run = is_dry_run});
  }
  /// Tonight, and on to the next one.
  NightRecord run() {
    const auto record = try_run();
    if (!record) ADD_FAILURE() << record.error().text();
    now += std::chrono::days(1);
    return record ? *record : NightRecord{};
  }
  std::filesystem::path file() const { return folder_.path() / "table.json"; }
  std::string text() const { return read_file(file()).value_or("none"); }
  std::filesystem::path ledger_file() const { return folder_.path() / "drill.ledger"; }

  test::TemporaryFolder folder_;
  std::chrono::sys_seconds now{std::chrono::seconds(1795302000)};
};

}  // namespace panelcal::test
