// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

#include "calib/camera/calibration/calibration_file.h"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/machine/small_panel.h"
#include "tests/machine/virtual_machine.h"

namespace panelcal::test {

inline void write(const std::filesystem::path& path, std::string_view text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline void write_test_camera(const std::filesystem::path& folder) {
  const auto written = write_camera_calibration(folder / "camera.cal.json", test_camera(280, 240));
  ASSERT_TRUE(written) << written.error().text();
}

}  // namespace panelcal::test
