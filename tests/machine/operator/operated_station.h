// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/camera/calibration/calibration_file.h"
#include "machine/operator/station.h"
#include "machine/sim/sim_machine.h"
#include "vision/picture/files/folder.h"
#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/machine/operator/screen_schema.h"
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

/// A station with a virtual machine, or with pictures of it, and one person.
class OperatedStation : public ::testing::Test {
 protected:
  /// Longer than any job here takes, under a sanitizer and on a busy computer.
  static constexpr std::chrono::minutes kPatience{5};

  void SetUp() override {
    write(folder_.path() / "machine.toml", small_config_text(""));
    write_test_camera(folder_.path());
  }

  StationSettings settings() const {
    StationSettings out{.machine_file = folder_.path() / "machine.toml",
                        .jobs_folder = folder_.path() / "jobs",
                        .camera = {},
                        .images = images_,
                        .machine_driver = images_.empty() ? "sim" : "",
                        .clock = fixed_clock(*from_iso_8601("2026-11-27T08:00:00Z"))};
    out.page = [](std::string_view title, std::string_view facts, const auto&) {
      return std::string(title) + "\n" + std::string(facts);
    };
    return out;
  }
  void start() {
    auto station = Station::create(settings());
    ASSERT_TRUE(station) << station.error().text();
    station_ = *std::move(station);
  }
  void add(const std::string& name, std::string_view program) {
    const auto added = station_->add_program(name, program);
    ASSERT_TRUE(added) << added.error().text();
  }
  /// A station with the small program, checked.
  void open_small_program() {
    start();
    if (HasFatalFailure()) return;
    add("panel.exc", kSmallProgram);
    order(R"({"do":"open","program":"panel.exc"})");
  }

  nlohmann::json screen() const {
    nlohmann::json screen = nlohmann::json::parse(station_->state().json);
    EXPECT_EQ(screen_problem(screen), "");
    return screen;
  }
  nlohmann::json job() const { return screen()["job"]; }
  void order(const std::string& json) {
    const auto done = station_->command(json, "Anna");
    EXPECT_TRUE(done) << json << ": " << done.error().text();
  }
  /// A refused command changes nothing.
  void expect_refused(const std::string& json) {
    const Station::State before = station_->state();
    EXPECT_FALSE(station_->command(json, "Anna")) << json;
    EXPECT_EQ(station_->state().json, before.json);
  }
  /// The screen when it is as wanted.
  nlohmann::json wait_for(const std::function<bool(const nlohmann::json&)>& is_wanted) const {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (true) {
      const Station::State state = station_->state();
      nlohmann::json screen = nlohmann::json::parse(state.json);
      EXPECT_EQ(screen_problem(screen), "");
      if (is_wanted(screen)) return screen;
      if (std::chrono::steady_clock::now() > end) {
        ADD_FAILURE() << "still " << screen["job"].dump(1);
        return screen;
      }
      station_->wait(state.number, ~std::uint64_t{0}, std::chrono::milliseconds(1000));
    }
  }
  /// The job when it asks or has ended.
  nlohmann::json wait_until_it_rests() const {
    return wait_for(
        [](const nlohmann::json& screen) { return screen["job"]["state"] != "measuring"; })["job"];
  }
  std::string file_of(const std::string& name) const {
    const auto bytes = station_->job_file("2026-11-27-1", name);
    EXPECT_TRUE(bytes) << bytes.error().text();
    return bytes.value_or("");
  }

  /// A picture of each target of the small program, taken by the virtual machine.
  void take_pictures() {
    images_ = (folder_.path() / "images").string();
    std::filesystem::create_directory(images_);
    const MachineConfig config = small_config(folder_.path());
    const Program program = program_of(std::string(kSmallProgram));
    const auto sim = SimMachine::create(config, program);
    ASSERT_TRUE(sim) << sim.error().text();
    DiagnosticLog log;
    for (const Measurement& one : check(program, config.walk, log).survey.measurements) {
      View view;
      view.axis = one.request.expected_in_machine();
      const auto taken = sim->picture(one.request, view);
      ASSERT_TRUE(taken) << taken.error().text();
      PictureRow row;
      row.file = std::to_string(one.request.seq) + ".png";
      row.axis = taken->axis;
      rows_.push_back(row);
      ASSERT_TRUE(write_png(std::filesystem::path(images_) / row.file, taken->image));
    }
    write_list();
  }
  void write_list() const {
    write(std::filesystem::path(images_) / "images.csv", format_images_csv(rows_));
  }
  /// The target of that picture is gone.
  void blank(std::size_t seq) const {
    const Image grey(280, 240, Image::kFullScale8, 100);
    ASSERT_TRUE(write_png(std::filesystem::path(images_) / rows_[seq].file, grey));
  }

  TemporaryFolder folder_;
  std::string images_;  ///< empty: the virtual machine
  std::vector<PictureRow> rows_;
  std::unique_ptr<Station> station_;
};

/// The blocks of a program, without the lines that say where it comes from.
inline std::string blocks_of(std::string_view program) {
  std::string out;
  while (!program.empty()) {
    const std::string_view line = program.substr(0, program.find('\n'));
    program.remove_prefix(std::min(program.size(), line.size() + 1));
    if (!line.starts_with(';')) out += std::string(line) + "\n";
  }
  return out;
}

}  // namespace panelcal::test
