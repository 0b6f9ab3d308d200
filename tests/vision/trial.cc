// SPDX-License-Identifier: Apache-2.0
#include "tests/vision/trial.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::test {
namespace {

constexpr double kScaleMm = 0.01;
/// Small pictures make quick tests; the optical axis may lie outside of them.
constexpr int kSide = 200;

Eigen::Vector2d direction(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

Camera draw_camera(const TrialOptions& options, Random& random) {
  const double corner_px = std::hypot(320, 240);
  const double middle = 0.5 * (kSide - 1);
  const double distance = options.off_axis_px * std::sqrt(random.uniform());
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  const CameraMapping::Parameters parameters{
      .scale_mm_per_px = kScaleMm,
      .rotation_rad = 0.02,
      .axis_px = Eigen::Vector2d(middle, middle) + distance * direction(angle),
      .k1_per_px2 = options.lens_at_corner_px / std::pow(corner_px, 3)};
  return {CameraMapping(parameters),
          kSide,
          kSide,
          options.blur_px,
          options.noise * options.full_scale / 255,
          options.full_scale};
}

/// Discs and bars around the target, none of its size, 6 to 20 px from its rim.
void add_neighbours(const TrialOptions& options, Random& random, double level, Trial& trial) {
  for (int i = 0; i < options.n_neighbours; ++i) {
    Feature other;
    other.shape = i % 3 == 2 ? Feature::Shape::Rectangle : Feature::Shape::Disc;
    const double reach_px = trial.radius_px * random.uniform(0.3, 0.8);
    other.size = mm(2 * reach_px * kScaleMm);
    other.inner_size = 0.3 * other.size;
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    other.angle = rad(angle);
    const double distance_px = trial.radius_px + reach_px + random.uniform(6, 20);
    other.center = trial.center + displacement_mm<frame::Optical>(
                                      Eigen::Vector2d(distance_px * kScaleMm * direction(angle)));
    other.level = level;
    trial.scene.features.push_back(other);
  }
}

}  // namespace

Trial draw_trial(const TrialOptions& options, Random& random) {
  Camera camera = draw_camera(options, random);
  Trial trial{.scene = {}, .camera = camera, .target = {}, .center_px = {}, .center = {}};
  trial.radius_px = random.uniform(options.min_radius_px, options.max_radius_px);
  const double middle = 0.5 * (kSide - 1);
  trial.center_px = {middle + random.uniform(-3, 3), middle + random.uniform(-3, 3)};
  trial.center = camera.mapping(position_px<frame::Image>(trial.center_px));
  const bool is_dark = options.polarity == Polarity::Dark;

  Scene& scene = trial.scene;
  scene.background = (is_dark ? 200.0 : 80.0) / 255;
  scene.weave.amplitude = options.weave / 255;
  scene.weave.period = mm(options.weave_period_px * kScaleMm);
  scene.weave.panel_from_optical = Transform<frame::Nominal, frame::Optical>(
      Eigen::Matrix2d::Identity(), {random.uniform(0, 300), random.uniform(0, 300)});
  scene.light_gradient = {random.uniform(-1, 1) * options.light_gradient,
                          random.uniform(-1, 1) * options.light_gradient};
  Feature mark;
  mark.shape = options.shape == Shape::Ring ? Feature::Shape::Ring : Feature::Shape::Disc;
  mark.center = trial.center;
  mark.size = mm(2 * trial.radius_px * kScaleMm);
  mark.inner_size = options.shape == Shape::Ring ? random.uniform(0.4, 0.7) * mark.size : mm(0);
  mark.level = scene.background + (is_dark ? -1 : 1) * options.contrast / 255;
  add_neighbours(options, random, mark.level, trial);
  scene.features.push_back(mark);

  trial.target.shape = options.shape;
  trial.target.polarity = options.polarity;
  if (options.with_mapping) {
    trial.target.size = mark.size;
  } else {
    trial.target.size_px = px(2 * trial.radius_px);
  }
  const double s = std::sqrt(options.blur_px * options.blur_px + 1.0 / 12);
  trial.bound_px = options.noise / options.contrast *
                   std::sqrt(2 * s / (std::sqrt(std::numbers::pi) * trial.radius_px));
  return trial;
}

TrialStatistics run_trials(const TrialOptions& options) {
  TrialStatistics out;
  out.n = options.n;
  const double s = std::sqrt(options.blur_px * options.blur_px + 1.0 / 12);
  for (int i = 0; i < options.n; ++i) {
    Random random = Random(options.seed).fork(static_cast<std::uint64_t>(i));
    const Trial trial = draw_trial(options, random);
    const Image image = render(trial.scene, trial.camera, random);
    const Detection detection =
        locate(image, trial.target, options.with_mapping ? &trial.camera.mapping : nullptr);
    if (detection.status != DetectionStatus::Found) {
      if (out.first_failure.empty()) {
        out.first_failure = fmt::format(
            "seed {} draw {}: {}, {}", options.seed, i, name(detection.status), detection.reason);
      }
      continue;
    }
    ++out.n_found;
    const TargetFit& fit = *detection.best;
    const Eigen::Vector2d e_px = fit.center.position.in_px() - trial.center_px;
    const Eigen::Vector2d e = e_px / trial.bound_px;
    out.mean += e;
    out.rmse += e.cwiseAbs2();
    out.nees_px += 0.5 * e_px.dot(fit.center.cov.inverse() * e_px);
    if (fit.center_optical) {
      const Eigen::Vector2d e_mm = (fit.center_optical->position - trial.center).in_mm();
      out.nees_mm += 0.5 * e_mm.dot(fit.center_optical->cov.inverse() * e_mm);
    }
    const double radius_px =
        fit.size_mm ? 0.5 * fit.size_mm->in_mm() / kScaleMm : 0.5 * fit.size.in_px();
    out.radius_rms_px += std::pow(radius_px - trial.radius_px, 2);
    out.blur_bias_px += fit.blur_px - s;
  }
  const double n = std::max(1, out.n_found);
  out.mean /= n;
  out.rmse = (out.rmse / n).cwiseSqrt();
  out.nees_px /= n;
  out.nees_mm /= n;
  out.radius_rms_px = std::sqrt(out.radius_rms_px / n);
  out.blur_bias_px /= n;
  return out;
}

std::string TrialStatistics::text() const {
  return fmt::format(
      "found {}/{}; rmse / bound {:.3f} {:.3f}; mean / bound {:.3f} {:.3f}; NEES px {:.3f} mm "
      "{:.3f}; "
      "radius rms {:.4f} px; blur bias {:.4f} px{}{}",
      n_found,
      n,
      rmse.x(),
      rmse.y(),
      mean.x(),
      mean.y(),
      nees_px,
      nees_mm,
      radius_rms_px,
      blur_bias_px,
      first_failure.empty() ? "" : "; ",
      first_failure);
}

Camera plain_camera(int width, int height) {
  const CameraMapping::Parameters parameters{
      .scale_mm_per_px = kScaleMm,
      .rotation_rad = 0,
      .axis_px = Eigen::Vector2d(0.5 * (width - 1), 0.5 * (height - 1)),
      .k1_per_px2 = 0};
  return {CameraMapping(parameters), width, height, 1.0, 0.0, 255.0};
}

Feature disc_at(const Camera& camera, double x_px, double y_px, double radius_px, double level) {
  Feature disc;
  disc.center = camera.mapping(position_px(x_px, y_px));
  disc.size = mm(2 * radius_px * kScaleMm);
  disc.level = level;
  return disc;
}

}  // namespace panelcal::test
