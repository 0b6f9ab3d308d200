// SPDX-License-Identifier: Apache-2.0
// Calibrations, their history and rollbacks by a station.
#include "machine/operator/night_order.h"

#include <filesystem>
#include <string>

#include "calib/spindle/calibration_file.h"
#include "machine/nightly/record/night_record.h"
#include "machine/operator/desk.h"

#include "tests/machine/nightly/picture_night.h"
#include "tests/machine/operator/operated_station.h"

namespace panelcal::test {
namespace {

class StationNight : public OperatedStation {
 protected:
  void SetUp() override {
    const auto config = nights_.config();
    ASSERT_TRUE(config) << config.error().text();
    machine_file_ = config->file;
  }
  /// A station of that day.
  void start_on(const std::string& day) {
    station_.reset();
    StationSettings settings = this->settings();
    settings.machine_file = machine_file_;
    settings.clock = fixed_clock(*from_iso_8601(day + "T20:00:00Z"));
    settings.software = "panelcal test";
    settings.night_page = [](const NightRecord& record) { return "page of " + record.night; };
    auto station = Station::create(settings);
    ASSERT_TRUE(station) << station.error().text();
    station_ = *std::move(station);
  }
  nlohmann::json calibrate(const std::string& kind) {
    order(R"({"do":"calibrate","kind":")" + kind + "\"}");
    return wait_for(
        [](const nlohmann::json& screen) { return screen["calibration"]["state"] != "running"; });
  }
  std::string calibration() const {
    return read_file(machine_file_.parent_path() / "spindle.cal.json").value_or("");
  }

  PictureNights nights_;
  std::filesystem::path machine_file_;
};

TEST_F(StationNight, CalibratesAndGoesBack) {
  start_on("2026-11-26");
  EXPECT_EQ(screen()["kinds"][0], "night");
  EXPECT_TRUE(std::ranges::count(screen()["kinds"], "spindle-camera"));
  // There is no plate in its machine.toml.
  EXPECT_FALSE(std::ranges::count(screen()["kinds"], "table"));
  const nlohmann::json first = calibrate("night");
  EXPECT_EQ(first["calibration"]["state"], "done") << first["calibration"].dump(1);
  EXPECT_FALSE(first["calibration"]["lines"].empty());
  EXPECT_TRUE(first["calibration"]["has_page"]);
  EXPECT_EQ(station_->job_file("night", "report.html").value_or(""), "page of 2026-11-26");
  const std::string before = calibration();
  ASSERT_FALSE(before.empty());

  start_on("2026-11-27");
  const nlohmann::json second = calibrate("spindle-camera");
  EXPECT_EQ(second["calibration"]["state"], "done") << second["calibration"].dump(1);
  EXPECT_NE(calibration(), before);

  std::vector<nlohmann::json> offsets;  // the newest first
  for (const nlohmann::json& entry : second["history"]) {
    if (entry["kind"] == "spindle-camera") offsets.push_back(entry);
  }
  ASSERT_EQ(offsets.size(), 2U) << second["history"].dump(1);
  EXPECT_TRUE(offsets[0]["in_force"]);
  EXPECT_FALSE(offsets[1]["in_force"]);
  EXPECT_NE(offsets[0]["words"].get<std::string>().find("Anna"), std::string::npos);

  nlohmann::json back = {{"do", "roll_back"},
                         {"kind", "camera"},
                         {"to", offsets[1]["entry"]},
                         {"reason", "the spindle was hit"}};
  expect_refused(back.dump());
  back["kind"] = "spindle-camera";
  order(back.dump());
  const nlohmann::json history = screen()["history"];
  EXPECT_NE(history[0]["words"].get<std::string>().find("the spindle was hit"), std::string::npos);
  for (const nlohmann::json& entry : history) {
    if (entry["kind"] != "spindle-camera") continue;
    if (entry["words"].get<std::string>().find("installed") == std::string::npos) continue;
    EXPECT_EQ(entry["in_force"], entry["entry"] == offsets[1]["entry"]) << entry.dump(1);
  }
  const auto restored = parse_spindle_calibration(calibration(), "spindle.cal.json");
  const auto wanted = parse_spindle_calibration(before, "before");
  ASSERT_TRUE(restored && wanted);
  const SpindleAt drilling{1, 1};
  EXPECT_EQ(restored->offsets.find(drilling)->offset, wanted->offsets.find(drilling)->offset);
}

TEST_F(StationNight, IsStoppedByAPersonAndInstallsNothing) {
  start_on("2026-11-26");
  expect_refused(R"({"do":"stop"})");
  order(R"({"do":"calibrate","kind":"night"})");
  order(R"({"do":"stop"})");
  const nlohmann::json stopped = wait_for([](const nlohmann::json& screen) {
    return screen["calibration"]["state"] != "running";
  })["calibration"];
  EXPECT_EQ(stopped["state"], "failed");
  EXPECT_NE(stopped["verdict"].get<std::string>().find("stopped"), std::string::npos) << stopped;
  EXPECT_EQ(calibration(), "");
  EXPECT_EQ(calibrate("night")["calibration"]["state"], "done");
}

/// The verdict of a calibration of the surface, with a stop ahead of its first probe.
std::string verdict_of_surface(const StationSettings& settings, bool is_stopped) {
  internal::Screen screen;
  screen.calibration.emplace();
  internal::Desk desk(screen);
  if (is_stopped) desk.change([&](internal::Screen&) { desk.stop(); });
  internal::run_calibration(settings, "surface", "Anna", desk);
  return desk.read([](const internal::Screen& one) { return one.calibration->verdict; });
}

TEST_F(StationNight, ProbesNothingOnceAPersonHasStoppedIt) {
  nights_.nightly +=
      "[nightly.surface]\nfile = \"table.json\"\nlow_mm = [100, 50]\nhigh_mm = [250, 250]\n"
      "columns = 6\nrows = 5\n[sim.table_surface]\nnoise_um = 3\n";
  const auto config = nights_.config();
  ASSERT_TRUE(config) << config.error().text();
  StationSettings settings = this->settings();
  settings.machine_file = machine_file_;
  settings.software = "panelcal test";
  const std::string stopped = verdict_of_surface(settings, true);
  EXPECT_NE(stopped.find("stopped"), std::string::npos) << stopped;
  EXPECT_FALSE(std::filesystem::exists(machine_file_.parent_path() / "table.json"));
  const std::string whole = verdict_of_surface(settings, false);
  EXPECT_EQ(whole.find("stopped"), std::string::npos) << whole;
}

TEST_F(StationNight, RefusesWhatItCannotCalibrate) {
  start_on("2026-11-26");
  expect_refused(R"({"do":"calibrate","kind":"coffee"})");
  expect_refused(R"({"do":"roll_back","kind":"camera","to":1,"reason":"x"})");
}

TEST_F(StationNight, SaysWhyANightFailed) {
  nights_.nightly = "";
  ASSERT_TRUE(nights_.config());
  start_on("2026-11-26");
  const nlohmann::json calibration = calibrate("night")["calibration"];
  EXPECT_EQ(calibration["state"], "failed");
  EXPECT_NE(calibration["verdict"].get<std::string>().find("[nightly]"), std::string::npos);
}

}  // namespace
}  // namespace panelcal::test
