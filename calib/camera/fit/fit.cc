// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/linear_algebra.h"
#include "calib/camera/fit/problem.h"
#include "calib/camera/fit/start.h"
#include "calib/panel/model_choice.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::CameraInformation;
using internal::CameraProblem;
using internal::CameraState;

/// Part of a parameter's information that is left when poses, dots and stiffer parameters are free;
/// less is rounding.
constexpr double kNoCameraResidual = 1e-10;
/// Chi square by which a nested fit may be larger because the solver stops early, and the part of
/// it that is rounding. Neither is evidence: one degree of freedom is worth 1.
constexpr double kSolverStops = 1e-3;
constexpr double kCameraRounding = 1e-6;
/// Chance by which a form that suffices is rejected all the same.
constexpr double kChanceOfSoundForm = 1e-3;
/// A held-out observation checks a camera that predicts its place within this number of the
/// observation's own sigmas. A camera less sure is extrapolated there, and its covariance says so.
constexpr double kHeldOutSigmas = 3;

tl::unexpected<Diagnostic> camera_data_refused(std::string what, std::string expected) {
  return failure({Code::CalibrationData, {}, std::move(what), std::move(expected)});
}

Expected<void> check_options(const CameraFitOptions& options) {
  if (!options.axis_px.allFinite())
    return camera_data_refused("axis_px is not finite", "a place in the picture");
  if (!(options.focal_px > 0))
    return camera_data_refused("focal_px is not positive", "a length in px, or inf");
  if (!(options.scale_mm_per_px > 0) || !std::isfinite(options.scale_mm_per_px)) {
    return camera_data_refused("scale_mm_per_px is not positive", "mm per px");
  }
  if (!std::isfinite(options.rotation_rad))
    return camera_data_refused("rotation_rad is not finite", "rad");
  if (!(options.huber_sigmas >= 0))
    return camera_data_refused("huber_sigmas is negative", "0 or more");
  if (options.held_out_every == 1 || options.held_out_every < 0) {
    return camera_data_refused(fmt::format("held_out_every is {}", options.held_out_every),
                               "0, or 2 or more");
  }
  return {};
}

Expected<void> check_camera_data(const CameraData& data) {
  for (const PlateView& view : data.views) {
    if (!view.axis_at.in_mm().allFinite())
      return camera_data_refused("a view's place is not finite", "mm");
    if (view.i_pose >= data.views.size()) {
      return camera_data_refused(fmt::format("pose {} of {} views", view.i_pose, data.views.size()),
                                 "poses counted from 0, each with a view");
    }
  }
  for (const PlateDot& dot : data.dots) {
    const double radius_mm = dot.radius.in_mm();
    if (!dot.place.in_mm().allFinite() || !(radius_mm >= 0) || !std::isfinite(radius_mm)) {
      return camera_data_refused("a dot's place or radius is not a number",
                                 "finite mm, radius 0 or more");
    }
  }
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    const CameraObservation& seen = data.seen[i];
    if (seen.i_view >= data.views.size() || seen.i_dot >= data.dots.size()) {
      return camera_data_refused(
          fmt::format("observation {} is of view {}, dot {}", i, seen.i_view, seen.i_dot),
          fmt::format("{} views, {} dots", data.views.size(), data.dots.size()));
    }
    const Eigen::Matrix2d& cov = seen.seen.cov;
    const bool is_cov =
        cov.allFinite() && cov(0, 1) == cov(1, 0) && cov(0, 0) > 0 && cov.determinant() > 0;
    if (!seen.seen.position.in_px().allFinite() || !is_cov) {
      return camera_data_refused(fmt::format("observation {} or its covariance is not one", i),
                                 "a finite place, symmetric positive definite px^2");
    }
  }
  if (data.seen.empty())
    return camera_data_refused("there are no observations", "at least one dot in a view");
  return {};
}

/// Splits what a form frees into what the data determine and what they leave open, by the pivots of
/// a Cholesky factorization that begins with the stiffest.
std::pair<std::vector<CameraParameter>, std::vector<CameraParameter>> determined(
    const CameraInformation& information, std::span<const CameraParameter> wanted) {
  CameraModelCovariance left = information.normal;
  std::vector<CameraParameter> free;
  std::vector<CameraParameter> open;
  for (const CameraParameter parameter : wanted) {
    const auto i = static_cast<Eigen::Index>(parameter);
    const double before = information.before(i, i);
    if (!(left(i, i) > kNoCameraResidual * before) || !(before > 0)) {
      open.push_back(parameter);
      continue;
    }
    free.push_back(parameter);
    const Eigen::Matrix<double, kCameraParameters, 1> column = left.col(i);
    left -= column * column.transpose() / column[i];
  }
  return {free, open};
}

CameraModelCovariance covariance_of(const CameraModelCovariance& normal,
                                    std::span<const CameraParameter> free) {
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd part(n, n);
  Eigen::VectorXd unit(n);
  const auto at = [&](Eigen::Index i) {
    return static_cast<Eigen::Index>(free[static_cast<std::size_t>(i)]);
  };
  for (Eigen::Index i = 0; i < n; ++i) unit[i] = 1 / std::sqrt(normal(at(i), at(i)));
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) part(i, j) = normal(at(i), at(j)) * unit[i] * unit[j];
  }
  const Eigen::MatrixXd inverse = internal::Cholesky(part).inverse();
  CameraModelCovariance cov = CameraModelCovariance::Zero();
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      cov(at(i), at(j)) = 0.5 * (inverse(i, j) + inverse(j, i)) * unit[i] * unit[j];
    }
  }
  return cov;
}

/// True where a camera of this covariance predicts an observation well enough to be checked by it.
bool is_predicted(const CameraModel& camera,
                  const CameraModelCovariance& cov,
                  const CameraObservation& seen) {
  if (!camera.sees(seen.seen.position)) return false;
  const CameraModelJacobian j = camera.by_parameters(seen.seen.position);
  const double own_mm2 = std::pow(camera.parameters().scale_mm_per_px, 2) * seen.seen.cov.trace();
  return (j * cov * j.transpose()).trace() <= kHeldOutSigmas * kHeldOutSigmas * own_mm2;
}

/// True if chance would not leave the stiffer of two nested fits so much worse; the stated noise is
/// a lower bound of the data's.
bool is_rejected(const CameraFit& stiffer, const CameraFit& softer) {
  const int n_more = stiffer.degrees_of_freedom - softer.degrees_of_freedom;
  const int nu = softer.degrees_of_freedom;
  if (n_more < 1 || nu < 1) return false;
  const double variance = std::max(1.0, softer.chi_square / nu);
  const double ratio = (stiffer.chi_square - softer.chi_square) / (n_more * variance);
  return variance_ratio_exceedance(ratio, n_more, nu) < kChanceOfSoundForm;
}

/// Fits without every k-th observation and looks where those are. Left out too is the check of
/// those whose pose or dot no other observation shows, and of those that the others do not predict.
void hold_out_sights(const CameraData& data,
                     const CameraFitOptions& options,
                     std::span<const CameraParameter> free,
                     CameraState state,
                     CameraFit& fit) {
  const auto every = static_cast<std::size_t>(options.held_out_every);
  std::vector<std::size_t> used;
  std::vector<std::size_t> held;
  std::vector<int> by_pose(state.poses.size(), 0);
  std::vector<int> by_dot(data.dots.size(), 0);
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    const CameraObservation& seen = data.seen[i];
    if (i % every == every - 1) {
      held.push_back(i);
      continue;
    }
    used.push_back(i);
    ++by_pose[data.views[seen.i_view].i_pose];
    ++by_dot[seen.i_dot];
  }
  if (used.empty()) return;
  CameraProblem problem(data, used, options.huber_sigmas, state.camera);
  if (determined(problem.information(state), free).second.size() > 0) return;
  if (!problem.solve(free, state)) return;
  const CameraModel camera(state.camera);
  const CameraModelCovariance cov = covariance_of(problem.information(state).normal, free);
  double sum_px2 = 0;
  for (const std::size_t i : held) {
    const CameraObservation& seen = data.seen[i];
    // Two dots lay a pose; one more is what a look at it can be wrong about.
    const bool is_laid = by_pose[data.views[seen.i_view].i_pose] >= 2;
    if (!is_laid || (by_dot[seen.i_dot] == 0 && !data.dots[seen.i_dot].is_certified)) continue;
    if (!is_predicted(camera, cov, seen)) continue;
    const double squared_px2 = problem.residual_px(state, seen).squaredNorm();
    if (!std::isfinite(squared_px2)) continue;
    sum_px2 += squared_px2;
    ++fit.n_held_out;
  }
  if (fit.n_held_out == 0) return;
  fit.held_out_rms_px = std::sqrt(sum_px2 / static_cast<double>(fit.n_held_out));
}

/// The softest fit that leaves no more open than the stiffest does, or a softer one where F tests
/// reject those before it. From stiff to soft; not empty.
std::vector<CameraFit>::iterator softest_needed(std::vector<CameraFit>& fits) {
  auto chosen = fits.begin();
  for (auto fit = fits.begin(); fit != fits.end(); ++fit) {
    const bool is_determined = fit->undetermined.size() <= fits.front().undetermined.size();
    if (is_determined || is_rejected(*chosen, *fit)) chosen = fit;
  }
  return chosen;
}

/// The stiffest whose criterion is within kWorthASofterModel of the least.
CameraForm sufficient_form(std::span<const CameraFit> fits) {
  double least = fits.front().criterion();
  for (const CameraFit& fit : fits) least = std::min(least, fit.criterion());
  const auto is_worth = [&](const CameraFit& fit) {
    return fit.criterion() <= least + kWorthASofterModel;
  };
  return std::ranges::find_if(fits, is_worth)->form;
}

CameraFit camera_report(const CameraData& data,
                        const CameraState& state,
                        const CameraProblem& problem) {
  CameraFit fit;
  fit.parameters = state.camera;
  fit.poses = state.poses;
  for (const Eigen::Vector2d& dot_mm : state.dots_mm) {
    fit.dots.push_back(position_mm<frame::Plate>(dot_mm));
  }
  double sum_px2 = 0;
  for (const CameraObservation& seen : data.seen) {
    const Eigen::Vector2d residual_px = problem.residual_px(state, seen);
    fit.residuals.push_back(displacement_px<frame::Image>(residual_px));
    sum_px2 += residual_px.squaredNorm();
  }
  fit.rms_px = std::sqrt(sum_px2 / static_cast<double>(data.seen.size()));
  fit.chi_square = problem.chi_square(state);
  return fit;
}

}  // namespace

std::size_t CameraFit::n_free() const {
  return free_parameters(form).size() - undetermined.size();
}

double CameraFit::criterion() const {
  return chi_square + 2 * static_cast<double>(n_free());
}

std::string CameraFit::summary() const {
  std::string text = fmt::format("{} camera: {:.6f} um/px, rotation {:.4f} mrad, rms {:.4f} px",
                                 name(form),
                                 parameters.scale_mm_per_px * 1e3,
                                 parameters.rotation_rad * 1e3,
                                 rms_px);
  if (held_out_rms_px) text += fmt::format(", held out {:.4f} px", *held_out_rms_px);
  for (const CameraParameter parameter : undetermined) {
    text += fmt::format(", {} undetermined", name(parameter));
  }
  return text;
}

Expected<CameraFit> fit_camera(const CameraData& data, const CameraFitOptions& options) {
  PANELCAL_CHECK(check_options(options));
  PANELCAL_CHECK(check_camera_data(data));
  CameraState state = internal::start_of(data, options);
  if (!CameraModel::is_valid(state.camera)) {
    return camera_data_refused("the observations lie in one place", "dots or views that lie apart");
  }
  std::vector<std::size_t> all(data.seen.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  CameraProblem problem(data, all, options.huber_sigmas, state.camera);
  // A flat camera first: lens and tilt then begin near, and open parameters are judged where they
  // count.
  const auto flat = free_parameters(CameraForm::Flat);
  const auto wanted = free_parameters(options.form);
  if (!problem.solve(determined(problem.information(state), flat).first, state)) {
    return camera_data_refused("no camera shows these dots so",
                               "a picture that is not mirrored or mixed up");
  }
  const auto [free, open] = determined(problem.information(state), wanted);
  if (!problem.solve(free, state)) {
    return camera_data_refused(fmt::format("no {} camera shows these dots so", name(options.form)),
                               "a stiffer form, or observations without gross errors");
  }
  const CameraInformation information = problem.information(state);
  const auto n_parameters = static_cast<int>(free.size()) + information.n_determined;
  CameraFit fit = camera_report(data, state, problem);
  fit.form = fit.sufficient = options.form;
  fit.undetermined = open;
  fit.degrees_of_freedom = 2 * static_cast<int>(data.seen.size()) - n_parameters;
  fit.covariance = covariance_of(information.normal, free);
  if (fit.degrees_of_freedom < 0 || !std::isfinite(fit.chi_square) || !fit.covariance.allFinite()) {
    return camera_data_refused(
        fmt::format("{} observations for {} unknowns", data.seen.size(), n_parameters),
        "at least half as many observations as unknowns");
  }
  if (options.held_out_every > 0) hold_out_sights(data, options, free, state, fit);
  return fit;
}

Expected<CameraFit> choose_camera(const CameraData& data, const CameraFitOptions& options) {
  std::vector<CameraFit> fits;
  std::optional<CameraForm> wants_views;
  std::optional<Diagnostic> why_not;
  for (const CameraForm form : kCameraForms) {
    CameraFitOptions of_form = options;
    of_form.form = form;
    Expected<CameraFit> fit = fit_camera(data, of_form);
    if (!fit) {
      if (!why_not) why_not = std::move(fit).error();
      continue;
    }
    if (!fits.empty()) {
      // A form that frees no more than the form before it is that form again.
      if (fit->n_free() <= fits.back().n_free()) continue;
      if (fit->degrees_of_freedom < kFewestCameraFreedoms) {
        wants_views = form;
        break;
      }
      // A softer form that fits worse has not found its minimum.
      const double stiffer = fits.back().chi_square;
      if (fit->chi_square > stiffer + kSolverStops + kCameraRounding * stiffer) continue;
    }
    fits.push_back(*std::move(fit));
  }
  if (fits.empty()) return failure(*std::move(why_not));
  const auto softest = softest_needed(fits);
  softest->sufficient = sufficient_form({fits.begin(), softest + 1});
  softest->wants_views_for = wants_views;
  return std::move(*softest);
}

}  // namespace panelcal
