// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/spindle/calibration_file.h"
#include "machine/nightly/nightly.h"
#include "machine/sim/sim_coupon.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal::test {

/// Faults of the virtual machine tonight.
struct PictureFaults {
  bool is_lens_dirty = false;
  Length wander = um(3);
  std::optional<int> stage_fails_after;  ///< so many moves
};

/// A lens with a film of oil: less contrast, wider edges.
class MaybeDirtyCamera final : public CameraDevice {
 public:
  MaybeDirtyCamera(CameraDevice& camera, bool is_dirty) : camera_(camera), is_dirty_(is_dirty) {}

  Expected<Image> take() override {
    PANELCAL_TRY(const Image clear, camera_.take());
    if (!is_dirty_) return clear;
    Image dirty = clear;
    for (int y = 0; y < clear.height(); ++y) {
      for (int x = 0; x < clear.width(); ++x) dirty.at(x, y) = film(clear, x, y);
    }
    return dirty;
  }
  std::string name() const override { return camera_.name(); }

 private:
  /// The mean of 3 x 3 pixels, mixed with stray light.
  static float film(const Image& clear, int x, int y) {
    float sum = 0;
    int n = 0;
    for (int v = std::max(0, y - 1); v <= std::min(clear.height() - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(clear.width() - 1, x + 1); ++u) {
        sum += clear.at(u, v);
        ++n;
      }
    }
    constexpr float kStray = 0.2F;
    const auto light = static_cast<float>(0.6 * clear.full_scale());
    return kStray * light + (1 - kStray) * sum / static_cast<float>(n);
  }

  CameraDevice& camera_;
  bool is_dirty_;
};

class MaybeBrokenStage final : public Stage {
 public:
  MaybeBrokenStage(Stage& stage, std::optional<int> n_moves) : stage_(stage), n_moves_(n_moves) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    if (n_moves_ && --*n_moves_ < 0) {
      return failure({Code::DeviceStage, {"stage", 0, 0}, "the stage lost its way", "a stage"});
    }
    return stage_.move_to(spindle);
  }

 private:
  Stage& stage_;
  std::optional<int> n_moves_;
};

/// A machine in a folder of its own that drills and sees: machine.toml is written anew for every
/// night, as by people who lay on new coupons.
class PictureNights {
 public:
  /// 20 um beside what machine.toml begins with.
  Eigen::Vector2d truth_mm = {45.02, -3.0};
  std::chrono::sys_seconds now{std::chrono::seconds(1795302000)};
  std::string nightly = "[nightly]\nmachine_driver = \"sim\"\nmin_disk_mb = 0\n";
  std::string coupon = "A";
  /// Of the pictures; a hole is 80 px wide.
  int width_px = 160;
  int height_px = 140;

  Expected<MachineConfig> config() const {
    const std::string toml = fmt::format(R"([machine]
name = "drill 1"
[vision]
search_radius_mm = 0.4
[[vision.tool]]
number = 1
shape = "hole"
size_mm = 0.8
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
calibration = "spindle.cal.json"
[coupon]
name = "{}"
origin_mm = [300, 100]
approaches = ["+x+y", "-x-y"]
[ledger]
file = "drill.ledger"
[sim]
noise = 3
background = 0.6
target_level = 0.9
spindle_camera_offset_mm = [{}, {}]
{})",
                                         coupon,
                                         truth_mm.x(),
                                         truth_mm.y(),
                                         nightly);
    PANELCAL_CHECK(write_file(folder_.path() / "machine.toml", toml));
    // A night may have put another one there.
    if (!std::filesystem::exists(camera_file())) {
      PANELCAL_CHECK(write_camera_calibration(camera_file(), test_camera(width_px, height_px)));
    }
    return read_machine_config(folder_.path() / "machine.toml");
  }

  /// One run of a night; `seed` is of everything that is random in it.
  Expected<NightRecord> run(std::uint64_t seed, const PictureFaults& faults) const {
    PANELCAL_TRY(const MachineConfig config, this->config());
    SimCouponOptions options;
    options.seed = seed;
    options.wander = faults.wander;
    options.stage_repeatability = um(1);
    PANELCAL_TRY(SimCoupon machine, SimCoupon::create(config, options));
    if (config.nightly->mark) {
      PANELCAL_CHECK(machine.move_to(*config.nightly->mark));
      PANELCAL_CHECK(machine.drill(1));
    }
    MaybeDirtyCamera camera(machine, faults.is_lens_dirty);
    MaybeBrokenStage stage(machine, faults.stage_fails_after);
    const NightJob job = {config,
                          *config.nightly,
                          {stage, machine, camera, {}, {}},
                          [this] { return now; },
                          "panelcal test",
                          "timer"};
    return run_nightly(job);
  }

  std::filesystem::path camera_file() const { return folder_.path() / "camera.cal.json"; }
  std::filesystem::path ledger_file() const { return folder_.path() / "drill.ledger"; }
  /// Offset that a job would be drilled with.
  std::optional<Eigen::Vector2d> installed_mm() const {
    const auto file = read_spindle_calibration(folder_.path() / "spindle.cal.json");
    if (!file || file->offsets.find({1, 1}) == nullptr) return std::nullopt;
    return file->offsets.find({1, 1})->offset.in_mm();
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace panelcal::test
