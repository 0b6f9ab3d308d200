// SPDX-License-Identifier: Apache-2.0
// Is a job with a hole out of tolerance ever released with a small risk? The tables in README.md.
#include <cstdlib>
#include <string>

#include <fmt/format.h>

#include "tests/calib/faults/binomial.h"
#include "tests/program/fault_trial.h"

namespace panelcal {
namespace {

constexpr std::uint64_t kSeed = 20261126;
constexpr double kConfidence = 0.99;

bool print_row(std::string_view name,
               const test::FaultTrial& trial,
               double lowest,
               double highest) {
  const test::FaultTrialResult r = test::run(trial);
  const int allowed = test::binomial_quantile(kConfidence, r.n_jobs, 1e-3);
  const bool is_healthy = trial.n_faults_most == 0 && !trial.only && !trial.noise_factor;
  const bool is_good = r.n_broken_sure <= allowed && r.coverage() >= lowest &&
                       r.coverage() <= highest && (!is_healthy || r.n_gated <= allowed);
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {:.2f} % |{}\n",
             name,
             r.n_jobs,
             r.n_gated,
             r.n_held,
             r.n_released,
             r.n_sure,
             r.n_broken,
             r.n_broken_sure,
             100 * r.coverage(),
             is_good ? "" : " <- outside of its bounds");
  return is_good;
}

int run(int n_jobs) {
  fmt::print(
      "| jobs with | jobs | held by gates | by tolerance | released | risk below 1e-3 | released, "
      "a "
      "hole out | of these below 1e-3 | in 95 % |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  const test::FaultTrial healthy{.n_jobs = n_jobs, .seed = kSeed};
  bool is_good = print_row("no fault", healthy, 0.94, 0.96);
  test::FaultTrial faulty = healthy;
  faulty.n_faults_most = 3;
  is_good = print_row("1 to 3 faults of random kinds", faulty, 0, 1) && is_good;
  for (const double factor : {0.5, 2.0}) {
    test::FaultTrial noise = healthy;
    noise.noise_factor = factor;
    noise.n_targets_least = 6;
    noise.nested_share = 0;
    const std::string name = fmt::format("noise {:g} times the stated, 6 to 12 targets", factor);
    is_good = print_row(name, noise, 0.9, 1) && is_good;
    noise.n_targets_most = 6;
    is_good = print_row("the same, 6 targets", noise, 0.9, 1) && is_good;
  }
  for (int i = 0; i <= test::kRandomFaults; ++i) {
    test::FaultTrial one = healthy;
    one.n_jobs = n_jobs / 5;
    one.only = static_cast<test::JobFault>(i);
    print_row(fmt::format("one fault: {}", test::name(*one.only)), one, 0, 1);
  }
  for (const int n_targets : {1, 2, 3}) {
    test::FaultTrial few = healthy;
    few.n_jobs = n_jobs / 5;
    few.n_targets_least = few.n_targets_most = n_targets;
    few.nested_share = 0;
    const std::string name = fmt::format("no fault, {} targets", n_targets);
    is_good = print_row(name, few, 0.94, 0.96) && is_good;
  }
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace panelcal

int main(int argc, char** argv) {
  const int n_jobs = argc > 1 ? std::atoi(argv[1]) : 5000;
  if (n_jobs < 1 || argc > 2) {
    fmt::print(stderr, "usage: fault_bench [JOBS of each kind, 5000]\n");
    return 2;
  }
  return panelcal::run(n_jobs);
}
