// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_circle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/median.h"
#include "vision/round/profile/rim_arc.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

constexpr int kArcStarts = 8;
constexpr double kStartArc = 0.6;  // of the rim
constexpr int kConcentrations = 2;
constexpr int kLastConcentrations = 3;
constexpr double kOffCircle = 3.5;  // sigmas
constexpr int kWholePasses = 8;
constexpr double kOffWhole = 3;        // sigmas
constexpr double kMoreOfWhole = 0.05;  // of the rim
/// An arc that lies on its circle up to some times the least sigma is round: the rest is displaced.
constexpr double kRoundArc = 2.3;

/// With less of the rim another circle may have as much.
constexpr double kMajority = 0.5;

using Use = std::vector<char>;

/// Radius, shift and the normal equations of some sectors.
struct CircleFit {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
};

class SectorWaves {
 public:
  explicit SectorWaves(Eigen::Index n) : cosine_(n), sine_(n) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const double phi = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      cosine_[i] = std::cos(phi);
      sine_[i] = std::sin(phi);
    }
  }
  CircleFit fit(const Eigen::VectorXd& d, const Use& use) const {
    double n = 0, c = 0, s = 0, cc = 0, cs = 0, dn = 0, dc = 0, ds = 0;
    for (Eigen::Index i = 0; i < d.size(); ++i) {
      if (use[static_cast<std::size_t>(i)] == 0) continue;
      ++n;
      c += cosine_[i];
      s += sine_[i];
      cc += cosine_[i] * cosine_[i];
      cs += cosine_[i] * sine_[i];
      dn += d[i];
      dc += d[i] * cosine_[i];
      ds += d[i] * sine_[i];
    }
    CircleFit circle;
    circle.normal << n, c, s, c, cc, cs, s, cs, n - cc;
    circle.value = (circle.normal + 1e-9 * Eigen::Matrix3d::Identity())
                       .ldlt()
                       .solve(Eigen::Vector3d(dn, dc, ds));
    return circle;
  }
  Eigen::VectorXd left(const Eigen::VectorXd& d, const Eigen::Vector3d& value) const {
    return d.array() - (value[0] + value[1] * cosine_ + value[2] * sine_);
  }

 private:
  Eigen::ArrayXd cosine_, sine_;
};

/// Means over n neighbours around, n odd, of usable ones.
Eigen::VectorXd smoothed(const Eigen::VectorXd& d, const Use& usable, int n) {
  Eigen::VectorXd means = d;
  const Eigen::Index size = d.size();
  for (Eigen::Index i = 0; i < size; ++i) {
    double sum = 0;
    double count = 0;
    for (int k = -(n / 2); k <= n / 2; ++k) {
      const Eigen::Index j = (i + k + size) % size;
      if (usable[static_cast<std::size_t>(j)] == 0) continue;
      sum += d[j];
      ++count;
    }
    if (count > 0) means[i] = sum / count;
  }
  return means;
}

std::size_t count_of(const Use& use) {
  return static_cast<std::size_t>(std::count(use.begin(), use.end(), 1));
}

/// The `n` usable sectors that are nearest to a circle; the squares they leave.
double nearest(const Eigen::VectorXd& left, const Use& usable, std::size_t n, Use& use) {
  std::vector<double> squares;
  squares.reserve(usable.size());
  for (std::size_t i = 0; i < usable.size(); ++i) {
    const double r = left[static_cast<Eigen::Index>(i)];
    if (usable[i] != 0) squares.push_back(r * r);
  }
  n = std::min(n, squares.size());
  const auto last = squares.begin() + static_cast<std::ptrdiff_t>(n) - 1;
  std::nth_element(squares.begin(), last, squares.end());
  const double limit = *last;
  use.assign(usable.size(), 0);
  double sum = 0;
  std::size_t n_used = 0;
  for (std::size_t i = 0; i < usable.size() && n_used < n; ++i) {
    const double r = left[static_cast<Eigen::Index>(i)];
    if (usable[i] == 0 || r * r > limit) continue;
    sum += r * r;
    use[i] = 1;
    ++n_used;
  }
  return sum;
}

/// Takes off the sectors beside those that are off already: what covers a rim has a blurred edge.
void take_off(const Use& off, int reach, Use& use) {
  const auto n = static_cast<int>(use.size());
  for (int i = 0; i < n; ++i) {
    if (off[static_cast<std::size_t>(i)] == 0) continue;
    for (int k = -reach; k <= reach; ++k) use[static_cast<std::size_t>((i + k + n) % n)] = 0;
  }
}

/// Sigma of normal numbers over the root mean square of the smallest `kept` of them.
double widening(std::size_t kept, std::size_t all) {
  const double share = static_cast<double>(kept) / static_cast<double>(all);
  // The limit below which this share of magnitudes is.
  const double z = normal_of_exceedance(0.5 * (1 - share));
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
  return 1 / std::sqrt(1 - 2 * z * density / share);
}

/// The circle whose `n_kept` nearest usable sectors leave the least squares.
struct ArcCircle {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  double squares = 0;
};

/// Least trimmed squares, started from the whole rim and from arcs of it.
ArcCircle fit_arc(const SectorWaves& waves,
                  const Eigen::VectorXd& d,
                  const Use& usable,
                  std::size_t n_kept) {
  const std::size_t n = usable.size();
  ArcCircle arc;
  arc.squares = INFINITY;
  for (int start = 0; start <= kArcStarts; ++start) {
    Use use = usable;
    for (std::size_t i = 0; start > 0 && i < n; ++i) {
      const std::size_t from = n * static_cast<std::size_t>(start - 1) / kArcStarts;
      if (static_cast<double>((i + n - from) % n) > kStartArc * static_cast<double>(n)) use[i] = 0;
    }
    if (count_of(use) < n_kept / 2) continue;
    double squares = INFINITY;
    Eigen::Vector3d value = waves.fit(d, use).value;
    for (int k = 0; k < kConcentrations; ++k) {
      squares = nearest(waves.left(d, value), usable, n_kept, use);
      value = waves.fit(d, use).value;
    }
    if (squares >= arc.squares) continue;
    arc.squares = squares;
    arc.value = value;
  }
  Use use;
  for (int k = 0; k < kLastConcentrations; ++k) {
    arc.squares = nearest(waves.left(d, arc.value), usable, n_kept, use);
    arc.value = waves.fit(d, use).value;
  }
  return arc;
}

/// A circle through all sectors but those that lie far off beside the rest.
struct WholeCircle {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  double scale_px = 0;
  Use use;
};

/// Least squares of the usable sectors within some median magnitudes, from all of them on.
WholeCircle fit_whole(const SectorWaves& waves,
                      const Eigen::VectorXd& d,
                      const Use& usable,
                      double floor_px) {
  WholeCircle whole;
  whole.use = usable;
  std::vector<double> magnitudes;
  for (int i = 0; i < kWholePasses; ++i) {
    whole.value = waves.fit(d, whole.use).value;
    const Eigen::VectorXd left = waves.left(d, whole.value);
    magnitudes.clear();
    for (std::size_t k = 0; k < usable.size(); ++k) {
      if (usable[k] != 0) magnitudes.push_back(std::abs(left[static_cast<Eigen::Index>(k)]));
    }
    whole.scale_px = std::max(floor_px, kSigmasPerMedian * median(std::move(magnitudes)));
    for (std::size_t k = 0; k < usable.size(); ++k) {
      whole.use[k] = usable[k] != 0 &&
                     std::abs(left[static_cast<Eigen::Index>(k)]) < kOffWhole * whole.scale_px;
    }
  }
  return whole;
}

/// The longest run of sectors that are off though they are usable, as part of all.
double longest_arc(const Use& off, const Use& usable) {
  const std::size_t n = off.size();
  std::size_t longest = 0;
  std::size_t run = 0;
  for (std::size_t i = 0; i < 2 * n; ++i) {
    run = off[i % n] != 0 && usable[i % n] != 0 ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return static_cast<double>(std::min(longest, n)) / static_cast<double>(n);
}

}  // namespace

Eigen::VectorXd residuals_about_circle(const Eigen::VectorXd& deviations, const Use& use) {
  const SectorWaves waves(deviations.size());
  return waves.left(deviations, waves.fit(deviations, use).value);
}

double RimCircle::used() const {
  return use.empty() ? 0 : static_cast<double>(count_of(use)) / static_cast<double>(use.size());
}

Eigen::VectorXd RimCircle::residuals(const Eigen::VectorXd& deviations) const {
  return SectorWaves(deviations.size()).left(deviations, {grown_px, shift_px.x(), shift_px.y()});
}

RimCircle fit_rim_circle(const Eigen::VectorXd& deviations,
                         const Use& usable,
                         int n_smooth,
                         double least_used,
                         double floor_px,
                         double own_px) {
  RimCircle result;
  result.use = usable;
  const auto n = static_cast<std::size_t>(deviations.size());
  const std::size_t n_usable = count_of(usable);
  // As many as are asked for where there are as many, so that no shorter arc is preferred to them.
  const double n_asked = least_used * static_cast<double>(n);
  const double n_least = static_cast<double>(n_usable) < n_asked
                             ? std::max(std::min(least_used, kMajority) * static_cast<double>(n),
                                        least_used * static_cast<double>(n_usable))
                             : n_asked;
  const auto n_kept = std::max<std::size_t>(8, static_cast<std::size_t>(n_least));
  const SectorWaves waves(deviations.size());
  result.seen = static_cast<double>(n_usable) / static_cast<double>(n);
  result.arc = equivalent_arc(waves.fit(deviations, usable).normal, static_cast<double>(n));
  if (n_usable < n_kept) return result;
  const Eigen::VectorXd d = smoothed(deviations, usable, n_smooth);

  const ArcCircle arc = fit_arc(waves, d, usable, n_kept);
  // Once: doing it again would let in, bit by bit, what lies just beside the circle.
  const Eigen::VectorXd left = waves.left(d, arc.value);
  const double least_px = floor_px / std::sqrt(static_cast<double>(n_smooth));
  result.scale_px = std::max(
      least_px, std::sqrt(arc.squares / static_cast<double>(n_kept)) * widening(n_kept, n_usable));
  Use off(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    off[i] = usable[i] == 0 ||
             std::abs(left[static_cast<Eigen::Index>(i)]) > kOffCircle * result.scale_px;
  }
  const WholeCircle whole = fit_whole(waves, d, usable, floor_px);
  const std::size_t n_on = n - count_of(off);
  const auto n_more = static_cast<std::size_t>(kMoreOfWhole * static_cast<double>(n));
  const bool is_own = whole.scale_px < own_px && result.scale_px > kRoundArc * least_px;
  const bool is_whole = is_own && count_of(whole.use) > n_on + n_more;
  if (is_whole) {
    result.scale_px = whole.scale_px;
    for (std::size_t i = 0; i < n; ++i) off[i] = whole.use[i] == 0;
  }
  result.use = usable;
  Use seen(n, 0);
  for (std::size_t i = 0; i < n; ++i) seen[i] = off[i] == 0;
  result.seen = static_cast<double>(count_of(seen)) / static_cast<double>(n);
  result.arc = equivalent_arc(waves.fit(deviations, seen).normal, static_cast<double>(n));
  result.displaced = longest_arc(off, usable);
  take_off(off, 1, result.use);
  if (count_of(result.use) < 8) return result;
  const CircleFit circle = waves.fit(deviations, result.use);
  result.grown_px = circle.value[0];
  result.shift_px = circle.value.tail<2>();
  const Eigen::Matrix3d inverse = circle.normal.inverse();
  result.unit_cov = inverse.bottomRightCorner<2, 2>();
  const Eigen::VectorXd rest = waves.left(deviations, circle.value);
  const auto n_used = static_cast<double>(count_of(result.use));
  for (std::size_t i = 0; i < n; ++i) {
    if (result.use[i] == 0) continue;
    const double phi = 4 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    result.oval_px += 2 / n_used * rest[static_cast<Eigen::Index>(i)] *
                      Eigen::Vector2d(std::cos(phi), std::sin(phi));
  }
  if (is_whole) result.doubt_px = circle.value.tail<2>() - arc.value.tail<2>();
  return result;
}

}  // namespace panelcal::internal
