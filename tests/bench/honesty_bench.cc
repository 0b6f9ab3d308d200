// SPDX-License-Identifier: Apache-2.0
// Are predicted covariances the real ones? The table in README.md.
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "tests/program/honesty/honesty_trial.h"

namespace panelcal {
namespace {

constexpr std::uint64_t kSeed = 20261121;

/// Chi square's own standard deviation per degree of freedom, for judging the column before it.
double chi_sigma(const test::HonestyResult& result) {
  return std::sqrt(2.0 / static_cast<double>(result.degrees_of_freedom));
}

bool is_honest(const test::HonestyResult& result) {
  const auto is_covered = [](double share) { return share >= 0.94 && share <= 0.96; };
  const double chi = result.chi_square / static_cast<double>(result.degrees_of_freedom);
  return result.n_failed == 0 && is_covered(result.all.share) && is_covered(result.outside.share) &&
         chi >= 0.95 && chi <= 1.05;
}

int run(int n_jobs) {
  fmt::print(
      "| series | model | detector um | jobs | sigma um | in 95 % | outside hull | chi2 / dof |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  bool all_honest = true;
  for (const bool has_nested : {false, true}) {
    for (const PanelModel model : {PanelModel::Offset,
                                   PanelModel::Rigid,
                                   PanelModel::Similarity,
                                   PanelModel::Stretch,
                                   PanelModel::Affine}) {
      for (const double detector_um : {1.0, 3.0, 10.0}) {
        const auto result = test::run({.model = model,
                                       .detector_um = detector_um,
                                       .has_nested = has_nested,
                                       .n_jobs = n_jobs,
                                       .seed = kSeed});
        all_honest = all_honest && is_honest(result);
        fmt::print(
            "| {} | {} | {} | {} | {:.2f} | {:.2f} +- {:.2f} % | {:.2f} +- {:.2f} % | {:.3f} +- "
            "{:.3f} |{}\n",
            has_nested ? "base, nested" : "base",
            name(model),
            detector_um,
            n_jobs - result.n_failed,
            result.mean_sigma_um,
            100 * result.all.share,
            100 * result.all.sigma,
            100 * result.outside.share,
            100 * result.outside.sigma,
            result.chi_square / static_cast<double>(result.degrees_of_freedom),
            chi_sigma(result),
            is_honest(result) ? "" : " <- outside of its bounds");
      }
    }
  }
  return all_honest ? 0 : 1;
}

}  // namespace
}  // namespace panelcal

int main(int argc, char** argv) {
  const int n_jobs = argc > 1 ? std::atoi(argv[1]) : 4000;
  if (n_jobs < 1 || argc > 2) {
    fmt::print(stderr, "usage: honesty_bench [JOBS of each kind, 4000]\n");
    return 2;
  }
  return panelcal::run(n_jobs);
}
