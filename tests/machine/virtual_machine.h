// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/camera/calibration/calibration_file.h"
#include "machine/config/machine_config.h"
#include "program/model/operation.h"
#include "program/walk/walk.h"
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace panelcal::test {

/// A folder that is gone with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "panelcal-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A camera of 10 um a pixel with a little rotation and lens distortion.
inline CameraCalibration test_camera(int width_px, int height_px) {
  CameraCalibration camera;
  camera.parameters.scale_mm_per_px = 0.01;
  camera.parameters.rotation_rad = 0.004;
  camera.parameters.axis_px << 0.5 * (width_px - 1) + 3.2, 0.5 * (height_px - 1) - 4.1;
  camera.parameters.k1_per_px2 = 4e-8;  // 0.2 % at the edge of the picture
  camera.picture_width_px = width_px;
  camera.picture_height_px = height_px;
  camera.provenance = "made up for a test";
  return camera;
}

/// Writes the calibration beside a machine.toml that is only text, and reads both.
inline Expected<MachineConfig> config_with_camera(const std::filesystem::path& folder,
                                                  const CameraCalibration& camera,
                                                  std::string_view toml) {
  PANELCAL_CHECK(write_camera_calibration(folder / "camera.cal.json", camera));
  return parse_machine_config(toml, folder / "machine.toml");
}

inline std::string all_text(const DiagnosticLog& log) {
  std::string text;
  for (const Diagnostic& diagnostic : log.kept()) text += diagnostic.text() + "\n";
  return text;
}

inline Program program_of(std::string text) {
  DiagnosticLog log;
  Program program = load_program({"test.exc", std::move(text)}, log);
  EXPECT_FALSE(log.has_errors()) << all_text(log);
  return program;
}

/// A hole with the path it was drilled at.
struct Hole {
  InstancePath path;
  Drill drill;
};

class HoleSink final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    if (const auto* drill = std::get_if<Drill>(&operation.what)) {
      holes_.push_back({{operation.path.begin(), operation.path.end()}, *drill});
    }
  }
  const std::vector<Hole>& holes() const { return holes_; }

 private:
  std::vector<Hole> holes_;
};

}  // namespace panelcal::test
