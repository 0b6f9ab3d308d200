// SPDX-License-Identifier: Apache-2.0
// Rate at which the finder of outliers is right, over simulated jobs whose fault is known. The
// table in README.md; exit 1 if a goal is missed.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "tests/calib/faults/binomial.h"
#include "tests/calib/faults/simulated_faults.h"

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
constexpr double kGoal = 0.99;
/// A row is refused if chance alone gives one like it, or a worse one, less often than this.
constexpr double kAllowance = 0.05;

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
    if (std::getenv("OUTLIER_BENCH_SHOW") != nullptr && finding != Finding::Named) {
      fmt::print(stderr, "  {} of {}: {}\n", i, name(kind), fault ? fault->text() : "nothing");
    }
  }
  return counts;
}

int count_of(const Counts& c, Finding finding) {
  return c.findings[static_cast<std::size_t>(finding)];
}

/// So many at least, of jobs each of which comes out well with the chance of the goal.
bool is_reached(int n_good, int n) {
  return n > 0 && panelcal::test::binomial_at_most(n_good, n, kGoal) >= kAllowance;
}

bool row(std::string_view label, const Counts& c, bool is_good) {
  const auto percent = [&](int k) { return 100.0 * k / std::max(1, c.n); };
  fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |{}\n",
             label,
             c.n,
             percent(count_of(c, Finding::Named)),
             percent(count_of(c, Finding::Listed)),
             percent(count_of(c, Finding::Wrong)),
             percent(count_of(c, Finding::Missed)),
             percent(c.n_cause),
             is_good ? "" : " FAIL");
  std::fflush(stdout);
  return is_good;
}

/// Goal: 99 % of every kind are named.
bool named_faults(PanelModel model, int n, std::string_view wanted) {
  fmt::print(
      "\nmodel {}\n\n| fault | jobs | named | listed | wrong | missed | likeliest cause right |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n",
      name(model));
  FaultSettings settings = panelcal::test::usual_settings();
  settings.model = model;
  bool all_good = true;
  for (int k = 1; k <= static_cast<int>(SimulatedFault::Revision); ++k) {
    const auto kind = static_cast<SimulatedFault>(k);
    if (name(kind).find(wanted) == std::string_view::npos) continue;
    const Counts counts = count(kind, settings, n, static_cast<std::uint64_t>(k));
    const bool is_good = counts.n == n && is_reached(count_of(counts, Finding::Named), n);
    all_good = row(name(kind), counts, is_good) && all_good;
  }
  return all_good;
}

/// Goal: what is said is right in 99 %, however small the damage; a small one need not be named.
bool sizes(PanelModel model, int n) {
  bool all_good = true;
  for (const double size_mm : {0.03, 0.1, 0.3, 1.0, 3.0}) {
    FaultSettings settings = panelcal::test::usual_settings();
    settings.model = model;
    settings.least_size_mm = settings.greatest_size_mm = size_mm;
    const Counts counts = count(SimulatedFault::Damaged, settings, n, 50);
    const bool is_good = is_reached(n - count_of(counts, Finding::Wrong), n);
    const std::string label = fmt::format("damaged by {} mm, {}", size_mm, name(model));
    all_good = row(label, counts, is_good) && all_good;
  }
  return all_good;
}

/// Goal: as many are accused as stated, within the binomial band of 95 %.
bool healthy(int n) {
  bool all_good = true;
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
      const int low = panelcal::test::binomial_quantile(kAllowance / 2, n, kRates[k]);
      const int high = panelcal::test::binomial_quantile(1 - kAllowance / 2, n, kRates[k]);
      const bool is_good = low <= accused[k] && accused[k] <= high;
      all_good = all_good && is_good;
      fmt::print("| {} | {} | {} | {} to {} |{}\n",
                 name(model),
                 kRates[k],
                 accused[k],
                 low,
                 high,
                 is_good ? "" : " FAIL");
    }
    std::fflush(stdout);
  }
  return all_good;
}

}  // namespace

/// outlier_bench [JOBS] [healthy | sizes | part of a fault's name]
int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 1000;
  const std::string_view wanted = argc > 2 ? argv[2] : "";
  if (n < 1) {
    fmt::print(stderr, "usage: outlier_bench [JOBS] [healthy | sizes | part of a fault's name]\n");
    return 2;
  }
  bool all_good = true;
  if (wanted != "healthy" && wanted != "sizes") {
    for (const PanelModel model :
         {PanelModel::Stretch, PanelModel::Similarity, PanelModel::Rigid}) {
      all_good = named_faults(model, n, wanted) && all_good;
    }
  }
  if (wanted.empty() || wanted == "sizes") {
    fmt::print(
        "\n| size | jobs | named | listed | wrong | missed | likeliest cause right |\n"
        "| --- | --- | --- | --- | --- | --- | --- |\n");
    all_good = sizes(PanelModel::Stretch, n) && all_good;
    all_good = sizes(PanelModel::Similarity, n) && all_good;
  }
  if (wanted.empty() || wanted == "healthy") {
    all_good = healthy(10 * n) && all_good;
  }
  if (!all_good) fmt::print("\nFAIL: a goal is missed\n");
  return all_good ? 0 : 1;
}
