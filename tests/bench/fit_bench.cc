// SPDX-License-Identifier: Apache-2.0
// Time of a fit with its covariance, against Ceres on the same targets in the same run.
//
//   fit_bench [FITS]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "calib/panel/fit.h"
#include <ceres/ceres.h>
#include <fmt/format.h>

#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal {
namespace {

using internal::RawPair;

constexpr double kSigma_mm = 2e-3;

/// [theta, x scale, y scale, tx, ty], or with kIsRigid [theta, tx, ty].
template <bool kIsRigid>
struct Residual {
  RawPair pair;

  template <class T>
  bool operator()(const T* p, T* out) const {
    const T x = (kIsRigid ? T(1) : p[1]) * pair.from_mm.x();
    const T y = (kIsRigid ? T(1) : p[2]) * pair.from_mm.y();
    const T* t = p + (kIsRigid ? 1 : 3);
    out[0] = (pair.to_mm.x() - cos(p[0]) * x + sin(p[0]) * y - t[0]) / kSigma_mm;
    out[1] = (pair.to_mm.y() - sin(p[0]) * x - cos(p[0]) * y - t[1]) / kSigma_mm;
    return true;
  }
};

/// Of one coordinate, so that the compiler keeps the work.
template <bool kIsRigid>
double by_ceres(const std::vector<RawPair>& pairs) {
  constexpr int kParameters = kIsRigid ? 3 : 5;
  double p[5] = {0, kIsRigid ? 0.0 : 1.0, kIsRigid ? 0.0 : 1.0, 0, 0};
  ceres::Problem problem;
  for (const RawPair& pair : pairs) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Residual<kIsRigid>, 2, kParameters>(
                                 new Residual<kIsRigid>{pair}),
                             nullptr,
                             p);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance covariance(covariance_options);
  double cov[kParameters * kParameters] = {};
  const std::vector<std::pair<const double*, const double*>> blocks = {{p, p}};
  if (covariance.Compute(blocks, &problem)) covariance.GetCovarianceBlock(p, p, cov);
  return p[0] + cov[0];
}

double by_us(const std::vector<RawPair>& pairs, PanelModel model) {
  const auto result = internal::fit_raw(pairs, model);
  return result.fit ? result.fit->linear(0, 1) + result.fit->cov(0, 0) : 0;
}

std::vector<std::vector<RawPair>> panels(PanelModel model, int n_targets) {
  constexpr int kPanels = 64;
  Random random(20261122);
  std::vector<std::vector<RawPair>> out(kPanels);
  for (auto& pairs : out) {
    const auto a = internal::coefficients(model, test::random_parameters(random, model));
    for (int i = 0; i < n_targets; ++i) {
      const Eigen::Vector2d from_mm(300 * random.uniform(), 300 * random.uniform());
      const Eigen::Vector2d to_mm(a[0] * from_mm.x() + a[1] * from_mm.y() + a[4],
                                  a[2] * from_mm.x() + a[3] * from_mm.y() + a[5]);
      const Eigen::Vector2d noise_mm(kSigma_mm * random.normal(), kSigma_mm * random.normal());
      pairs.push_back(
          {from_mm, to_mm + noise_mm, kSigma_mm * kSigma_mm * Eigen::Matrix2d::Identity()});
    }
  }
  return out;
}

/// Least microseconds a fit of five passes.
template <class Fit>
double microseconds(const std::vector<std::vector<RawPair>>& panels, int n, Fit&& fit) {
  double least = 1e300;
  volatile double kept = 0;
  for (int pass = 0; pass < 5; ++pass) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < n; ++i)
      kept = kept + fit(panels[static_cast<std::size_t>(i) % panels.size()]);
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - start;
    least = std::min(least, took.count() / n);
  }
  return least;
}

void row(PanelModel model, int n_targets, int n) {
  const auto targets = panels(model, n_targets);
  const double own = microseconds(targets, n, [&](const auto& p) { return by_us(p, model); });
  const double peer = microseconds(targets, std::max(1, n / 10), [&](const auto& p) {
    return model == PanelModel::Rigid ? by_ceres<true>(p) : by_ceres<false>(p);
  });
  fmt::print(
      "| {} | {} | {:.2f} | {:.1f} | {:.3f} |\n", name(model), n_targets, own, peer, own / peer);
}

}  // namespace
}  // namespace panelcal

int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 20000;
  if (n < 1) return 2;
  fmt::print(
      "| model | targets | us a fit | Ceres us | ratio |\n| --- | --- | --- | --- | --- |\n");
  using panelcal::PanelModel;
  for (const int n_targets : {2, 3, 4, 20, 200}) {
    panelcal::row(PanelModel::Rigid, n_targets, n_targets > 20 ? n / 10 : n);
    if (n_targets > 2) panelcal::row(PanelModel::Stretch, n_targets, n_targets > 20 ? n / 10 : n);
  }
  return 0;
}
