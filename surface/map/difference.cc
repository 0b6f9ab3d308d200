// SPDX-License-Identifier: Apache-2.0
#include "surface/map/difference.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/linear_algebra.h"
#include "surface/fit/even_part.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// Columns of the model: 1, x, y, x^2, x y, y^2, in units of half the rectangle's sides.
constexpr Index kOffset = 1, kTilt = 3, kBow = 6;
/// Below it columns are dependent: probes in one line, or in two rows.
constexpr double kDependentDifference = 1e-3;
/// Fewer differences are not asked for bow and twist.
constexpr Index kLeastForCurves = 9;
/// Places along either side of what both maps probed.
constexpr int kAlong = 80;

/// Differences at the later probes, with their covariance, um.
struct Differences {
  std::vector<Position<frame::Nominal>> places;
  VectorXd values_um;
  MatrixXd covariance_um2;
};

Differences differences_of(const StoredMap& before,
                           const SurfaceFit& predictor,
                           const StoredMap& after,
                           std::size_t& n_outside) {
  Differences out;
  std::vector<double> heights_mm, sigmas_mm;
  for (const std::size_t i : after.map.kept()) {
    const ProbePoint& probe = after.points[i];
    if (!before.map.height_at(probe.place)) {
      ++n_outside;
      continue;
    }
    out.places.push_back(probe.place);
    heights_mm.push_back(probe.measured.height.in_mm());
    sigmas_mm.push_back(after.map.surface().noise_factor() * probe.measured.sigma.in_mm());
  }
  if (out.places.empty()) return out;
  const std::vector<HeightEstimate> predicted = predictor.at(out.places);
  out.covariance_um2 = 1e6 * predictor.covariance_mm2(out.places);
  out.values_um.resize(static_cast<Index>(out.places.size()));
  for (std::size_t i = 0; i < out.places.size(); ++i) {
    const auto at = static_cast<Index>(i);
    out.values_um[at] = 1e3 * (heights_mm[i] - predicted[i].height.in_mm());
    out.covariance_um2(at, at) += 1e6 * sigmas_mm[i] * sigmas_mm[i];
  }
  return out;
}

/// Differences and model in units of their errors.
struct Whitened {
  MatrixXd model;
  VectorXd values;

  bool is_determined(Index n_columns) const {
    return internal::has_full_column_rank(model.leftCols(n_columns), kDependentDifference);
  }
  MatrixXd covariance(Index n) const {
    const MatrixXd normal = model.leftCols(n).transpose() * model.leftCols(n);
    return internal::Cholesky(normal).inverse();
  }
  VectorXd solution(Index n) const {
    return covariance(n) * (model.leftCols(n).transpose() * values);
  }
  double chi_square(Index n) const {
    if (n == 0) return values.squaredNorm();
    return (values - model.leftCols(n) * solution(n)).squaredNorm();
  }
};

/// Intersection of two outlines, convex and counter-clockwise (Sutherland and Hodgman 1974).
std::vector<Vector2d> intersection(std::span<const Position<frame::Nominal>> a,
                                   std::span<const Position<frame::Nominal>> b) {
  std::vector<Vector2d> out;
  for (const auto& corner : a) out.push_back(corner.in_mm());
  for (std::size_t i = 0; i < b.size() && !out.empty(); ++i) {
    const Vector2d from = b[i].in_mm(), side = b[(i + 1) % b.size()].in_mm() - from;
    const auto left_of = [&](const Vector2d& p) {
      return side.x() * (p.y() - from.y()) - side.y() * (p.x() - from.x());
    };
    std::vector<Vector2d> kept;
    for (std::size_t k = 0; k < out.size(); ++k) {
      const Vector2d& p = out[k];
      const Vector2d& next = out[(k + 1) % out.size()];
      const double here = left_of(p), there = left_of(next);
      if (here >= 0) kept.push_back(p);
      if ((here < 0) != (there < 0)) kept.push_back(p + here / (here - there) * (next - p));
    }
    out = std::move(kept);
  }
  return out;
}

/// Root mean square and greatest difference over what both maps probed.
bool look_over(const HeightMap& before, const HeightMap& after, MapDifference& out) {
  out.common_mm = intersection(before.hull(), after.hull());
  if (out.common_mm.size() < 3) return false;
  Vector2d low_mm = out.common_mm.front(), high_mm = low_mm;
  for (const Vector2d& corner : out.common_mm) {
    low_mm = low_mm.cwiseMin(corner);
    high_mm = high_mm.cwiseMax(corner);
  }
  double sum_mm2 = 0, n = 0;
  for (int j = 0; j <= kAlong; ++j) {
    for (int i = 0; i <= kAlong; ++i) {
      const Vector2d part(static_cast<double>(i) / kAlong, static_cast<double>(j) / kAlong);
      const auto place =
          position_mm<frame::Nominal>(Vector2d(low_mm + part.cwiseProduct(high_mm - low_mm)));
      const auto was = before.height_at(place), is = after.height_at(place);
      if (!was || !is || was->outside > mm(0) || is->outside > mm(0)) continue;
      const Length difference = is->height - was->height;
      sum_mm2 += difference.in_mm() * difference.in_mm();
      n += 1;
      if (n > 1 && std::abs(difference.in_mm()) <= std::abs(out.greatest.in_mm())) continue;
      out.greatest = difference;
      out.greatest_sigma = mm(std::hypot(was->sigma.in_mm(), is->sigma.in_mm()));
      out.greatest_at = place;
    }
  }
  if (!(n > 0)) return false;
  out.rms = mm(std::sqrt(sum_mm2 / n));
  return true;
}

}  // namespace

Expected<SurfaceFit> predictor_of(const StoredMap& stored) {
  const SurfaceFit& fit = stored.map.surface();
  if (!is_of_grid(fit.model())) return fit;
  const std::vector<ProbePoint> points = stored.kept_points();
  return fit_surface(
      points.size() > kMostBentProbes ? internal::even_part(points, kMostProbes) : points,
      SurfaceModel::GaussianProcess);
}

Expected<MapDifference> difference_of(const StoredMap& before, const StoredMap& after) {
  MapDifference out;
  PANELCAL_TRY(const SurfaceFit predictor, predictor_of(before));
  out.model = predictor.model();
  const Differences found = differences_of(before, predictor, after, out.n_outside);
  out.n_probes = found.places.size();
  const auto n = static_cast<Index>(found.places.size());
  const auto nothing = [&]() {
    return failure({Code::GridInvalid,
                    {},
                    fmt::format("{} probes of the later map stand where the earlier one gives "
                                "heights",
                                out.n_probes),
                    "3 or more, not in one line, and a part that both maps probed"});
  };
  if (n < kTilt || !look_over(before.map, after.map, out)) return nothing();
  Vector2d low_mm = found.places.front().in_mm(), high_mm = low_mm;
  for (const auto& place : found.places) {
    low_mm = low_mm.cwiseMin(place.in_mm());
    high_mm = high_mm.cwiseMax(place.in_mm());
  }
  out.center_mm = 0.5 * (low_mm + high_mm);
  out.half_mm = 0.5 * (high_mm - low_mm);
  if (!(out.half_mm.minCoeff() > 0)) return nothing();
  MatrixXd model(n, kBow);
  for (Index i = 0; i < n; ++i) {
    const Vector2d p = (found.places[static_cast<std::size_t>(i)].in_mm() - out.center_mm)
                           .cwiseQuotient(out.half_mm);
    model.row(i) << 1, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
  }
  const internal::Cholesky root(found.covariance_um2);
  const Whitened whitened{root.whiten(model), root.whiten(found.values_um)};
  if (!whitened.is_determined(kTilt)) return nothing();
  const double scatter_dof =
      std::min(predictor.degrees_of_freedom(), after.map.surface().degrees_of_freedom());
  const auto part = [&](double chi_square, Index dof) {
    return DifferencePart{
        chi_square,
        static_cast<int>(dof),
        variance_ratio_exceedance(std::max(0.0, chi_square) / static_cast<double>(dof),
                                  static_cast<double>(dof),
                                  scatter_dof)};
  };
  const auto beyond = [&](Index from, Index to) {
    return part(whitened.chi_square(from) - whitened.chi_square(to), to - from);
  };
  const auto measured = [](const VectorXd& solution, const MatrixXd& cov, Index i, double factor) {
    return Measured{factor * solution[i], std::abs(factor) * std::sqrt(cov(i, i))};
  };
  out.all = part(whitened.chi_square(0), n);
  out.offset = beyond(0, kOffset);
  out.tilt = beyond(kOffset, kTilt);
  const VectorXd plane = whitened.solution(kTilt);
  const MatrixXd plane_cov = whitened.covariance(kTilt);
  out.offset_um = measured(plane, plane_cov, 0, 1);
  out.tilt_x = measured(plane, plane_cov, 1, 1e3 / out.half_mm.x());
  out.tilt_y = measured(plane, plane_cov, 2, 1e3 / out.half_mm.y());
  const bool has_bow = n >= kLeastForCurves && whitened.is_determined(kBow);
  if (has_bow) {
    const VectorXd bow = whitened.solution(kBow);
    const MatrixXd bow_cov = whitened.covariance(kBow);
    out.bow = beyond(kTilt, kBow);
    out.bow_x_um = measured(bow, bow_cov, 3, 1);
    out.twist_um = measured(bow, bow_cov, 4, 1);
    out.bow_y_um = measured(bow, bow_cov, 5, 1);
  }
  const Index n_fitted = has_bow ? kBow : kTilt;
  if (n > n_fitted) out.rest = part(whitened.chi_square(n_fitted), n - n_fitted);
  return out;
}

}  // namespace panelcal
