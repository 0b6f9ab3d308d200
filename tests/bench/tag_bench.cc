// SPDX-License-Identifier: Apache-2.0
// Errors of tags against the physical bound, beside others' methods in one run. See README.md.
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "tests/vision/tag/accuracy.h"

namespace panelcal::bench {
namespace {

using test::TagAccuracy;
using test::TagErrors;

constexpr std::array<std::string_view, 5> kParts = {"clean", "typical", "dim", "hard", "family"};

void print_row(std::string_view who, const TagErrors& e, const TagAccuracy& all, int n) {
  fmt::print("| {} | {}/{} | {:.5f} | {:.2f} | {:.5f} | {:.2f} | {:.1f} |\n",
             who,
             e.n_found,
             n,
             e.center.value(),
             e.center.value() / all.center_bound.value(),
             e.corners.value(),
             e.corners.value() / all.corner_bound.value(),
             e.ms);
}

void run(std::string_view name, const test::TagScene& scene, const test::TagTrials& trials) {
  const TagAccuracy r = test::run_tag_trials(scene, trials);
  fmt::print("\n{}: contrast {:.0f}, noise {}, blur {}, {} id {}, side {:.0f} px, seed {}\n\n",
             name,
             scene.white - scene.black,
             scene.noise,
             scene.blur_px,
             trials.family,
             trials.id,
             trials.side_px,
             trials.seed);
  fmt::print("| who | found | center rmse px | / CRB | corner rmse px | / CRB | ms |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
  print_row("panelcal", r.ours, r, trials.n);
  print_row("AprilTag library", r.library, r, trials.n);
  print_row("+ cornerSubPix", r.opencv, r, trials.n);
  fmt::print("\nchi square of the covariance: center {:.3f}, corners {:.3f}{}{}\n",
             r.center_chi_square,
             r.corner_chi_square,
             r.first_failure.empty() ? "" : "; first not found: ",
             r.first_failure);
  std::fflush(stdout);
}

/// A tenth of the tag or of its outline covered, scratches and neighbours.
void run_hard(const test::TagTrials& trials) {
  test::TagTrials hard = test::hard_tag_trials();
  hard.n = trials.n;
  for (const double side_px : {120.0, 80.0}) {
    hard.side_px = side_px;
    run("hard", test::dim_tag_scene(), hard);
  }
}

int main_of(int argc, char** argv) {
  test::TagTrials trials;
  std::string_view only;
  for (int i = 1; i < argc; ++i) {
    const std::string_view text = argv[i];
    int n = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
    if (error == std::errc() && end == text.data() + text.size() && n > 0) {
      trials.n = n;
    } else if (std::find(kParts.begin(), kParts.end(), text) != kParts.end()) {
      only = text;
    } else {
      fmt::print(stderr, "usage: tag_bench [PICTURES] [clean|typical|dim|hard|family]\n");
      return 2;
    }
  }
  const auto wanted = [&](std::string_view part) { return only.empty() || only == part; };
  cv::setNumThreads(1);
  if (wanted("clean")) run("clean", test::clean_tag_scene(), trials);
  if (wanted("typical")) run("typical", test::typical_tag_scene(), trials);
  if (wanted("dim")) run("dim", test::dim_tag_scene(), trials);
  if (wanted("hard")) run_hard(trials);
  trials.family = "tagStandard41h12";
  trials.side_px = 90;
  if (wanted("family")) run("typical", test::typical_tag_scene(), trials);
  return 0;
}

}  // namespace
}  // namespace panelcal::bench

int main(int argc, char** argv) {
  return panelcal::bench::main_of(argc, argv);
}
