// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/pictures/recording.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "machine/sources/picture_source.h"
#include <gtest/gtest.h>

#include "tests/machine/calibrate/spindle/coupon_job_run.h"
#include "tests/machine/counted_tasks.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearPosition;
using test::SimulatedJob;

/// G39,SPOP learns the offset from a hole that the job has drilled; the second hole, which is
/// drilled behind it, is seen with what it learned.
constexpr std::string_view kLearning =
    "%%5000\nX350.Y150.T1\nX350.Y150.G32\nG39,SPOP\nG34\nX360.Y150.T1\nX360.Y150.G32\n"
    "G31\nX370.Y150.T1\nG30\n$\nT1D0.8\n$\n";
/// Far above the digits of images.csv, far below the 30 um that the offset is off.
constexpr Length kSame = um(0.01);

void expect_same(const SimulatedJob& job, const SimulatedJob& other) {
  ASSERT_EQ(job.survey.measurements.size(), other.survey.measurements.size());
  for (std::size_t i = 0; i < job.survey.measurements.size(); ++i) {
    EXPECT_THAT(job.survey.measurements[i].measured.position,
                IsNearPosition(other.survey.measurements[i].measured.position, kSame))
        << "target " << i;
  }
  ASSERT_EQ(job.holes.size(), other.holes.size());
  for (std::size_t i = 0; i < job.holes.size(); ++i) {
    EXPECT_THAT(job.holes[i].drill.corrected, IsNearPosition(other.holes[i].drill.corrected, kSame))
        << "hole " << i;
  }
}

TEST(Recording, IsReadAsTheMachineThatItShowsWouldMeasure) {
  const test::TemporaryFolder folder;
  const MachineConfig config = test::machine_with_coupon(folder);
  const Program program = test::program_of(std::string(kLearning));
  const SimulatedJob live = test::run_simulated(std::string(kLearning), config);
  ASSERT_EQ(live.survey.measurements.size(), 2u) << test::all_text(live.log);
  ASSERT_FALSE(live.log.has_errors()) << test::all_text(live.log);

  auto machine = SimMachine::create(config, program);
  ASSERT_TRUE(machine) << machine.error().text();
  DiagnosticLog log;
  const auto recording =
      record_pictures(program, config, *machine, folder.path() / "pictures", log);
  ASSERT_TRUE(recording) << recording.error().text();
  ASSERT_FALSE(log.has_errors()) << test::all_text(log);

  test::CountedTasks ahead;
  for (Executor* const executor : std::vector<Executor*>{nullptr, &ahead}) {
    auto pictures = read_picture_folder(folder.path() / "pictures");
    ASSERT_TRUE(pictures) << pictures.error().text();
    auto source = PictureSource::create(config, *std::move(pictures), {}, executor);
    ASSERT_TRUE(source) << source.error().text();
    source->foresee([&] {
      std::vector<MeasurementRequest> requests;
      for (const Measurement& measurement : live.survey.measurements) {
        requests.push_back(measurement.request);
      }
      return requests;
    });
    SCOPED_TRACE(executor == nullptr ? "when they are asked for" : "ahead");
    expect_same(test::run_job(program, config, *source), live);
  }
  EXPECT_GT(ahead.n_posted, 0u);
}

}  // namespace
}  // namespace panelcal
