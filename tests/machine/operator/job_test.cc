// SPDX-License-Identifier: Apache-2.0
// Whole jobs by a station: as `run` where no person is asked, by a person's choices, after a kill.
#include "machine/job/job.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "machine/job/output/output.h"
#include "machine/sources/measurement_file_source.h"
#include <sys/wait.h>
#include <unistd.h>

#include "tests/machine/operator/operated_station.h"
#include "tests/support/folders.h"

namespace panelcal::test {
namespace {

/// Corrects a program as `panelcal run` does; what it writes.
std::string corrected(const std::filesystem::path& machine_file,
                      const std::filesystem::path& program,
                      const SourceChoice& choice,
                      const std::filesystem::path& output) {
  const auto machine = read_machine_config(machine_file);
  EXPECT_TRUE(machine) << machine.error().text();
  if (!machine) return "";
  auto job = read_job(program.string(), *machine, *from_iso_8601("2026-11-27T08:00:00Z"));
  EXPECT_TRUE(job) << job.error().text();
  if (!job) return "";
  job->format = OutputFormat::Excellon;
  FileOutput file(output);
  const OpenJobSources open = [&](const Survey& nominal) {
    return open_sources(choice, *machine, nominal);
  };
  const auto result = correct(*job, open, *machine, {.output = &file});
  EXPECT_TRUE(result) << result.error().text();
  return read_file(output).value_or("");
}

class StationJob : public OperatedStation {
 protected:
  std::string run_output(const SourceChoice& choice) {
    write(folder_.path() / "alone.exc", kSmallProgram);
    return blocks_of(corrected(folder_.path() / "machine.toml",
                               folder_.path() / "alone.exc",
                               choice,
                               folder_.path() / "alone.drl"));
  }
  /// The small program by pictures, of which one shows nothing; asks about it.
  nlohmann::json run_without(std::size_t seq) {
    take_pictures();
    blank(seq);
    open_small_program();
    order(R"({"do":"start"})");
    return wait_until_it_rests();
  }
};

TEST_F(StationJob, DrillsAsRunDoesOnAVirtualMachine) {
  open_small_program();
  order(R"({"do":"start"})");
  const nlohmann::json job = wait_until_it_rests();
  EXPECT_EQ(job["state"], "done") << job.dump(1);
  EXPECT_TRUE(job["verdict"]["may_drill"]);
  EXPECT_EQ(job["n_holes"], 2);
  const std::string expected = run_output({.command = "test", .machine_driver = "sim"});
  ASSERT_FALSE(expected.empty());
  EXPECT_EQ(blocks_of(file_of("output")), expected);
}

TEST_F(StationJob, DrillsAsRunDoesOnTheDemo) {
  const std::filesystem::path demo = source_folder() / "datasets/demo";
  std::filesystem::copy_file(demo / "machine.toml",
                             folder_.path() / "machine.toml",
                             std::filesystem::copy_options::overwrite_existing);
  std::filesystem::copy_file(demo / "camera.cal.json",
                             folder_.path() / "camera.cal.json",
                             std::filesystem::copy_options::overwrite_existing);
  images_ = (demo / "images").string();
  start();
  add("panel.exc", read_file(demo / "panel.exc").value_or(""));
  order(R"({"do":"open","program":"panel.exc"})");
  order(R"({"do":"start"})");
  const nlohmann::json job = wait_until_it_rests();
  EXPECT_EQ(job["state"], "done") << job.dump(1);
  EXPECT_EQ(job["n_holes"], 990);
  const std::string expected = blocks_of(corrected(demo / "machine.toml",
                                                   demo / "panel.exc",
                                                   {.command = "test", .images = images_},
                                                   folder_.path() / "alone.drl"));
  ASSERT_FALSE(expected.empty());
  EXPECT_EQ(blocks_of(file_of("output")), expected);
}

TEST_F(StationJob, ShowsTargetsAndFits) {
  open_small_program();
  order(R"({"do":"start"})");
  const nlohmann::json job = wait_until_it_rests();
  for (const nlohmann::json& target : job["targets"]) {
    EXPECT_EQ(target["status"], "found");
    EXPECT_EQ(target["by"], "camera");
    EXPECT_TRUE(target.contains("measured_mm"));
    EXPECT_TRUE(target.contains("residual_um"));
    EXPECT_TRUE(target["has_picture"]);
  }
  for (const nlohmann::json& series : job["series"]) EXPECT_TRUE(series["is_accepted"]);
  EXPECT_TRUE(file_of("picture-6.jpg").starts_with("\xFF\xD8"));
  EXPECT_TRUE(job["has_report"]);
  EXPECT_NE(file_of("report.html").find("\"facts\":\"job\""), std::string::npos);
  const nlohmann::json view = screen()["view"];
  EXPECT_EQ(view["width_px"], 280);
  EXPECT_NEAR(view["um_per_px"].get<double>(), 10, 1e-9);
  EXPECT_NEAR(view["search"]["radius_px"].get<double>(), 90, 1e-6);
  ASSERT_NE(station_->frame(), nullptr);
  EXPECT_EQ(view["frame"], station_->frame()->number);
}

TEST_F(StationJob, GivesTheProgramANameOnlyWhenItMayBeDrilled) {
  open_small_program();
  expect_refused(R"({"do":"write","name":"panel.drl"})");
  order(R"({"do":"start"})");
  wait_until_it_rests();
  expect_refused(R"({"do":"write","name":"panel.sm"})");
  expect_refused(R"({"do":"write","name":"../panel.drl"})");
  order(R"({"do":"write","name":"panel.drl"})");
  EXPECT_EQ(job()["outputs"], nlohmann::json({"panel.drl"}));
  EXPECT_NE(job()["verdict"]["words"].get<std::string>().find("Load panel.drl"), std::string::npos)
      << job()["verdict"];
  EXPECT_EQ(read_file(folder_.path() / "jobs/2026-11-27-1/panel.drl").value_or(""),
            file_of("output"));
}

TEST_F(StationJob, RefusesOrdersOutOfTheirOrder) {
  start();
  expect_refused(R"({"do":"start"})");
  expect_refused(R"({"do":"stop"})");
  expect_refused(R"({"do":"resume"})");
  expect_refused(R"({"do":"answer","question":1,"choice":"again"})");
  expect_refused(R"({"do":"jog","by_mm":[0.1,0]})");
  add("panel.exc", kSmallProgram);
  order(R"({"do":"open","program":"panel.exc"})");
  order(R"({"do":"start"})");
  EXPECT_FALSE(station_->command(R"({"do":"start"})", "Ben"));
  wait_until_it_rests();
  expect_refused(R"({"do":"start"})");
  expect_refused(R"({"do":"resume"})");
}

TEST_F(StationJob, StartsNoProgramThatChangedSinceItsCheck) {
  open_small_program();
  write(folder_.path() / "jobs/programs/panel.exc", small_program_with("X1.0Y1.0"));
  order(R"({"do":"start"})");
  EXPECT_EQ(wait_until_it_rests()["state"], "failed");
}

TEST_F(StationJob, StartsNoProgramWithErrors) {
  start();
  add("wrong.exc", "M48\nMETRIC,TZ\nT1C0.8\n%\nG36X1.0Y1.0\nM30\n");
  order(R"({"do":"open","program":"wrong.exc"})");
  expect_refused(R"({"do":"start"})");
}

TEST_F(StationJob, AsksAboutATargetThatIsMissing) {
  const nlohmann::json job = run_without(6);
  ASSERT_EQ(job["state"], "asking") << job.dump(1);
  EXPECT_EQ(job["question"]["seq"], 6);
  EXPECT_EQ(job["targets"][6]["status"], "not_found");
  EXPECT_EQ(job["targets"][5]["status"], "found");
  // Two targets of a board: the rigid model follows one of them wherever it is.
  EXPECT_TRUE(job["question"]["why_not"].contains("skip"));
  EXPECT_TRUE(job["question"]["why_not"].contains("candidate"));
  EXPECT_EQ(job["question"]["why_not"]["jog"], "recorded pictures do not move");
  EXPECT_FALSE(job["question"].contains("jog_mm"));
  EXPECT_TRUE(job["question"]["why_not"].contains("lamp"));
  EXPECT_TRUE(job["question"]["why_not"].contains("exposure"));
  expect_refused(R"({"do":"answer","question":1,"choice":"again","exposure":2000})");
  expect_refused(R"({"do":"answer","question":1,"choice":"keep"})");
  expect_refused(R"({"do":"answer","question":1,"choice":"skip"})");
  expect_refused(R"({"do":"answer","question":1,"choice":"candidate","index":0})");
  expect_refused(R"({"do":"answer","question":2,"choice":"again"})");
  expect_refused(R"({"do":"answer","question":1,"choice":"hand","at_px":[280,10]})");
  expect_refused(R"({"do":"jog","by_mm":[0.1,0]})");
  expect_refused(R"({"do":"close"})");
}

TEST_F(StationJob, LeavesABoardOutAndDrillsTheOther) {
  const nlohmann::json asked = run_without(6);
  const auto& choices = asked["question"]["choices"];
  ASSERT_NE(std::ranges::find(choices, "leave_board_out"), choices.end()) << asked["question"];
  order(R"({"do":"answer","question":1,"choice":"leave_board_out"})");
  const nlohmann::json job = wait_until_it_rests();
  EXPECT_EQ(job["state"], "done") << job.dump(1);
  EXPECT_EQ(job["n_holes"], 1);
  const nlohmann::json& target = job["targets"][6];
  EXPECT_EQ(target["status"], "board_left_out");
  EXPECT_EQ(target["by"], "leave_board_out");
  EXPECT_EQ(target["who"], "Anna");
  EXPECT_EQ(target["when"], "2026-11-27T08:00:00Z");
  EXPECT_EQ(job["series"][2]["words"], "board left out");
  const std::string words = job["verdict"]["words"];
  EXPECT_NE(words.find("not drilled: board [1] (line 16)"), std::string::npos) << words;
  EXPECT_NE(file_of("output").find("its board left out"), std::string::npos);
  EXPECT_NE(file_of("facts.json").find("\"is_left_out\":true"), std::string::npos);

  // The recorded measurements give the same program.
  const std::filesystem::path recorded = folder_.path() / "recorded.jsonl";
  write(recorded, file_of("measurements.jsonl"));
  write(folder_.path() / "alone.exc", kSmallProgram);
  const std::string replayed = corrected(folder_.path() / "machine.toml",
                                         folder_.path() / "alone.exc",
                                         {.command = "test", .measurements = recorded.string()},
                                         folder_.path() / "alone.drl");
  ASSERT_FALSE(replayed.empty());
  EXPECT_EQ(blocks_of(replayed), blocks_of(file_of("output")));
}

TEST_F(StationJob, LeavesNoLastBoardOut) {
  take_pictures();
  blank(4);
  blank(6);
  open_small_program();
  order(R"({"do":"start"})");
  wait_until_it_rests();
  order(R"({"do":"answer","question":1,"choice":"leave_board_out"})");
  const nlohmann::json second = wait_until_it_rests();
  EXPECT_EQ(second["question"]["seq"], 6);
  EXPECT_EQ(second["question"]["why_not"]["leave_board_out"], "no board would be left");
  expect_refused(R"({"do":"answer","question":2,"choice":"leave_board_out"})");
}

TEST_F(StationJob, LeavesNoPanelOut) {
  const nlohmann::json job = run_without(1);
  EXPECT_TRUE(job["question"]["why_not"].contains("leave_board_out"));
}

TEST_F(StationJob, AsksAboutABoardWhoseTargetsDisagree) {
  take_pictures();
  rows_[6].axis = rows_[6].axis + displacement_mm<frame::Machine>(0.2, 0);
  write_list();
  open_small_program();
  order(R"({"do":"start"})");
  const nlohmann::json asked = wait_until_it_rests();
  ASSERT_EQ(asked["state"], "asking") << asked.dump(1);
  // Two targets: either may be the wrong one.
  EXPECT_GE(asked["question"]["seq"], 5);
  const auto& choices = asked["question"]["choices"];
  EXPECT_NE(std::ranges::find(choices, "keep"), choices.end()) << choices;
  order(R"({"do":"answer","question":1,"choice":"leave_board_out"})");
  const nlohmann::json job = wait_until_it_rests();
  EXPECT_EQ(job["state"], "done") << job.dump(1);
  EXPECT_EQ(job["n_holes"], 1);
}

TEST_F(StationJob, AsksAgainWhileNothingIsFound) {
  const nlohmann::json first = run_without(6);
  order(R"({"do":"answer","question":1,"choice":"again"})");
  const nlohmann::json second = wait_for([](const nlohmann::json& screen) {
    return screen["job"].contains("question") && screen["job"]["question"]["id"] == 2;
  })["job"];
  EXPECT_EQ(second["state"], "asking");
  EXPECT_EQ(second["question"]["seq"], 6);
  expect_refused(R"({"do":"answer","question":1,"choice":"again"})");
}

TEST_F(StationJob, DrillsByATargetThatAPersonPlaces) {
  take_pictures();
  // Where the target is in its picture, before it is gone.
  open_small_program();
  order(R"({"do":"start"})");
  const nlohmann::json whole = wait_until_it_rests();
  const double x_px = screen()["view"]["ellipse"]["at_px"][0];
  const double y_px = screen()["view"]["ellipse"]["at_px"][1];
  station_.reset();
  std::filesystem::remove_all(folder_.path() / "jobs");

  blank(6);
  open_small_program();
  order(R"({"do":"start"})");
  wait_until_it_rests();
  order(nlohmann::json(
            {{"do", "answer"}, {"question", 1}, {"choice", "hand"}, {"at_px", {x_px, y_px}}})
            .dump());
  const nlohmann::json job = wait_until_it_rests();
  EXPECT_EQ(job["state"], "done") << job.dump(1);
  const nlohmann::json& target = job["targets"][6];
  EXPECT_EQ(target["by"], "hand");
  EXPECT_EQ(target["who"], "Anna");
  EXPECT_EQ(target["when"], "2026-11-27T08:00:00Z");
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(target["measured_mm"][axis].get<double>(),
                whole["targets"][6]["measured_mm"][axis].get<double>(),
                1e-4);
    // Half a pixel of 10 um, but for the lens.
    EXPECT_NEAR(target["sigma_um"][axis].get<double>(), 5, 0.05);
  }
  const nlohmann::json facts = nlohmann::json::parse(file_of("facts.json"));
  EXPECT_EQ(facts["targets"][6]["decision"]["by"], "hand");
  EXPECT_FALSE(facts["targets"][5].contains("decision"));
  EXPECT_NE(file_of("output").find("placed by hand"), std::string::npos);
  EXPECT_NE(file_of("output").find("Anna"), std::string::npos);

  // A recording of it drills the same.
  const auto recorded = parse_measurements(file_of("measurements.jsonl"), "test");
  ASSERT_TRUE(recorded) << recorded.error().text();
  EXPECT_EQ(recorded->measurements[6].answer.decision.by, Decider::Hand);
  EXPECT_EQ(recorded->measurements[6].answer.decision.who, "Anna");
  const std::string file = (folder_.path() / "jobs/2026-11-27-1/measurements.jsonl").string();
  EXPECT_EQ(blocks_of(file_of("output")), run_output({.command = "test", .measurements = file}));
}

TEST_F(StationJob, StopsInTheMiddle) {
  run_without(4);
  order(R"({"do":"stop"})");
  const nlohmann::json job = wait_until_it_rests();
  EXPECT_EQ(job["state"], "stopped");
  EXPECT_FALSE(job.contains("question"));
  EXPECT_FALSE(job["verdict"]["may_drill"]);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "jobs/2026-11-27-1/output"));
  expect_refused(R"({"do":"write","name":"panel.drl"})");
  expect_refused(R"({"do":"answer","question":1,"choice":"again"})");
}

// --- kept on the disk --------------------------------------------------------------------------

constexpr const char* kKilledFolder = "PANELCAL_TEST_KILLED_FOLDER";
constexpr const char* kKilledAfter = "PANELCAL_TEST_KILLED_AFTER";

/// A station that measures in the folder of another process, and is killed.
class KilledStation : public StationJob {
 protected:
  void measure_until_killed(const std::filesystem::path& folder, int n_measured);
};

void KilledStation::measure_until_killed(const std::filesystem::path& folder, int n_measured) {
  StationSettings settings = this->settings();
  settings.machine_file = folder / "machine.toml";
  settings.jobs_folder = folder / "jobs";
  auto station = Station::create(settings);
  ASSERT_TRUE(station) << station.error().text();
  station_ = *std::move(station);
  add("panel.exc", kSmallProgram);
  order(R"({"do":"open","program":"panel.exc"})");
  order(R"({"do":"start"})");
  wait_for([&](const nlohmann::json& screen) {
    const auto& targets = screen["job"]["targets"];
    return std::ranges::count(targets, "found", [](const nlohmann::json& target) {
             return target["status"].get<std::string>();
           }) >= n_measured;
  });
  raise(SIGKILL);
}

/// Runs GoesOnAfterAKill as the process that is killed; the status of its end.
int end_of_killed_process(const std::filesystem::path& folder, int n_measured) {
  setenv(kKilledFolder, folder.c_str(), 1);
  setenv(kKilledAfter, std::to_string(n_measured).c_str(), 1);
  const pid_t child = fork();
  if (child == 0) {
    execl("/proc/self/exe",
          "operator_test",
          "--gtest_filter=KilledStation.GoesOnAfterAKill",
          static_cast<char*>(nullptr));
    _exit(1);
  }
  unsetenv(kKilledFolder);
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST_F(KilledStation, GoesOnAfterAKill) {
  if (const char* const folder = std::getenv(kKilledFolder)) {
    return measure_until_killed(folder, std::atoi(std::getenv(kKilledAfter)));
  }
  // The answer of a job that no kill has cut off.
  const std::string whole = run_output({.command = "test", .machine_driver = "sim"});
  int n_resumed = 0;
  for (int n_measured = 0; n_measured <= 6; ++n_measured) {
    SCOPED_TRACE(n_measured);
    std::filesystem::remove_all(folder_.path() / "jobs");
    const int status = end_of_killed_process(folder_.path(), n_measured);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    start();
    // The kill may come before the job has a folder, or when it has ended.
    if (screen().contains("job") && job()["state"] == "resumable") {
      ++n_resumed;
      expect_refused(R"({"do":"open","program":"panel.exc"})");
      order(R"({"do":"resume"})");
      const nlohmann::json job = wait_until_it_rests();
      EXPECT_EQ(job["state"], "done") << job.dump(1);
      const std::string words = job["again"]["words"];
      if (n_measured >= 2) {
        EXPECT_NE(words.find("the others count"), std::string::npos) << words;
        EXPECT_EQ(job["again"]["seqs"].size(), 2U);
      }
      EXPECT_EQ(blocks_of(file_of("output")), whole);
    }
    station_.reset();
  }
  EXPECT_GE(n_resumed, 4);
}

TEST_F(StationJob, CountsNothingOfAPanelThatWasMoved) {
  run_without(6);
  const double x_mm = job()["targets"][5]["measured_mm"][0];
  station_.reset();
  constexpr double kMoved_mm = 0.05;
  for (PictureRow& row : rows_) row.axis = row.axis + displacement_mm<frame::Machine>(kMoved_mm, 0);
  write_list();
  start();
  EXPECT_EQ(job()["state"], "resumable");
  EXPECT_EQ(job()["targets"][5]["status"], "found");
  order(R"({"do":"resume"})");
  const nlohmann::json moved = wait_until_it_rests();
  ASSERT_EQ(moved["state"], "asking");
  const std::string words = moved["again"]["words"];
  EXPECT_NE(words.find("measured anew"), std::string::npos) << words;
  EXPECT_NEAR(moved["targets"][5]["measured_mm"][0].get<double>(), x_mm + kMoved_mm, 0.002);
}

TEST_F(StationJob, CountsWhatWasMeasuredOnAPanelThatLiesStill) {
  run_without(6);
  const nlohmann::json before = job()["targets"][5];
  station_.reset();
  // Of what was measured only the two farthest apart are looked at again: 1 and 2.
  blank(0);
  start();
  order(R"({"do":"resume"})");
  const nlohmann::json after = wait_until_it_rests();
  ASSERT_EQ(after["state"], "asking");
  EXPECT_EQ(after["question"]["seq"], 6) << after["again"].dump(1);
  EXPECT_EQ(after["targets"][5]["measured_mm"], before["measured_mm"]);
}

TEST_F(StationJob, CountsNothingWithAnotherMachineFile) {
  run_without(6);
  station_.reset();
  write(folder_.path() / "machine.toml", small_config_text("") + "blur_px = 1.1\n");
  start();
  order(R"({"do":"resume"})");
  const std::string words = wait_until_it_rests()["again"]["words"];
  EXPECT_NE(words.find("machine.toml or a calibration has changed"), std::string::npos) << words;
}

TEST_F(StationJob, KnowsAJobThatHasEndedBeforeItsProgramIsWritten) {
  open_small_program();
  order(R"({"do":"start"})");
  const nlohmann::json before = wait_until_it_rests();
  station_.reset();
  start();
  const nlohmann::json after = job();
  EXPECT_EQ(after["state"], "done");
  EXPECT_EQ(after["verdict"], before["verdict"]);
  EXPECT_EQ(after["n_holes"], before["n_holes"]);
  EXPECT_TRUE(after["has_facts"]);
  EXPECT_TRUE(after["has_report"]);
  order(R"({"do":"write","name":"panel.drl"})");
  expect_refused(R"({"do":"resume"})");
  order(R"({"do":"close"})");
  station_.reset();
  start();
  EXPECT_FALSE(screen().contains("job"));
}

TEST_F(StationJob, ForgetsAJobThatIsClosed) {
  run_without(6);
  station_.reset();
  start();
  order(R"({"do":"close"})");
  station_.reset();
  start();
  EXPECT_FALSE(screen().contains("job"));
}

}  // namespace
}  // namespace panelcal::test
