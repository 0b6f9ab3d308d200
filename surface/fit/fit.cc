// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "calib/base/statistics/distributions.h"
#include "surface/fit/bending/bending_average.h"
#include "surface/fit/bending/bending_likelihood.h"
#include "surface/fit/bending/solved_bending.h"
#include "surface/fit/even_part.h"
#include "surface/fit/grid_surface.h"
#include "surface/fit/probe_readings.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using internal::Bending;
using internal::BendingLikelihood;
using internal::BendingShare;
using internal::LeftOutReading;
using internal::Readings;
using internal::RelatedPlaces;
using internal::SolvedBending;
using Noise = SolvedBending::Noise;

/// Places of one matrix product.
constexpr Index kAtOnce = 256;
/// Of a matrix that stays in the cache, and that the allocator keeps.
constexpr Index kCovariancesAtOnce = 12'000;

/// A plane has no room for misses beyond chance: the noise factor is that of an assumed scatter.
Bending flat(const BendingLikelihood& likelihood, SurfaceModel model) {
  constexpr std::array kNone = {BendingKernel::None};
  Bending out = likelihood.best_of(kNone);
  if (!likelihood.is_trend_enough()) {
    out.noise_factor = std::max(out.noise_factor, likelihood.noise_factor_of_trend());
  }
  // Other models of three places are a plane with their own name.
  if (model == SurfaceModel::ThinPlate) out.kernel = BendingKernel::ThinPlate;
  if (model == SurfaceModel::GaussianProcess) out.kernel = BendingKernel::Matern12;
  return out;
}

std::vector<BendingShare> explained(const BendingLikelihood& likelihood, SurfaceModel model) {
  constexpr std::array kThinPlate = {BendingKernel::ThinPlate};
  if (model == SurfaceModel::Plane || !likelihood.has_seen_bending()) {
    return {{flat(likelihood, model)}};
  }
  if (model == SurfaceModel::ThinPlate) return {{likelihood.best_of(kThinPlate)}};
  return internal::bending_average(likelihood);
}

/// Grid models have neither trend nor noise factor.
constexpr SurfaceShape kGridShape = {BendingKernel::None, Length(), 0, 1, 0, Length()};

/// Bow and twist only of a Gaussian process, and if the probes tell.
std::optional<BendingLikelihood> likelihood_of(const Readings& readings, SurfaceModel model) {
  std::optional<BendingLikelihood> out;
  const bool may_bow = model == SurfaceModel::GaussianProcess &&
                       readings.heights_mm.size() >= static_cast<Index>(kLeastForBow);
  if (may_bow) out = BendingLikelihood::of(readings, kBowTrend);
  if (out && out->n_places() < static_cast<Index>(kLeastForBow)) out.reset();
  if (!out) out = BendingLikelihood::of(readings, kPlaneTrend);
  return out;
}

/// Chance that |t| of variance 1 is larger, whose scale this number of degrees of freedom tells.
double chance_of_deviation(double t, double dof) {
  const double by_scale = dof > 3 && std::isfinite(dof) ? dof / (dof - 2) : 1;
  return variance_ratio_exceedance(t * t * by_scale, 1, dof);
}

Diagnostic undetermined(std::span<const ProbePoint> points) {
  return {Code::GridInvalid,
          points.front().from,
          fmt::format("{} probes coincide or are collinear", points.size()),
          "probes all over the surface"};
}

Diagnostic unexplained(std::span<const ProbePoint> points) {
  return {Code::GridInvalid,
          points.front().from,
          fmt::format("no bending explains the heights of {} probes", points.size()),
          "heights that one board can have, and sigmas of their size"};
}

std::string_view name_of(BendingKernel kernel) {
  switch (kernel) {
    case BendingKernel::None:
      return "none";
    case BendingKernel::Matern12:
      return "Matern 1/2";
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

/// In units of internal::Readings; lengths pass through mm, so that shapes that were written down
/// give the same surface.
struct SurfaceFit::State {
  SurfaceModel model = SurfaceModel::Plane;
  std::vector<ShapeShare> shapes;  ///< heaviest first
  Readings readings;
  std::vector<SolvedBending> solved;   ///< of each shape
  std::vector<std::size_t> by_length;  ///< indices of these, longest first
  std::vector<LeftOutProbe> left_out;
  std::vector<PossibleBend> bends;
  bool has_seen_bending = true;
  std::optional<internal::GridSurface> grid;  ///< of a grid model, which solves nothing

  State(SurfaceModel of_model,
        std::span<const ShapeShare> of_shapes,
        SolvedBending::Noise noise,
        Readings of,
        const BendingLikelihood& likelihood);
  State(SurfaceModel of_model, internal::GridSurface of, std::span<const ProbePoint> points)
      : model(of_model),
        shapes({{kGridShape, 1}}),
        readings(internal::readings_of(points)),
        left_out(of.left_out(points)),
        grid(std::move(of)) {}
  const SurfaceShape& heaviest() const { return shapes.front().shape; }
  double degrees_of_freedom() const {
    const auto n_contrasts = static_cast<double>(readings.places.cols() - heaviest().n_trend);
    if (heaviest().noise_factor != 1) return n_contrasts + BendingLikelihood::kPriorReadings;
    // Of stated scatter all is known, but of a bending only what the probes show.
    return is_of_grid(model) || model == SurfaceModel::Plane
               ? std::numeric_limits<double>::infinity()
               : std::max(1.0, n_contrasts);
  }
  LeftOutProbe left_out_of(std::size_t i) const;
  double chance_of(const LeftOutReading& reading) const;
  Eigen::Matrix2Xd reduced(std::span<const Position<frame::Nominal>> places) const;
  RelatedPlaces related(const Eigen::Matrix2Xd& reduced) const {
    return {readings, reduced, heaviest().n_trend};
  }
  void append(std::span<const Position<frame::Nominal>> places,
              std::vector<HeightEstimate>& out) const;
  MatrixXd covariance_mm2(std::span<const Position<frame::Nominal>> places) const;
};

SurfaceFit::State::State(SurfaceModel of_model,
                         std::span<const ShapeShare> of_shapes,
                         SolvedBending::Noise noise,
                         Readings of,
                         const BendingLikelihood& likelihood)
    : model(of_model),
      shapes(of_shapes.begin(), of_shapes.end()),
      readings(std::move(of)),
      has_seen_bending(likelihood.has_seen_bending()) {
  for (ShapeShare& share : shapes) {
    solved.emplace_back(internal::bending_of(share.shape, readings), readings, likelihood, noise);
    share.shape.noise_factor = solved.back().noise_factor();
    by_length.push_back(by_length.size());
  }
  std::ranges::stable_sort(
      by_length, std::greater(), [&](std::size_t k) { return solved[k].length(); });
  for (std::size_t i = 0; i < static_cast<std::size_t>(readings.heights_mm.size()); ++i) {
    left_out.push_back(left_out_of(i));
  }
}

/// k is then that of the others.
double SurfaceFit::State::chance_of(const LeftOutReading& reading) const {
  const double t = reading.deviation_mm / reading.sigma_mm;
  const double dof = degrees_of_freedom();
  if (heaviest().noise_factor == 1) return chance_of_deviation(t, dof);
  const double rest = dof - t * t;
  return rest > 0 ? variance_ratio_exceedance(t * t * (dof - 1) / rest, 1, dof - 1) : 0;
}

/// Without the probe each shape has the weight that the others give it: what it says of the probe
/// is taken out of its likelihood.
LeftOutProbe SurfaceFit::State::left_out_of(std::size_t i) const {
  LeftOutProbe out;
  std::vector<double> logs;
  for (std::size_t k = 0; k < solved.size(); ++k) {
    const LeftOutReading& reading = solved[k].left_out()[i];
    // No shape predicts a probe that the trend needs.
    if (!reading.is_predicted) return out;
    const double t = reading.deviation_mm / reading.sigma_mm;
    logs.push_back(std::log(shapes[k].weight) +
                   0.5 * internal::kEvidenceShare * (t * t + 2 * std::log(reading.sigma_mm)));
  }
  const double most = *std::ranges::max_element(logs);
  double sum = 0, mean_mm = 0, second_mm2 = 0;
  out.chance = 0;
  for (std::size_t k = 0; k < solved.size(); ++k) {
    const LeftOutReading& reading = solved[k].left_out()[i];
    const double weight = std::exp(logs[k] - most);
    sum += weight;
    mean_mm += weight * reading.deviation_mm;
    second_mm2 += weight * (reading.deviation_mm * reading.deviation_mm +
                            reading.sigma_mm * reading.sigma_mm);
    out.chance += weight * chance_of(reading);
  }
  mean_mm /= sum;
  out.deviation = mm(mean_mm);
  out.sigma = mm(std::sqrt(second_mm2 / sum - mean_mm * mean_mm));
  out.chance /= sum;
  return out;
}

Eigen::Matrix2Xd SurfaceFit::State::reduced(
    std::span<const Position<frame::Nominal>> places) const {
  Eigen::Matrix2Xd out(2, static_cast<Index>(places.size()));
  for (Index j = 0; j < out.cols(); ++j) {
    const Eigen::Vector2d& p_mm = places[static_cast<std::size_t>(j)].in_mm();
    out.col(j) = (p_mm - readings.center_mm) / readings.scale_mm;
  }
  return out;
}

/// Mean and variance of the shapes' heights by weight, what they disagree in included.
void SurfaceFit::State::append(std::span<const Position<frame::Nominal>> places,
                               std::vector<HeightEstimate>& out) const {
  if (grid) {
    for (const Position<frame::Nominal>& place : places) out.push_back(grid->at(place.in_mm()));
    return;
  }
  RelatedPlaces at_places = related(reduced(places));
  // About the first shape's heights, so that no digits get lost.
  VectorXd about_mm, mean_mm, variances_mm2;
  for (const std::size_t k : by_length) {
    const auto [shape_mm, variance_mm2] = solved[k].at(at_places);
    const double weight = shapes[k].weight;
    if (about_mm.size() == 0) {
      about_mm = shape_mm;
      mean_mm = VectorXd::Zero(shape_mm.size());
      variances_mm2 = weight * variance_mm2;
      continue;
    }
    const VectorXd apart_mm = shape_mm - about_mm;
    mean_mm += weight * apart_mm;
    variances_mm2 += weight * (variance_mm2 + apart_mm.cwiseAbs2());
  }
  variances_mm2 -= mean_mm.cwiseAbs2();
  const VectorXd heights_mm = about_mm + mean_mm;
  const double unresolved_mm = heaviest().unresolved.in_mm();
  variances_mm2.array() += unresolved_mm * unresolved_mm;
  for (const PossibleBend& bend : bends) variances_mm2 += bend.errors_mm(places).cwiseAbs2();
  for (Index j = 0; j < heights_mm.size(); ++j) {
    out.push_back({mm(readings.mean_mm + heights_mm[j]), mm(std::sqrt(variances_mm2[j]))});
  }
}

MatrixXd SurfaceFit::State::covariance_mm2(std::span<const Position<frame::Nominal>> places) const {
  const Eigen::Matrix2Xd at = reduced(places);
  RelatedPlaces at_places = related(at);
  const VectorXd about_mm = solved[by_length.front()].heights_mm(at_places);
  VectorXd mean_mm = VectorXd::Zero(about_mm.size());
  MatrixXd out = MatrixXd::Zero(about_mm.size(), about_mm.size());
  for (const std::size_t k : by_length) {
    const VectorXd apart_mm = solved[k].heights_mm(at_places) - about_mm;
    mean_mm += shapes[k].weight * apart_mm;
    out += shapes[k].weight *
           (solved[k].covariance_mm2(at_places, at) + apart_mm * apart_mm.transpose());
  }
  out -= mean_mm * mean_mm.transpose();
  const double unresolved_mm = heaviest().unresolved.in_mm();
  out.diagonal().array() += unresolved_mm * unresolved_mm;
  for (const PossibleBend& bend : bends) {
    const VectorXd errors_mm = bend.errors_mm(places);
    out += errors_mm * errors_mm.transpose();
  }
  return out;
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
  if (state_->grid) {
    for (const auto& place : places) out.push_back(state_->grid->at(place.in_mm()).height.in_mm());
    return out;
  }
  const auto n_at_once = static_cast<std::size_t>(
      std::clamp<Index>(kCovariancesAtOnce / state_->readings.places.cols(), 16, kAtOnce));
  for (std::size_t i = 0; i < places.size(); i += n_at_once) {
    const auto some = places.subspan(i, std::min(n_at_once, places.size() - i));
    RelatedPlaces at_places = state_->related(state_->reduced(some));
    VectorXd sum_mm = VectorXd::Zero(static_cast<Index>(some.size()));
    for (const std::size_t k : state_->by_length) {
      sum_mm += state_->shapes[k].weight * state_->solved[k].heights_mm(at_places);
    }
    for (const double height_mm : sum_mm) out.push_back(state_->readings.mean_mm + height_mm);
  }
  return out;
}

Eigen::MatrixXd SurfaceFit::covariance_mm2(std::span<const Position<frame::Nominal>> places) const {
  return state_->covariance_mm2(places);
}

SurfaceFit SurfaceFit::with(std::vector<PossibleBend> bends) const {
  auto state = std::make_shared<State>(*state_);
  state->bends = std::move(bends);
  return SurfaceFit(std::move(state));
}

std::span<const PossibleBend> SurfaceFit::possible_bends() const {
  return state_->bends;
}

const SurfaceShape& SurfaceFit::shape() const {
  return state_->heaviest();
}

std::span<const ShapeShare> SurfaceFit::shapes() const {
  return state_->shapes;
}

double SurfaceFit::noise_factor() const {
  if (state_->shapes.size() == 1) return shape().noise_factor;
  double sum = 0;
  for (const auto& [shape, weight] : state_->shapes) {
    sum += weight * shape.noise_factor * shape.noise_factor;
  }
  // Stated scatter stays what it is, whatever the weights round to.
  return shape().noise_factor == 1 ? 1 : std::sqrt(sum);
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

bool SurfaceFit::has_seen_bending() const {
  return state_->has_seen_bending;
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
  if (state_->grid) {
    return fmt::format("{} through every probe; in the middle of cells it misses {:.4f} mm usually",
                       panelcal::name_of(model()),
                       state_->grid->usually_missed().in_mm());
  }
  std::string noise = "the probes scatter as stated";
  if (shape().unresolved > mm(0) && model() != SurfaceModel::Plane) {
    noise = fmt::format("{:.3f} mm in every sigma, by which a probe may be wild",
                        shape().unresolved.in_mm());
  } else if (shape().unresolved > mm(0)) {
    const double rms_mm = std::sqrt(state_->readings.sigmas_mm.array().square().mean());
    noise = fmt::format(
        "it misses the probes by {:.2f} times their sigma: {:.3f} mm of bending that "
        "it does not follow",
        std::hypot(1, shape().unresolved.in_mm() / rms_mm),
        shape().unresolved.in_mm());
  } else if (noise_factor() != 1) {
    noise = fmt::format("noise {:.2f} times the sigma of the probes", noise_factor());
  }
  if (model() == SurfaceModel::Plane) return fmt::format("plane; {}", noise);
  if (model() == SurfaceModel::ThinPlate) return fmt::format("thin plate; {}", noise);
  const std::string trend = n_trend() == kBowTrend ? "bow and twist" : "plane";
  if (!(amplitude() > mm(0))) {
    return fmt::format("{} without any further bending; {}", trend, noise);
  }
  const std::size_t n_others = state_->shapes.size() - 1;
  return fmt::format("{} and a {} bending of {:.3f} mm over {:.0f} mm{}; {}",
                     trend,
                     name_of(shape().kernel),
                     amplitude().in_mm(),
                     length().in_mm(),
                     n_others == 0 ? std::string()
                                   : fmt::format(" ({:.0f} %, averaged with {} other{})",
                                                 100 * state_->shapes.front().weight,
                                                 n_others,
                                                 n_others == 1 ? "" : "s"),
                     noise);
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
    const ShapeShare heaviest = {of_part.shape(), 1};
    return SurfaceFit::solved(points, model, {&heaviest, 1}, true);
  }
  Readings readings = internal::readings_of(points);
  const std::optional<BendingLikelihood> likelihood = likelihood_of(readings, model);
  if (!likelihood) return failure(undetermined(points));
  std::vector<ShapeShare> shapes;
  for (const BendingShare& share : explained(*likelihood, model)) {
    if (!std::isfinite(share.bending.minus_2_log_likelihood)) return failure(unexplained(points));
    const Index n_trend = likelihood->trend_root().rows();
    shapes.push_back({internal::shape_of(share.bending, readings, n_trend), share.weight});
  }
  if (shapes.empty()) return failure(unexplained(points));
  return SurfaceFit(std::make_shared<const SurfaceFit::State>(
      model, shapes, Noise::Given, std::move(readings), *likelihood));
}

Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points,
                                 SurfaceModel model,
                                 const SurfaceShape& shape) {
  const ShapeShare whole = {shape, 1};
  return fit_surface(points, model, {&whole, 1});
}

Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points,
                                 SurfaceModel model,
                                 std::span<const ShapeShare> shapes) {
  PANELCAL_CHECK(check_shares(shapes, model));
  // Of a grid model the probes say all.
  if (is_of_grid(model)) return fit_surface(points, model);
  PANELCAL_CHECK(check_probes(points, model));
  return SurfaceFit::solved(points, model, shapes, false);
}

Expected<SurfaceFit> SurfaceFit::solved(std::span<const ProbePoint> points,
                                        SurfaceModel model,
                                        std::span<const ShapeShare> shapes,
                                        bool learns_noise) {
  Readings readings = internal::readings_of(points);
  const auto likelihood = BendingLikelihood::of(readings, shapes.front().shape.n_trend);
  if (!likelihood) return failure(undetermined(points));
  return SurfaceFit(std::make_shared<const State>(model,
                                                  shapes,
                                                  learns_noise ? Noise::Learned : Noise::Given,
                                                  std::move(readings),
                                                  *likelihood));
}

}  // namespace panelcal
