// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/bending/bending_likelihood.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "calib/base/statistics/chi_square.h"

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A trend whose columns are nearer to being dependent than this is not determined: a plane if only
/// rounding tells its slopes; bow and twist already if they would be told by how little the probes
/// stand off two rows, or by a strip so narrow that it has no bow across.
constexpr double kDependentBending = 1e-7;
constexpr double kDependentBow = 0.03;
/// Coefficients of a plane.
constexpr Index kPlane = 3;
/// Strongest bending by the noise: beyond it rounding is as large as the noise.
constexpr double kWeakest = 1e-4;
constexpr double kStrongest = 1e12;
/// Mean variance of the bendings by the scatter, and the most by the contrasts' mean square.
constexpr double kLeastByScatter = 0.01;
constexpr double kMostByScatter = 100;
constexpr double kVarianceStep = 2;
/// Readings nearer to each other are of one place, whose contrasts have nothing of a bending but
/// rounding.
constexpr double kSamePlace = 0.01;
/// How far a stage may stand off a place that is probed again: a bending that differs over so
/// little would be any number of times as strong elsewhere.
constexpr double kSameSpot = 1e-4;
/// Between two strengths that are tried, and between two lengths.
constexpr double kStrengthStep = 3;
constexpr double kLengthStep = 1.4142135623730951;
/// The readings' rectangle has the diagonal 2; no bending is longer, for what it would add is
/// trend.
constexpr double kLongest = 2;
/// Shortest length by the mean spacing: shorter ones differ from noise in nothing.
constexpr double kShortestBySpacing = 0.5;
/// Of golden sections: strengths to 1e-4 of the interval.
constexpr int kStrengthSteps = 20;
/// Parabolas through the best lengths: the likelihood is one about its maximum, so that few do.
constexpr int kLengthSteps = 4;
/// Of a length; no machine resolves less.
constexpr double kSameLength = 0.003;
/// A kernel that is worse by more at all lengths tried, in -2 log likelihood, is not refined.
constexpr double kWorseKernel = 10;

/// Argument of the minimum of f between low and high.
template <class Function>
double least(double low, double high, int n_steps, const Function& f) {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double a = high - golden * (high - low);
  double b = low + golden * (high - low);
  double fa = f(a), fb = f(b);
  for (int i = 0; i < n_steps; ++i) {
    if (fa < fb) {
      high = std::exchange(b, a);
      fb = fa;
      a = high - golden * (high - low);
      fa = f(a);
    } else {
      low = std::exchange(a, b);
      fa = fb;
      b = low + golden * (high - low);
      fb = f(b);
    }
  }
  return 0.5 * (low + high);
}

/// Argument of the minimum of the parabola through three values, of which the middle one is least.
double parabola_least(const std::array<double, 3>& x, const std::array<double, 3>& f) {
  const double before = (f[1] - f[0]) / (x[1] - x[0]);
  const double behind = (f[2] - f[1]) / (x[2] - x[1]);
  const double bend = (behind - before) / (x[2] - x[0]);
  return bend > 0 ? 0.5 * (x[0] + x[1] - before / bend) : x[1];
}

/// k^2 of this number of contrasts.
double noise_variance(double chi_square, Index n_contrasts) {
  constexpr double kPrior = BendingLikelihood::kPriorReadings;
  return (chi_square + kPrior) / (static_cast<double>(n_contrasts) + kPrior);
}

bool is_determined(const MatrixXd& trend, double threshold) {
  return internal::has_full_column_rank(trend, threshold);
}

/// Places that were probed again at the very place of their first reading.
Eigen::Matrix2Xd spots_of(Eigen::Matrix2Xd places) {
  for (Index i = 1; i < places.cols(); ++i) {
    Index first = 0;
    const double apart =
        (places.leftCols(i).colwise() - places.col(i)).colwise().norm().minCoeff(&first);
    if (apart <= kSameSpot) places.col(i) = places.col(first).eval();
  }
  return places;
}

/// The lower half alone.
MatrixXd distances_of(const Eigen::Matrix2Xd& places) {
  const Index n = places.cols();
  MatrixXd out(n, n);
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) out(i, j) = (places.col(i) - places.col(j)).norm();
  }
  return out;
}

/// Of distances in the lower half.
Index n_places_of(const MatrixXd& distances) {
  Index n = 0;
  for (Index i = 0; i < distances.rows(); ++i) {
    if (i == 0 || distances.row(i).head(i).minCoeff() > kSamePlace) ++n;
  }
  return n;
}

bool is_better(const Bending& a, const Bending& b) {
  return a.minus_2_log_likelihood < b.minus_2_log_likelihood;
}

}  // namespace

/// Contrasts z ~ N(0, k^2 (1 + s T)) with T tridiagonal.
struct BendingLikelihood::Tridiagonal {
  VectorXd diagonal;
  VectorXd beside;
  VectorXd z;
  bool is_scatter_stated = true;

  /// Noise factor and likelihood of a strength, by Cholesky's decomposition of 1 + s T.
  Bending at(double strength) const {
    Bending out;
    out.strength_mm2 = strength;
    double pivot = 1, carried = 0, log_determinant = 0, chi_square = 0;
    for (Index i = 0; i < z.size(); ++i) {
      const double by_pivot = i > 0 ? strength * beside[i - 1] / pivot : 0;
      carried = z[i] - by_pivot * carried;
      pivot = 1 + strength * diagonal[i] - (i > 0 ? by_pivot * strength * beside[i - 1] : 0);
      if (!(pivot > 0)) return out;
      log_determinant += std::log(pivot);
      chi_square += carried * carried / pivot;
    }
    if (is_scatter_stated) {
      out.minus_2_log_likelihood = log_determinant + chi_square;
      return out;
    }
    const double variance = noise_variance(chi_square, z.size());
    out.noise_factor = std::sqrt(variance);
    out.minus_2_log_likelihood =
        log_determinant +
        (static_cast<double>(z.size()) + BendingLikelihood::kPriorReadings) * std::log(variance);
    return out;
  }
};

Trend trend_at(const Eigen::Vector2d& place, Index n_trend) {
  const double x = place.x(), y = place.y();
  Trend all(6);
  all << 1, x, y, x * x, x * y, y * y;
  return all.head(n_trend);
}

std::optional<BendingLikelihood> BendingLikelihood::of(const Readings& readings, Index n_trend) {
  const Index n = readings.heights_mm.size();
  if (n < n_trend) return std::nullopt;
  BendingLikelihood out;
  out.distances_ = distances_of(spots_of(readings.places));
  out.n_places_ = n_places_of(out.distances_);
  out.weights_per_mm_ = readings.sigmas_mm.cwiseInverse();
  out.is_scatter_stated_ = readings.is_scatter_stated;
  MatrixXd trend(n, n_trend);
  for (Index i = 0; i < n; ++i) {
    trend.row(i) = trend_at(readings.places.col(i), n_trend).transpose();
  }
  const MatrixXd weighted = out.weights_per_mm_.asDiagonal() * trend;
  // The places of the probes tell whether there is a bow to find, whatever they are said to
  // scatter.
  if (n_trend > kPlane && !is_determined(trend, kDependentBow)) return std::nullopt;
  if (!is_determined(weighted, kDependentBending)) return std::nullopt;
  out.qr_ = OrthogonalTriangular(weighted);
  const MatrixXd q = out.qr_.q();
  const MatrixXd r = out.qr_.r();
  out.contrasts_ = q.rightCols(n - n_trend);
  out.trend_root_ = r.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(n_trend, n_trend));
  out.trend_of_heights_ =
      out.trend_root_ * q.leftCols(n_trend).transpose() * out.weights_per_mm_.asDiagonal();
  out.z_ = out.contrasts_.transpose() * out.weights_per_mm_.cwiseProduct(readings.heights_mm);
  return out;
}

MatrixXd BendingLikelihood::covariance(BendingKernel kernel, double length) const {
  const Index n = distances_.rows();
  MatrixXd out(n, n);
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) {
      out(i, j) = out(j, i) = bending_covariance(kernel, distances_(i, j) / length);
    }
  }
  return out;
}

MatrixXd BendingLikelihood::contrast_covariance(const MatrixXd& covariance) const {
  const MatrixXd all =
      qr_.turned(weights_per_mm_.asDiagonal() * covariance * weights_per_mm_.asDiagonal());
  return all.bottomRightCorner(n_contrasts(), n_contrasts());
}

double BendingLikelihood::noise_factor(double chi_square) const {
  return is_scatter_stated_ ? 1 : std::sqrt(noise_variance(chi_square, n_contrasts()));
}

BendingLikelihood::Tridiagonal BendingLikelihood::tridiagonal(BendingKernel kernel,
                                                              double length) const {
  if (kernel == BendingKernel::None || n_contrasts() < 2 || !has_seen_bending()) {
    return {VectorXd::Zero(n_contrasts()),
            VectorXd::Zero(std::max<Index>(0, n_contrasts() - 1)),
            z_,
            is_scatter_stated_};
  }
  TridiagonalForm form = tridiagonal_form(contrast_covariance(covariance(kernel, length)), z_);
  return {
      std::move(form.diagonal), std::move(form.beside), std::move(form.turned), is_scatter_stated_};
}

Bending BendingLikelihood::mean_strength(BendingKernel kernel, double length, double share) const {
  const Tridiagonal contrasts = tridiagonal(kernel, length);
  Bending out = contrasts.at(0);
  out.kernel = kernel;
  out.length = length;
  const auto n = static_cast<double>(n_contrasts());
  const double per_strength = n > 0 ? contrasts.diagonal.sum() / n : 0;
  if (!(per_strength > 0)) return out;
  const double most = kMostByScatter * std::max(1.0, z_.squaredNorm() / n);
  std::vector<Bending> tried;
  for (double v = kLeastByScatter; v <= most; v *= kVarianceStep) {
    tried.push_back(contrasts.at(v / per_strength));
  }
  const double least = std::ranges::min_element(tried, is_better)->minus_2_log_likelihood;
  double sum = 0, strengths = 0;
  for (const Bending& one : tried) {
    const double weight = std::exp(-0.5 * share * (one.minus_2_log_likelihood - least));
    sum += weight;
    strengths += weight * one.strength_mm2;
  }
  out.strength_mm2 = strengths / sum;
  out.noise_factor = contrasts.at(out.strength_mm2).noise_factor;
  out.minus_2_log_likelihood =
      least - 2 / share * std::log(sum / static_cast<double>(tried.size()));
  return out;
}

bool BendingLikelihood::is_trend_enough() const {
  constexpr double kLeastChance = 1e-3;
  if (n_contrasts() == 0) return true;
  return chi_square_exceedance(z_.squaredNorm(), static_cast<int>(n_contrasts())) >= kLeastChance;
}

double BendingLikelihood::noise_factor_of_trend() const {
  return std::sqrt(noise_variance(z_.squaredNorm(), n_contrasts()));
}

Bending BendingLikelihood::best_strength(BendingKernel kernel, double length) const {
  const Tridiagonal contrasts = tridiagonal(kernel, length);
  const double largest = n_contrasts() > 1 ? contrasts.diagonal.maxCoeff() : 0;
  Bending best = contrasts.at(0);
  if (largest > 0) {
    double best_log = 0;
    const double low = std::log(kWeakest / largest), high = std::log(kStrongest / largest);
    const double step = std::log(kStrengthStep);
    for (double t = low; t <= high; t += step) {
      const Bending tried = contrasts.at(std::exp(t));
      if (!is_better(tried, best)) continue;
      best = tried;
      best_log = t;
    }
    if (best.strength_mm2 > 0) {
      const auto badness = [&](double t) {
        return contrasts.at(std::exp(t)).minus_2_log_likelihood;
      };
      const double refined_log = least(
          std::max(low, best_log - step), std::min(high, best_log + step), kStrengthSteps, badness);
      const Bending refined = contrasts.at(std::exp(refined_log));
      if (is_better(refined, best)) best = refined;
    }
  }
  best.kernel = kernel;
  best.length = length;
  return best;
}

std::vector<double> BendingLikelihood::lengths(double factor, double shortest_by_spacing) const {
  const double spacing = kLongest / std::sqrt(static_cast<double>(distances_.rows()));
  const double shortest = std::min(1.0, shortest_by_spacing * spacing);
  std::vector<double> out;
  for (double length = kLongest; length >= shortest; length /= factor) out.push_back(length);
  return out;
}

Bending BendingLikelihood::refined(std::span<const Bending> tried) const {
  const auto best = std::ranges::min_element(tried, is_better);
  if (tried.size() < 2 || !(best->strength_mm2 > 0)) return *best;
  // Three lengths, falling, of which the middle one is best.
  std::array<Bending, 3> around;
  if (best != tried.begin() && std::next(best) != tried.end()) {
    around = {*std::prev(best), *best, *std::next(best)};
  } else {
    const Bending& beside = best == tried.begin() ? *std::next(best) : *std::prev(best);
    const Bending middle = best_strength(best->kernel, std::sqrt(best->length * beside.length));
    if (!is_better(middle, *best)) return *best;
    around = best == tried.begin() ? std::array{*best, middle, beside}
                                   : std::array{beside, middle, *best};
  }
  for (int i = 0; i < kLengthSteps; ++i) {
    std::array<double, 3> logs = {}, badness = {};
    for (std::size_t k = 0; k < around.size(); ++k) {
      logs[k] = std::log(around[k].length);
      badness[k] = around[k].minus_2_log_likelihood;
    }
    const double next_log = parabola_least(logs, badness);
    if (std::abs(next_log - logs[1]) < kSameLength) break;
    const Bending next = best_strength(best->kernel, std::exp(next_log));
    const bool is_longer = next_log > logs[1];
    if (is_better(next, around[1])) {
      around[is_longer ? 2 : 0] = std::exchange(around[1], next);
    } else {
      around[is_longer ? 0 : 2] = next;
    }
  }
  return around[1];
}

Bending BendingLikelihood::best_of(std::span<const BendingKernel> kernels) const {
  std::vector<std::vector<Bending>> tried;
  Bending best;
  for (const BendingKernel kernel : kernels) {
    // A surface that does not bend, or bends like a thin plate, has no length of its own.
    const bool has_length = kernel != BendingKernel::None && kernel != BendingKernel::ThinPlate;
    tried.emplace_back();
    for (const double length :
         has_length ? lengths(kLengthStep, kShortestBySpacing) : std::vector<double>{1}) {
      tried.back().push_back(best_strength(kernel, length));
      if (is_better(tried.back().back(), best)) best = tried.back().back();
    }
  }
  const double limit = best.minus_2_log_likelihood + kWorseKernel;
  for (const std::vector<Bending>& of_kernel : tried) {
    if (!(std::ranges::min_element(of_kernel, is_better)->minus_2_log_likelihood <= limit))
      continue;
    const Bending better = refined(of_kernel);
    if (is_better(better, best)) best = better;
  }
  return best;
}

}  // namespace panelcal::internal
