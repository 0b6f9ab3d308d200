// SPDX-License-Identifier: Apache-2.0
// What docs/howto/threads.md allows: several threads ask one object. Also run by the thread
// sanitizer (tools/test.sh --nightly).
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "surface/map/zoned_map.h"
#include <gtest/gtest.h>
#include <panelcal/panelcal.h>

#include "tests/support/folders.h"

namespace panelcal {
namespace {

using namespace std::chrono_literals;

constexpr int kThreads = 4;

/// What each of several threads makes of the same objects, all at once.
template <class Make>
auto made_at_once(const Make& make) {
  std::vector<decltype(make())> made(kThreads);
  std::vector<std::jthread> threads;
  for (auto& one : made) threads.emplace_back([&] { one = make(); });
  threads.clear();
  return made;
}

class Text final : public JobOutput {
 public:
  Expected<void> begin() override {
    all.clear();
    return {};
  }
  Expected<void> write(std::string_view bytes) override {
    all += bytes;
    return {};
  }
  Expected<void> commit() override { return {}; }

  std::string all;
};

TEST(SharedObjects, OneMachineAndOneProgramAreCorrectedByManyThreads) {
  const std::filesystem::path demo = test::source_folder() / "datasets/demo";
  const auto machine = read_machine_config(demo / "machine.toml");
  ASSERT_TRUE(machine) << machine.error().text();
  auto job =
      read_job((demo / "panel.exc").string(), *machine, std::chrono::sys_days{2026y / 11 / 23});
  ASSERT_TRUE(job) << job.error().text();
  job->format = OutputFormat::Excellon;
  const auto corrected = [&] {
    Text program;
    const auto open = [&](const Survey& asked) {
      return open_sources({.images = (demo / "images").string()}, *machine, asked);
    };
    const auto result = correct(*job, open, *machine, {.output = &program});
    return result && result->may_be_drilled() ? program.all : std::string();
  };
  const std::string alone = corrected();
  ASSERT_NE(alone, "");
  for (const std::string& one : made_at_once(corrected)) EXPECT_EQ(one, alone);
}

TEST(SharedObjects, OneMapAnswersManyThreads) {
  std::vector<ProbePoint> probed;
  for (int i = 0; i < 100; ++i) {
    const double x_mm = 20.0 * (i % 10), y_mm = 20.0 * (i / 10);
    probed.push_back(
        {.place = position_mm<frame::Nominal>(x_mm, y_mm),
         .measured = {.height = mm(1.6 + 1e-3 * x_mm + 1e-3 * (i * 7 % 5)), .sigma = um(2)}});
  }
  const auto map = ZonedMap::of_probes(probed, {}, {});
  ASSERT_TRUE(map) << map.error().text();
  const auto heights = [&] {
    std::vector<double> found_mm;
    for (double x_mm = 1; x_mm < 180; x_mm += 3.7) {
      const auto height = map->height_at(position_mm<frame::Nominal>(x_mm, 180 - x_mm));
      found_mm.push_back(height ? height->height.height.in_mm() : 0);
    }
    return found_mm;
  };
  const std::vector<double> alone = heights();
  for (const std::vector<double>& one : made_at_once(heights)) EXPECT_EQ(one, alone);
}

}  // namespace
}  // namespace panelcal
