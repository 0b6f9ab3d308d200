// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "calib/base/statistics/distributions.h"
#include "surface/fit/bending_likelihood.h"
#include "surface/fit/even_part.h"
#include "surface/fit/grid_surface.h"
#include <Eigen/Cholesky>
#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using internal::Bending;
using internal::BendingLikelihood;
using internal::Readings;

constexpr std::array kPlaneKernels = {BendingKernel::None};
constexpr std::array kThinPlateKernels = {BendingKernel::ThinPlate};
constexpr std::array kProcessKernels = {
    BendingKernel::Matern32, BendingKernel::Matern52, BendingKernel::Gaussian};

/// Places of one matrix product.
constexpr Index kAtOnce = 256;
/// A probe whose left-out weight is less, by what it would be alone, is predicted by nothing.
constexpr double kUnforetold = 1e-10;
/// Rounding error of a variance, relative to the terms whose difference it is.
constexpr double kVarianceRounding = 1e-15;

std::optional<Diagnostic> point_problem(const ProbePoint& point) {
  const double sigma_mm = point.measured.sigma.in_mm();
  if (point.place.in_mm().allFinite() && std::isfinite(point.measured.height.in_mm()) &&
      std::isfinite(sigma_mm) && std::isfinite(1 / sigma_mm) && sigma_mm > 0) {
    return std::nullopt;
  }
  return Diagnostic{Code::GridInvalid,
                    point.from,
                    fmt::format("probe {} has a number that is not finite, or a sigma of 0 or less",
                                quoted(point.name)),
                    "finite numbers and a sigma above 0"};
}

Bending likeliest(const BendingLikelihood& likelihood, SurfaceModel model) {
  if (model == SurfaceModel::Plane) return likelihood.best_of(kPlaneKernels);
  if (model == SurfaceModel::ThinPlate) return likelihood.best_of(kThinPlateKernels);
  return likelihood.best_of(kProcessKernels);
}

/// Grid models have neither trend nor noise factor.
constexpr SurfaceShape kGridShape = {BendingKernel::None, Length(), 0, 1, 0};

SurfaceShape shape_of(const Bending& bending, const Readings& readings, Index n_trend) {
  const bool bends = bending.kernel != BendingKernel::None;
  return {bending.kernel,
          mm(bends ? bending.length * readings.scale_mm : 0),
          bending.strength_mm2,
          bending.noise_factor,
          static_cast<int>(n_trend)};
}

Bending bending_of(const SurfaceShape& shape, const Readings& readings) {
  Bending bending;
  bending.kernel = shape.kernel;
  if (shape.kernel != BendingKernel::None) {
    bending.length = shape.length.in_mm() / readings.scale_mm;
  }
  bending.strength_mm2 = shape.strength_mm2;
  bending.noise_factor = shape.noise_factor;
  return bending;
}

/// Bow and twist only of a Gaussian process, and if the probes tell.
std::optional<BendingLikelihood> likelihood_of(const Readings& readings, SurfaceModel model) {
  std::optional<BendingLikelihood> out;
  const bool may_bow = model == SurfaceModel::GaussianProcess &&
                       readings.heights_mm.size() >= static_cast<Index>(kLeastForBow);
  if (may_bow) out = BendingLikelihood::of(readings, kBowTrend);
  if (!out) out = BendingLikelihood::of(readings, kPlaneTrend);
  return out;
}

Diagnostic undetermined(std::span<const ProbePoint> points) {
  return {Code::GridInvalid,
          points.front().from,
          fmt::format("{} probes coincide or are collinear", points.size()),
          "probes all over the surface"};
}

std::string_view name_of(BendingKernel kernel) {
  switch (kernel) {
    case BendingKernel::None:
      return "none";
    case BendingKernel::ThinPlate:
      return "thin plate";
    case BendingKernel::Matern32:
      return "Matern 3/2";
    case BendingKernel::Matern52:
      return "Matern 5/2";
    case BendingKernel::Gaussian:
      return "Gaussian";
  }
  return "";
}

}  // namespace

/// In units of internal::Readings; lengths pass through mm, so that a shape that was written down
/// gives the same surface. With F^T F = P = W Q2 (1 + s B)^-1 Q2^T W and G the trend by the
/// heights, in c(p) the covariances of a place with the probes and t(p) its trend,
///
///   height = t beta + s c^T P y             beta = G (y - s C P y)
///   variance / k^2 = s (c(p, p) - 2 c^T g + g^T C g) + |R^-T t|^2 - s^2 |F (c - C g)|^2
///   with g = G^T t
///
/// The bending is first predicted from the trend's own probes, then from the contrasts, which know
/// nothing of the trend.
struct SurfaceFit::State {
  SurfaceModel model = SurfaceModel::Plane;
  SurfaceShape shape;
  Bending bending;  ///< the shape's
  Readings readings;
  VectorXd trend_mm;       ///< beta
  VectorXd weights;        ///< s P y
  MatrixXd onto;           ///< [s F; G], times c
  MatrixXd root_of_trend;  ///< s F C G^T
  MatrixXd trend_bending;  ///< G C G^T
  MatrixXd trend_root;     ///< R^-1
  std::vector<LeftOutProbe> left_out;
  std::optional<internal::GridSurface> grid;  ///< of a grid model, which has none of the others

  State(SurfaceModel of_model,
        const SurfaceShape& of_shape,
        Noise noise,
        Readings of,
        const BendingLikelihood& likelihood);
  State(SurfaceModel of_model, internal::GridSurface of, std::span<const ProbePoint> points)
      : model(of_model),
        shape(kGridShape),
        readings(Readings::of(points)),
        left_out(of.left_out(points)),
        grid(std::move(of)) {}
  double degrees_of_freedom() const {
    if (grid) return std::numeric_limits<double>::infinity();
    return static_cast<double>(readings.places.cols() - trend_root.rows()) +
           BendingLikelihood::kPriorReadings;
  }
  void leave_out(const MatrixXd& root, const VectorXd& residual_weights);
  Eigen::Vector2d reduced(const Position<frame::Nominal>& place) const {
    return (place.in_mm() - readings.center_mm) / readings.scale_mm;
  }
  /// c(p)
  VectorXd covariances(const Eigen::Vector2d& p) const;
  /// Covariances with the probes for strength 1, and trends, a column for each place.
  std::pair<MatrixXd, MatrixXd> relations(std::span<const Position<frame::Nominal>> places) const;
  void append(std::span<const Position<frame::Nominal>> places,
              std::vector<HeightEstimate>& out) const;
  MatrixXd covariance_mm2(std::span<const Position<frame::Nominal>> places) const;
};

SurfaceFit::State::State(SurfaceModel of_model,
                         const SurfaceShape& of_shape,
                         Noise noise,
                         Readings of,
                         const BendingLikelihood& likelihood)
    : model(of_model),
      shape(of_shape),
      bending(bending_of(of_shape, of)),
      readings(std::move(of)),
      trend_root(likelihood.trend_root()) {
  const MatrixXd covariance = likelihood.covariance(bending.kernel, bending.length);
  const bool bends = bending.strength_mm2 > 0;
  MatrixXd root =
      likelihood.contrasts().transpose() * readings.sigmas_mm.cwiseInverse().asDiagonal();
  if (bends) {
    MatrixXd noise_and_bending = bending.strength_mm2 * likelihood.contrast_covariance(covariance);
    noise_and_bending.diagonal().array() += 1;
    // In place: of many probes each matrix is large.
    const Eigen::LLT<Eigen::Ref<MatrixXd>> decomposed(noise_and_bending);
    decomposed.matrixL().solveInPlace(root);
  }
  const MatrixXd& lift = likelihood.trend_of_heights();
  const VectorXd& y = readings.heights_mm;
  const VectorXd residual_weights = root.transpose() * (root * y);
  if (noise == Noise::Learned) {
    bending.noise_factor = shape.noise_factor = likelihood.noise_factor(y.dot(residual_weights));
  }
  weights = bending.strength_mm2 * residual_weights;
  trend_mm = lift * (y - covariance * weights);
  const MatrixXd bending_of_trend = covariance * lift.transpose();
  trend_bending = lift * bending_of_trend;
  leave_out(root, residual_weights);
  // The trend alone predicts a surface that does not bend.
  if (bends) {
    root *= bending.strength_mm2;
  } else {
    root.resize(0, y.size());
  }
  root_of_trend = root * bending_of_trend;
  onto.resize(root.rows() + lift.rows(), y.size());
  onto << root, lift;
}

/// A probe left out is missed by [P y]_i / P_ii, of variance k^2 / P_ii; k is then that of the
/// others.
void SurfaceFit::State::leave_out(const MatrixXd& root, const VectorXd& residual_weights) {
  const double dof = degrees_of_freedom();
  const double noise = bending.noise_factor;
  for (Index i = 0; i < residual_weights.size(); ++i) {
    LeftOutProbe out;
    const double precision = root.col(i).squaredNorm();
    const double alone = 1 / (readings.sigmas_mm[i] * readings.sigmas_mm[i]);
    if (precision > kUnforetold * alone) {
      const Length deviation = mm(residual_weights[i] / precision);
      out.deviation = deviation;
      out.sigma = mm(noise / std::sqrt(precision));
      const double t = deviation / out.sigma;
      const double rest = dof - t * t;
      out.chance = rest > 0 ? variance_ratio_exceedance(t * t * (dof - 1) / rest, 1, dof - 1) : 0;
    }
    left_out.push_back(out);
  }
}

VectorXd SurfaceFit::State::covariances(const Eigen::Vector2d& p) const {
  VectorXd out(readings.places.cols());
  for (Index i = 0; i < out.size(); ++i) {
    out[i] =
        bending_covariance(bending.kernel, (readings.places.col(i) - p).norm() / bending.length);
  }
  return out;
}

std::pair<MatrixXd, MatrixXd> SurfaceFit::State::relations(
    std::span<const Position<frame::Nominal>> places) const {
  const auto n_places = static_cast<Index>(places.size());
  MatrixXd c(readings.places.cols(), n_places);
  MatrixXd t(trend_root.rows(), n_places);
  for (Index j = 0; j < n_places; ++j) {
    const Eigen::Vector2d p = reduced(places[static_cast<std::size_t>(j)]);
    c.col(j) = covariances(p);
    t.col(j) = internal::trend_at(p, t.rows());
  }
  return {std::move(c), std::move(t)};
}

void SurfaceFit::State::append(std::span<const Position<frame::Nominal>> places,
                               std::vector<HeightEstimate>& out) const {
  if (grid) {
    for (const Position<frame::Nominal>& place : places) out.push_back(grid->at(place.in_mm()));
    return;
  }
  const auto [c, t] = relations(places);
  const Index n_places = c.cols();
  const Index n_trend = t.rows();
  const MatrixXd by_contrasts = onto * c;
  const Index n_contrasts = onto.rows() - n_trend;
  const MatrixXd predicted = by_contrasts.topRows(n_contrasts) - root_of_trend * t;
  const MatrixXd missed = trend_bending * t - 2 * by_contrasts.bottomRows(n_trend);
  const MatrixXd trend = trend_root.transpose() * t;
  const double itself = bending_covariance(bending.kernel, 0);
  for (Index j = 0; j < n_places; ++j) {
    const double height_mm = readings.mean_mm + t.col(j).dot(trend_mm) + c.col(j).dot(weights);
    const double bent = bending.strength_mm2 * (itself + t.col(j).dot(missed.col(j)));
    const double tilted = trend.col(j).squaredNorm();
    const double known = predicted.col(j).squaredNorm();
    // Far away they cancel, and what is left of them is rounding. In this order what is no number
    // stays none: nothing is known there, rather than all.
    const double least = kVarianceRounding * (std::abs(bent) + tilted + known);
    const double variance = std::max(bent + tilted - known, least);
    out.push_back({mm(height_mm), mm(bending.noise_factor * std::sqrt(variance))});
  }
}

MatrixXd SurfaceFit::State::covariance_mm2(std::span<const Position<frame::Nominal>> places) const {
  const auto [c, t] = relations(places);
  const Index n_places = c.cols();
  MatrixXd bent(n_places, n_places);
  for (Index j = 0; j < n_places; ++j) {
    for (Index i = 0; i <= j; ++i) {
      const Eigen::Vector2d apart_mm =
          (places[static_cast<std::size_t>(i)] - places[static_cast<std::size_t>(j)]).in_mm();
      const double r = apart_mm.norm() / readings.scale_mm / bending.length;
      bent(i, j) = bent(j, i) = bending_covariance(bending.kernel, r);
    }
  }
  const MatrixXd by_contrasts = onto * c;
  const MatrixXd predicted = by_contrasts.topRows(onto.rows() - t.rows()) - root_of_trend * t;
  const MatrixXd crossed = t.transpose() * by_contrasts.bottomRows(t.rows());
  const MatrixXd trend = trend_root.transpose() * t;
  bent += t.transpose() * trend_bending * t - crossed - crossed.transpose();
  bent =
      bending.strength_mm2 * bent + trend.transpose() * trend - predicted.transpose() * predicted;
  // Products round to either side of the diagonal differently.
  const double noise = bending.noise_factor;
  return 0.5 * noise * noise * (bent + bent.transpose());
}

std::string_view name_of(SurfaceModel model) {
  switch (model) {
    case SurfaceModel::Plane:
      return "plane";
    case SurfaceModel::ThinPlate:
      return "thin plate";
    case SurfaceModel::GaussianProcess:
      return "Gaussian process";
    case SurfaceModel::Bilinear:
      return "bilinear";
    case SurfaceModel::MonotoneBicubic:
      return "monotone bicubic";
  }
  return "";
}

SurfaceModel SurfaceFit::model() const {
  return state_->model;
}

HeightEstimate SurfaceFit::at(const Position<frame::Nominal>& place) const {
  std::vector<HeightEstimate> out;
  state_->append({&place, 1}, out);
  return out.front();
}

std::vector<HeightEstimate> SurfaceFit::at(std::span<const Position<frame::Nominal>> places) const {
  std::vector<HeightEstimate> out;
  out.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); i += kAtOnce) {
    state_->append(places.subspan(i, std::min<std::size_t>(kAtOnce, places.size() - i)), out);
  }
  return out;
}

std::vector<double> SurfaceFit::heights_mm(std::span<const Position<frame::Nominal>> places) const {
  std::vector<double> out;
  out.reserve(places.size());
  for (const Position<frame::Nominal>& place : places) {
    if (state_->grid) {
      out.push_back(state_->grid->at(place.in_mm()).height.in_mm());
      continue;
    }
    const Eigen::Vector2d p = state_->reduced(place);
    const internal::Trend trend = internal::trend_at(p, n_trend());
    out.push_back(state_->readings.mean_mm + trend.dot(state_->trend_mm) +
                  state_->covariances(p).dot(state_->weights));
  }
  return out;
}

Eigen::MatrixXd SurfaceFit::covariance_mm2(std::span<const Position<frame::Nominal>> places) const {
  return state_->covariance_mm2(places);
}

const SurfaceShape& SurfaceFit::shape() const {
  return state_->shape;
}

double SurfaceFit::noise_factor() const {
  return state_->shape.noise_factor;
}

double SurfaceFit::degrees_of_freedom() const {
  return state_->degrees_of_freedom();
}

Length SurfaceFit::amplitude() const {
  if (model() != SurfaceModel::GaussianProcess) return mm(0);
  return mm(noise_factor() * std::sqrt(shape().strength_mm2));
}

Length SurfaceFit::length() const {
  if (!(amplitude() > mm(0))) return mm(0);
  return shape().length;
}

int SurfaceFit::n_trend() const {
  return shape().n_trend;
}

std::span<const LeftOutProbe> SurfaceFit::left_out() const {
  return state_->left_out;
}

std::optional<double> SurfaceFit::left_out_rms() const {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < state_->left_out.size(); ++i) {
    if (!state_->left_out[i].deviation) continue;
    const double sigma_mm = state_->readings.sigmas_mm[static_cast<Index>(i)];
    const double deviation = state_->left_out[i].deviation->in_mm() / sigma_mm;
    sum += deviation * deviation;
    ++n;
  }
  if (n == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(n));
}

std::string SurfaceFit::summary() const {
  const std::string noise =
      fmt::format("noise {:.2f} times the probes' stated sigma", noise_factor());
  const std::string trend = n_trend() == kBowTrend ? "bow and twist" : "plane";
  if (model() == SurfaceModel::Plane) return fmt::format("plane; {}", noise);
  if (model() == SurfaceModel::ThinPlate) return fmt::format("thin plate; {}", noise);
  if (state_->grid) {
    return fmt::format("{} through every probe; in the middle of cells it misses {:.4f} mm usually",
                       panelcal::name_of(model()),
                       state_->grid->usually_missed().in_mm());
  }
  if (!(amplitude() > mm(0)))
    return fmt::format("{} without any further bending; {}", trend, noise);
  return fmt::format("{} and a {} bending of {:.3f} mm over {:.0f} mm; {}",
                     trend,
                     name_of(shape().kernel),
                     amplitude().in_mm(),
                     length().in_mm(),
                     noise);
}

Expected<void> check_probes(std::span<const ProbePoint> points, SurfaceModel model) {
  for (const ProbePoint& point : points) {
    if (auto problem = point_problem(point)) return failure(*std::move(problem));
  }
  const std::size_t most = is_of_grid(model) ? kMostGridProbes : kMostBentProbes;
  if (points.size() >= kPlaneTrend && points.size() <= most) return {};
  return failure({Code::GridInvalid,
                  points.empty() ? Place() : points.front().from,
                  fmt::format("{} probes", points.size()),
                  fmt::format("{} to {} for a {}{}",
                              kPlaneTrend,
                              most,
                              is_of_grid(model) ? "grid" : "surface",
                              is_of_grid(model) || points.size() <= most
                                  ? ""
                                  : ": fewer, or a complete grid and a grid model")});
}

Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points, SurfaceModel model) {
  PANELCAL_CHECK(check_probes(points, model));
  if (is_of_grid(model)) {
    PANELCAL_TRY(internal::GridSurface grid,
                 internal::GridSurface::of(points, model == SurfaceModel::MonotoneBicubic));
    return SurfaceFit(std::make_shared<const SurfaceFit::State>(model, std::move(grid), points));
  }
  if (points.size() > kMostProbes) {
    const auto part = internal::even_part(points, kMostProbes);
    PANELCAL_TRY(const SurfaceFit of_part, fit_surface(part, model));
    return SurfaceFit::solved(points, model, of_part.shape(), SurfaceFit::Noise::Learned);
  }
  Readings readings = Readings::of(points);
  const std::optional<BendingLikelihood> likelihood = likelihood_of(readings, model);
  if (!likelihood) return failure(undetermined(points));
  const SurfaceShape shape =
      shape_of(likeliest(*likelihood, model), readings, likelihood->trend_root().rows());
  return SurfaceFit(std::make_shared<const SurfaceFit::State>(
      model, shape, SurfaceFit::Noise::Given, std::move(readings), *likelihood));
}

Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points,
                                 SurfaceModel model,
                                 const SurfaceShape& shape) {
  PANELCAL_CHECK(shape.validate(model));
  // Of a grid model the probes say all.
  if (is_of_grid(model)) return fit_surface(points, model);
  PANELCAL_CHECK(check_probes(points, model));
  return SurfaceFit::solved(points, model, shape, SurfaceFit::Noise::Given);
}

Expected<SurfaceFit> SurfaceFit::solved(std::span<const ProbePoint> points,
                                        SurfaceModel model,
                                        const SurfaceShape& shape,
                                        Noise noise) {
  Readings readings = Readings::of(points);
  const auto likelihood = BendingLikelihood::of(readings, shape.n_trend);
  if (!likelihood) return failure(undetermined(points));
  return SurfaceFit(
      std::make_shared<const State>(model, shape, noise, std::move(readings), *likelihood));
}

}  // namespace panelcal
