// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/station.h"

#include <filesystem>
#include <thread>

#include <gtest/gtest.h>

#include "tests/machine/operator/operated_station.h"

namespace panelcal::test {
namespace {

class StationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write(folder_.path() / "machine.toml", small_config_text(""));
    write_test_camera(folder_.path());
    start();
    if (HasFatalFailure()) return;
    add("panel.exc", kSmallProgram);
  }

  void start() {
    auto station = Station::create(settings());
    ASSERT_TRUE(station) << station.error().text();
    station_ = *std::move(station);
  }
  StationSettings settings() const {
    return {.machine_file = folder_.path() / "machine.toml",
            .jobs_folder = folder_.path() / "jobs",
            .camera = {},
            .images = {},
            .machine_driver = "sim",
            .clock = fixed_clock(*from_iso_8601("2026-11-27T08:00:00Z"))};
  }
  void add(const std::string& name, std::string_view program) {
    const auto added = station_->add_program(name, program);
    ASSERT_TRUE(added) << added.error().text();
  }
  nlohmann::json screen() const { return nlohmann::json::parse(station_->state().json); }
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

  TemporaryFolder folder_;
  std::unique_ptr<Station> station_;
};

TEST_F(StationTest, NeedsExactlyOneSource) {
  StationSettings both = settings();
  both.images = "pictures";
  EXPECT_FALSE(Station::create(both));
  StationSettings neither = settings();
  neither.machine_driver.clear();
  EXPECT_FALSE(Station::create(neither));
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

}  // namespace
}  // namespace panelcal::test
