// SPDX-License-Identifier: Apache-2.0
// cam_prefixes FILE...: cuts real CAM files off and says what panelcal makes of it, one line a
// file. Exits with 1 if a part of one is accepted that drills anything else.
#include <cstdio>

#include "tests/program/prefix_trial.h"

int main(int n, char** arguments) {
  using panelcal::test::PrefixTrial;
  constexpr std::size_t kMostPrefixes = 1'000;
  bool is_good = n > 1;
  for (int i = 1; i < n; ++i) {
    auto source = panelcal::read_source(arguments[i]);
    PrefixTrial trial;
    if (source) panelcal::test::try_prefixes({*std::move(source), {}}, kMostPrefixes, trial);
    std::printf("%s: %s, %zu prefixes, %zu with the whole job, %zu accepted with the option\n",
                arguments[i],
                trial.n_whole == 1 ? "whole" : "refused",
                trial.n_prefixes,
                trial.n_as_whole,
                trial.n_accepted);
    for (const auto& complaint : trial.complaints) std::printf("  %s\n", complaint.c_str());
    is_good &= trial.n_files == 1 && trial.complaints.empty();
  }
  return is_good ? 0 : 1;
}
