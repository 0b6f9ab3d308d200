// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/station.h"

#include <filesystem>
#include <thread>

#include <gtest/gtest.h>

#include "tests/machine/operator/operated_station.h"

namespace panelcal::test {
namespace {

class StationTest : public OperatedStation {
 protected:
  void SetUp() override {
    OperatedStation::SetUp();
    start();
    if (HasFatalFailure()) return;
    add("panel.exc", kSmallProgram);
  }
};

TEST_F(StationTest, NeedsExactlyOneSource) {
  StationSettings both = settings();
  both.images = "pictures";
  EXPECT_FALSE(Station::create(both));
  StationSettings neither = settings();
  neither.machine_driver.clear();
  EXPECT_FALSE(Station::create(neither));
}

TEST_F(StationTest, StatesNothingThatTheSchemaDoesNotName) {
  nlohmann::json screen = this->screen();
  EXPECT_EQ(screen_problem(screen), "");
  screen["programs"][0]["colour"] = "red";
  EXPECT_NE(screen_problem(screen), "");
  screen["programs"][0].erase("colour");
  screen["programs"][0]["size_bytes"] = -1;
  EXPECT_NE(screen_problem(screen), "");
  screen["programs"][0].erase("size_bytes");
  EXPECT_NE(screen_problem(screen), "");
}

TEST_F(StationTest, ListsProgramsByName) {
  add("another.drl", "M48\n%\nM30\n");
  const nlohmann::json programs = screen()["programs"];
  ASSERT_EQ(programs.size(), 2U);
  EXPECT_EQ(programs[0]["name"], "another.drl");
  EXPECT_EQ(programs[0]["size_bytes"], 10);
  EXPECT_EQ(programs[1]["name"], "panel.exc");
}

TEST_F(StationTest, RefusesNamesThatLeadElsewhere) {
  for (const char* const name : {"", ".", "..", ".hidden", "a/b", "../panel.exc", "a b", "a\nb"}) {
    EXPECT_FALSE(station_->add_program(name, "M48\n%\nM30\n")) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "jobs" / "panel.exc"));
  EXPECT_EQ(screen()["programs"].size(), 1U);
}

TEST_F(StationTest, RefusesAProgramThatIsTooLarge) {
  EXPECT_FALSE(station_->add_program("large.exc", std::string(kMaxProgramBytes + 1, ' ')));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "jobs/programs/large.exc"));
}

TEST_F(StationTest, ShowsWhereTheTargetsOfAProgramWillBe) {
  order(R"({"do":"open","program":"panel.exc"})");
  const nlohmann::json job = screen()["job"];
  EXPECT_EQ(job["id"], "2026-11-27-1");
  EXPECT_EQ(job["state"], "checked");
  ASSERT_EQ(job["targets"].size(), 7U);
  const nlohmann::json& fifth = job["targets"][4];
  EXPECT_EQ(fifth["seq"], 4);
  EXPECT_EQ(fifth["command"], "G46");
  EXPECT_EQ(fifth["tool"], 2);
  EXPECT_EQ(fifth["nominal_mm"], nlohmann::json({30, 40}));
  EXPECT_EQ(fifth["expected_mm"], nlohmann::json({30, 40}));
  EXPECT_EQ(fifth["status"], "waiting");
  EXPECT_EQ(job["series"].size(), 3U);
}

TEST_F(StationTest, ShowsTheFindingsOfAProgram) {
  add("wrong.exc", "M48\nMETRIC,TZ\nT1C0.8\n%\nG36X1.0Y1.0\nM30\n");
  order(R"({"do":"open","program":"wrong.exc"})");
  const nlohmann::json job = screen()["job"];
  const auto is_of_target = [](const nlohmann::json& finding) {
    return finding["code"] == "vision-tool-missing" && finding["severity"] == "error" &&
           finding["line"] == 5;
  };
  EXPECT_TRUE(std::ranges::any_of(job["findings"], is_of_target)) << job["findings"].dump(1);
}

TEST_F(StationTest, OpensOnlyWhatIsThere) {
  expect_refused(R"({"do":"open","program":"missing.exc"})");
  expect_refused(R"({"do":"open","program":"../../machine.toml"})");
  expect_refused(R"({"do":"close"})");
}

TEST_F(StationTest, ReplacesNoProgramThatIsOpen) {
  order(R"({"do":"open","program":"panel.exc"})");
  EXPECT_FALSE(station_->add_program("panel.exc", "M48\n%\nM30\n"));
  order(R"({"do":"close"})");
  EXPECT_FALSE(screen().contains("job"));
  EXPECT_TRUE(station_->add_program("panel.exc", "M48\n%\nM30\n"));
}

TEST_F(StationTest, WakesWhoWaitsForAChange) {
  const Station::State before = station_->state();
  std::thread screen_thread([&] { station_->wait(before.number, 0, std::chrono::minutes(5)); });
  order(R"({"do":"open","program":"panel.exc"})");
  screen_thread.join();  // hangs if the change wakes no screen
  EXPECT_GT(station_->state().number, before.number);
}

/// A camera that shows recorded pictures.
class WatchedStation : public OperatedStation {
 protected:
  void SetUp() override {
    OperatedStation::SetUp();
    take_pictures();
    StationSettings settings = this->settings();
    settings.camera = "folder:" + images_;
    settings.images.clear();
    auto station = Station::create(settings);
    ASSERT_TRUE(station) << station.error().text();
    station_ = *std::move(station);
  }
};

TEST_F(WatchedStation, TakesLivePicturesWhileAScreenLooks) {
  EXPECT_EQ(station_->frame(), nullptr);
  station_->set_watched(true);
  const nlohmann::json screen = wait_for([](const nlohmann::json& shown) {
    return shown.contains("view") && shown["view"]["frame"] >= 3;
  });
  EXPECT_EQ(screen["view"]["width_px"], 280);
  EXPECT_EQ(screen["view"]["um_per_px"], 0);
  ASSERT_NE(station_->frame(), nullptr);
  EXPECT_TRUE(station_->frame()->jpeg.starts_with("\xFF\xD8"));
}

}  // namespace
}  // namespace panelcal::test
