// SPDX-License-Identifier: Apache-2.0
// How often the finder of lying targets is right, over simulated jobs whose fault is known.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

#include "tests/calib/simulated_faults.h"

namespace {

using panelcal::FaultCause;
using panelcal::PanelModel;
using panelcal::Random;
using panelcal::SeriesFault;
using panelcal::test::FaultSettings;
using panelcal::test::Finding;
using panelcal::test::SimulatedFault;
using panelcal::test::SimulatedJob;

constexpr std::uint64_t kSeed = 20261121;

struct Counts {
  int n = 0;
  std::array<int, 4> findings{};
  int n_cause = 0;  ///< the right cause is the likeliest one
};

Counts count(SimulatedFault kind, const FaultSettings& settings, int n, std::uint64_t part) {
  Counts counts;
  const Random all(kSeed);
  for (std::uint64_t i = 0; counts.n < n && i < 4000ULL * static_cast<std::uint64_t>(n); ++i) {
    Random random = all.fork(part * 1'000'000'000 + i);
    const auto job = panelcal::test::draw_job(random, kind, settings);
    if (!job) continue;
    ++counts.n;
    const auto fault = job->examine();
    const Finding finding = panelcal::test::finding_of(*job, fault);
    ++counts.findings[static_cast<std::size_t>(finding)];
    if (fault && fault->suspicions[0].cause == job->cause) ++counts.n_cause;
    if (std::getenv("LIAR_BENCH_SHOW") != nullptr && finding != Finding::Named) {
      fmt::print("  {} of {}: {}\n", i, name(kind), fault ? fault->text() : "nothing");
    }
  }
  return counts;
}

void row(std::string_view label, const Counts& c) {
  const auto percent = [&](int k) { return 100.0 * k / std::max(1, c.n); };
  fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n",
             label,
             c.n,
             percent(c.findings[0]),
             percent(c.findings[1]),
             percent(c.findings[2]),
             percent(c.findings[3]),
             percent(c.n_cause));
  std::fflush(stdout);
}

void named_faults(PanelModel model, int n, std::string_view wanted) {
  fmt::print(
      "\nmodel {}\n\n| fault | jobs | named | listed | wrong | missed | likeliest cause right |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n",
      name(model));
  FaultSettings settings = panelcal::test::usual_settings();
  settings.model = model;
  for (int k = 1; k <= static_cast<int>(SimulatedFault::Revision); ++k) {
    const auto kind = static_cast<SimulatedFault>(k);
    if (name(kind).find(wanted) == std::string_view::npos) continue;
    row(name(kind), count(kind, settings, n, static_cast<std::uint64_t>(k)));
  }
}

void sizes(PanelModel model, int n) {
  for (const double size_mm : {0.03, 0.1, 0.3, 1.0, 3.0}) {
    FaultSettings settings = panelcal::test::usual_settings();
    settings.model = model;
    settings.least_size_mm = settings.greatest_size_mm = size_mm;
    row(fmt::format("damaged by {} mm, {}", size_mm, name(model)),
        count(SimulatedFault::Damaged, settings, n, 50));
  }
}

void healthy(int n) {
  fmt::print(
      "\n| healthy jobs | rate stated | accused of {} | expected, 95 % band |\n"
      "| --- | --- | --- | --- |\n",
      n);
  constexpr std::array kRates = {1e-3, 1e-2};
  for (const PanelModel model : {PanelModel::Stretch, PanelModel::Similarity, PanelModel::Rigid}) {
    FaultSettings settings = panelcal::test::usual_settings();
    settings.model = model;
    settings.has_pads = false;
    std::array<int, kRates.size()> accused{};
    const Random all(kSeed + 1 + static_cast<std::uint64_t>(model));
    for (int i = 0; i < n; ++i) {
      Random random = all.fork(static_cast<std::uint64_t>(i));
      auto job = panelcal::test::draw_job(random, SimulatedFault::Healthy, settings);
      for (std::size_t k = 0; k < kRates.size(); ++k) {
        // The test alone, not the other gates.
        job->limits = {};
        job->limits.false_alarm = kRates[k];
        if (job->examine()) ++accused[k];
      }
    }
    for (std::size_t k = 0; k < kRates.size(); ++k) {
      const double mean = n * kRates[k];
      const double half = 1.96 * std::sqrt(mean * (1 - kRates[k]));
      fmt::print("| {} | {} | {} | {:.0f} to {:.0f} |\n",
                 name(model),
                 kRates[k],
                 accused[k],
                 std::max(0.0, mean - half),
                 mean + half);
    }
    std::fflush(stdout);
  }
}

}  // namespace

/// liar_bench [JOBS] [healthy | sizes | part of a fault's name]
int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 1000;
  const std::string_view wanted = argc > 2 ? argv[2] : "";
  if (n < 1) return 2;
  if (wanted != "healthy" && wanted != "sizes") {
    for (const PanelModel model :
         {PanelModel::Stretch, PanelModel::Similarity, PanelModel::Rigid}) {
      named_faults(model, n, wanted);
    }
  }
  if (wanted.empty() || wanted == "sizes") {
    fmt::print(
        "\n| size | jobs | named | listed | wrong | missed | likeliest cause right |\n"
        "| --- | --- | --- | --- | --- | --- | --- |\n");
    sizes(PanelModel::Stretch, n);
    sizes(PanelModel::Similarity, n);
  }
  if (wanted.empty() || wanted == "healthy") healthy(10 * n);
  return 0;
}
