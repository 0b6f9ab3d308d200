// SPDX-License-Identifier: Apache-2.0
// The model that targets choose, its errors at holes, and the honesty of its ellipses.
//
//   model_bench choice [SIGMA_UM] [PANELS]    panels of each model, 3 to 12 targets on the rim
//   model_bench smooth [SIGMA_UM] [PANELS]    bowed panels, 6 to 40 targets anywhere
//   model_bench rim [SIGMA_UM] [PANELS]       the same, targets on the rim
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

#include "calib/panel/model_choice.h"
#include "calib/panel/smooth_panel.h"
#include "calib/panel/system.h"
#include <fmt/format.h>

#include "tests/calib/panel/bowed_panel.h"
#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal {
namespace {

using internal::fit_raw;
using test::Coefficients;
using test::coefficients_of;
using test::RawFit;
using test::RawPair;

constexpr int kHoles = 10;  // of each panel, anywhere on 500 x 400 mm

struct Errors {
  double sum_mm2 = 0;
  int n = 0;
  int n_inside = 0;

  void add(const Eigen::Vector2d& error_mm, const Eigen::Matrix2d& cov_mm2) {
    sum_mm2 += error_mm.squaredNorm();
    n_inside += test::is_in_ellipse(error_mm, cov_mm2) ? 1 : 0;
    ++n;
  }
  double rms_um() const { return 1e3 * std::sqrt(sum_mm2 / n); }
  double inside_percent() const { return 100.0 * n_inside / n; }
};

/// A panel with deformations of `ppm`, normally distributed, as far as the model has them.
Coefficients panel_of(Random& random, PanelModel model, double ppm) {
  const internal::ModelParameters p = test::random_parameters(random, model);
  const double theta_rad = random.normal() * 2e-3;
  const double sx = 1 + ppm * 1e-6 * random.normal();
  const double sy = 1 + ppm * 1e-6 * random.normal();
  const double shear = 0.5 * ppm * 1e-6 * random.normal();
  return test::deformed(model, p, theta_rad, sx, sy, shear);
}

struct ChoiceTrial {
  std::array<int, 5> n_chosen = {};
  Errors chosen, without, manual, affine;

  void add(const std::vector<RawPair>& pairs, const Coefficients& truth, Random& random) {
    const PanelModel usual = default_model(static_cast<int>(pairs.size()));
    const auto scores = internal::compare_raw(pairs, usual);
    const PanelModel model = panelcal::chosen(scores)->model;
    ++n_chosen[static_cast<std::size_t>(model)];
    const RawFit fit = *fit_raw(pairs, model).fit;
    const RawFit manual_fit = *fit_raw(pairs, usual).fit;
    const RawFit affine_fit = *fit_raw(pairs, PanelModel::Affine).fit;
    const Eigen::Matrix<double, 6, 6> choice_cov = internal::choice_covariance(pairs, scores);
    for (int i = 0; i < kHoles; ++i) {
      const Eigen::Vector2d hole_mm = test::random_place(random);
      const auto j = internal::design(hole_mm);
      const auto error = [&](const RawFit& f) -> Eigen::Vector2d {
        return j * (coefficients_of(f) - truth);
      };
      const Eigen::Matrix2d cov = j * fit.cov * j.transpose();
      chosen.add(error(fit), cov + j * choice_cov * j.transpose());
      without.add(error(fit), cov);
      manual.add(error(manual_fit), j * manual_fit.cov * j.transpose());
      affine.add(error(affine_fit), j * affine_fit.cov * j.transpose());
    }
  }
};

void choice_table(double sigma_mm, int n_panels) {
  fmt::print("sigma {} um, {} panels a row\n", sigma_mm * 1e3, n_panels);
  fmt::print(
      "truth ppm targets | chosen % offset rigid similarity stretch affine | rms um chosen "
      "manual affine | in 95 % chosen without manual\n");
  for (const double ppm : {300.0, 30.0}) {
    for (const PanelModel model : test::kAllModels) {
      if (ppm < 100 && model < PanelModel::Similarity) continue;  // as above
      for (const int n : {3, 4, 6, 12}) {
        Random random(1000 + 100 * static_cast<std::uint64_t>(n) +
                      static_cast<std::uint64_t>(model));
        ChoiceTrial trial;
        for (int i = 0; i < n_panels; ++i) {
          const Coefficients truth = panel_of(random, model, ppm);
          trial.add(test::rim_pairs(random, n, truth, sigma_mm), truth, random);
        }
        fmt::print("{:<10} {:>3} {:>2} |", name(model), ppm, n);
        for (const int n_chosen : trial.n_chosen)
          fmt::print(" {:>3.0f}", 100.0 * n_chosen / n_panels);
        fmt::print(" | {:5.2f} {:5.2f} {:5.2f} | {:5.1f} {:5.1f} {:5.1f}\n",
                   trial.chosen.rms_um(),
                   trial.manual.rms_um(),
                   trial.affine.rms_um(),
                   trial.chosen.inside_percent(),
                   trial.without.inside_percent(),
                   trial.manual.inside_percent());
      }
    }
  }
}

void smooth_table(double sigma_mm, int n_panels, bool is_rim) {
  fmt::print("sigma {} um, {} panels a row\n", sigma_mm * 1e3, n_panels);
  fmt::print(
      "bow um targets | parameters | rms um affine smooth | in 95 % affine smooth | "
      "recommended % | least ns a hole, with its covariance\n");
  for (const double bow_mm : {0.0, 0.003, 0.01, 0.03, 0.1}) {
    for (const int n : {6, 9, 12, 16, 25, 40}) {
      Random random(2000 + static_cast<std::uint64_t>(n));
      Errors affine, smooth;
      double parameters = 0;
      int n_recommended = 0;
      double least_s = 1;
      for (int i = 0; i < n_panels; ++i) {
        const Coefficients truth = panel_of(random, PanelModel::Affine, 300);
        const test::Bow bow(random, bow_mm);
        auto pairs = is_rim ? test::rim_pairs(random, n, truth, sigma_mm)
                            : test::random_pairs(random, n, truth, sigma_mm, true);
        for (RawPair& pair : pairs) pair.to_mm += bow(pair.from_mm);
        const auto fit = internal::fit_smooth_raw(pairs);
        const auto plain = fit_raw(pairs, PanelModel::Affine).fit;
        if (!fit || !plain) continue;
        parameters += fit->parameters / n_panels;
        const auto scores = internal::compare_raw(pairs, PanelModel::Stretch);
        n_recommended += recommended_smooth(scores) != nullptr ? 1 : 0;
        for (int k = 0; k < kHoles; ++k) {
          const Eigen::Vector2d hole_mm = test::random_place(random);
          const auto j = internal::design(hole_mm);
          const Eigen::Vector2d right_mm = j * truth + bow(hole_mm);
          affine.add(j * coefficients_of(*plain) - right_mm, j * plain->cov * j.transpose());
          const auto start = std::chrono::steady_clock::now();
          const Eigen::Vector2d place_mm = fit->map_mm(hole_mm);
          const Eigen::Matrix2d cov_mm2 = fit->cov_mm2(hole_mm);
          const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
          least_s = std::min(least_s, took.count());
          smooth.add(place_mm - right_mm, cov_mm2);
        }
      }
      fmt::print("{:>2} {:>2} | {:4.1f} | {:5.2f} {:5.2f} | {:5.1f} {:5.1f} | {:3.0f} | {:.0f}\n",
                 bow_mm * 1e3,
                 n,
                 parameters,
                 affine.rms_um(),
                 smooth.rms_um(),
                 affine.inside_percent(),
                 smooth.inside_percent(),
                 100.0 * n_recommended / n_panels,
                 1e9 * least_s);
    }
  }
}

}  // namespace
}  // namespace panelcal

int main(int argc, char** argv) {
  const std::string_view table = argc > 1 ? argv[1] : "choice";
  const double sigma_mm = (argc > 2 ? std::atof(argv[2]) : 5) * 1e-3;
  const int n_panels = argc > 3 ? std::atoi(argv[3]) : 2000;
  const bool is_known = table == "choice" || table == "smooth" || table == "rim";
  if (!(sigma_mm > 0) || n_panels < 1 || !is_known) {
    fmt::print(stderr, "model_bench choice|smooth|rim [SIGMA_UM] [PANELS]\n");
    return 2;
  }
  table == "choice" ? panelcal::choice_table(sigma_mm, n_panels)
                    : panelcal::smooth_table(sigma_mm, n_panels, table == "rim");
  return 0;
}
