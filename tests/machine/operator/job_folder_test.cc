// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/job_folder.h"

#include <filesystem>

#include "tests/machine/operator/operated_station.h"

namespace panelcal::test {
namespace {

using internal::JobFolder;
using internal::JobRecord;
using internal::JobState;

JobRecord record() {
  JobRecord out;
  out.id = "2026-11-27-1";
  out.program = "panel.exc";
  out.who = "Anna";
  return out;
}

Measurement measured(std::int64_t seq) {
  Measurement out;
  out.request.seq = seq;
  out.request.command = "G36";
  out.request.settings.tools = {1};
  out.status = MeasurementStatus::Found;
  out.measured = {position_mm<frame::Actual>(1.25, 0.1), 1e-6 * Eigen::Matrix2d::Identity()};
  out.decision = {Decider::Hand, "An \"editor\"", "2026-11-27T08:00:00Z"};
  return out;
}

TEST(JobFolder, KeepsWhatItWasTold) {
  const TemporaryFolder jobs;
  {
    auto folder = JobFolder::create(jobs.path(), record());
    ASSERT_TRUE(folder) << folder.error().text();
    ASSERT_TRUE(folder->append(measured(0)));
    ASSERT_TRUE(folder->append(measured(1)));
    ASSERT_TRUE(folder->append(internal::JobChoice{1, "placed by hand", "Anna", "now"}));
    ASSERT_TRUE(folder->set_state(JobState::Asking));
  }
  const auto folder = JobFolder::open(jobs.path(), "2026-11-27-1");
  ASSERT_TRUE(folder) << folder.error().text();
  EXPECT_EQ(folder->record().state, JobState::Asking);
  EXPECT_EQ(folder->record().who, "Anna");
  ASSERT_EQ(folder->measurements().size(), 2U);
  EXPECT_EQ(folder->measurements()[1].decision.who, "An \"editor\"");
  EXPECT_EQ(folder->measurements()[1].measured.position, measured(1).measured.position);
  ASSERT_EQ(folder->choices().size(), 1U);
  EXPECT_EQ(folder->choices()[0].what, "placed by hand");
}

TEST(JobFolder, DropsALineThatAKillHasCutOff) {
  const TemporaryFolder jobs;
  { ASSERT_TRUE(JobFolder::create(jobs.path(), record())->append(measured(0))); }
  const auto file = jobs.path() / "2026-11-27-1/measurements.jsonl";
  const std::string whole = read_file(file).value_or("");
  const std::string second = to_json(measured(1)) + "\n";
  for (std::size_t n = 1; n < second.size(); n += 7) {
    write(file, whole + second.substr(0, n));
    auto folder = JobFolder::open(jobs.path(), "2026-11-27-1");
    ASSERT_TRUE(folder) << folder.error().text();
    EXPECT_EQ(folder->measurements().size(), 1U) << n;
    // The next one does not run into what is left of it.
    ASSERT_TRUE(folder->append(measured(2)));
    ASSERT_EQ(folder->measurements().size(), 2U) << n;
    EXPECT_EQ(folder->measurements()[1].request.seq, 2);
  }
}

TEST(JobFolder, IsNoOtherJobs) {
  const TemporaryFolder jobs;
  ASSERT_TRUE(JobFolder::create(jobs.path(), record()));
  EXPECT_FALSE(JobFolder::create(jobs.path(), record()));
  EXPECT_FALSE(JobFolder::open(jobs.path(), "2026-11-27-2"));
  EXPECT_FALSE(JobFolder::open(jobs.path(), "../2026-11-27-1"));
}

TEST(JobFolder, KnowsIdsAndFiles) {
  EXPECT_TRUE(internal::is_job_id("2026-11-27-12"));
  for (const char* const id : {"",
                               "2026-11-27",
                               "2026-11-27-",
                               "2026-11-27-0",
                               "2026-11-27-1/..",
                               "2026/11/27/1",
                               "2026-11-27-1234567"}) {
    EXPECT_FALSE(internal::is_job_id(id)) << id;
  }
  for (const char* const name :
       {"report.html", "output", "facts.json", "measurements.jsonl", "picture-0.jpg"}) {
    EXPECT_TRUE(internal::is_job_file(name)) << name;
  }
  for (const char* const name : {"",
                                 "job.json",
                                 "choices.jsonl",
                                 "picture-.jpg",
                                 "picture--1.jpg",
                                 "picture-01.jpg",
                                 "picture-1.png",
                                 "../output"}) {
    EXPECT_FALSE(internal::is_job_file(name)) << name;
  }
}

TEST(JobFolder, SortsJobsByTheirNumber) {
  const TemporaryFolder jobs;
  for (const char* const id : {"2026-11-27-10", "2026-11-27-9", "2026-11-26-11", "programs"}) {
    std::filesystem::create_directory(jobs.path() / id);
  }
  EXPECT_EQ(internal::list_jobs(jobs.path()),
            (std::vector<std::string>{"2026-11-26-11", "2026-11-27-9", "2026-11-27-10"}));
}

}  // namespace
}  // namespace panelcal::test
