// SPDX-License-Identifier: Apache-2.0
#include "tests/vision/template/trial.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>

#include "vision/locate/locate.h"
#include "vision/picture/cv_bridge.h"
#include <Eigen/LU>
#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace panelcal::test {
namespace {

constexpr double kScaleMm = 0.01;
constexpr double kBackground = 70.0 / 255;

Camera camera_of(int width, int height, double blur_px, double noise) {
  CameraMapping::Parameters parameters;
  parameters.scale_mm_per_px = kScaleMm;
  parameters.axis_px = Eigen::Vector2d(0.5 * (width - 1), 0.5 * (height - 1));
  Camera camera{CameraMapping(parameters), width, height};
  camera.blur_px = blur_px;
  camera.noise = noise;
  return camera;
}

double level_of(const TemplateTrialOptions& options) {
  return kBackground + options.contrast / 255;
}

void set_weave(const TemplateTrialOptions& options, Random& random, Scene& scene) {
  scene.background = kBackground;
  scene.weave.amplitude = options.weave / 255;
  scene.weave.period = mm(30 * kScaleMm);
  scene.weave.panel_from_optical = Transform<frame::Nominal, frame::Optical>(
      Eigen::Matrix2d::Identity(), {random.uniform(0, 300), random.uniform(0, 300)});
}

void add_debris(const TemplateTrialOptions& options, Random& random, TemplateTrial& trial) {
  for (int i = 0; i < options.n_debris; ++i) {
    Feature crumb;
    const Eigen::Vector2d at(random.uniform(-36, 36), random.uniform(-32, 32));
    crumb.center = trial.camera.mapping(position_px<frame::Image>(trial.pose.center_px + at));
    crumb.size = mm(random.uniform(4, 9) * kScaleMm);
    crumb.level = random.uniform() < 0.5 ? 0.05 : 0.95;
    trial.scene.features.push_back(crumb);
  }
}

/// OpenCV's way: the best place of matchTemplate, refined by parabolas; no turn.
Eigen::Vector2d peer_place(const Image& image, const TemplatePicture& picture) {
  cv::Mat result;
  cv::matchTemplate(
      internal::mat_of(image), internal::mat_of(picture.image), result, cv::TM_CCOEFF_NORMED);
  cv::Point at;
  cv::minMaxLoc(result, nullptr, nullptr, nullptr, &at);
  const auto value = [&](int dx, int dy) {
    return static_cast<double>(result.at<float>(std::clamp(at.y + dy, 0, result.rows - 1),
                                                std::clamp(at.x + dx, 0, result.cols - 1)));
  };
  const auto vertex = [](double left, double middle, double right) {
    const double bend = left - 2 * middle + right;
    return bend < 0 ? 0.5 * (left - right) / bend : 0.0;
  };
  return Eigen::Vector2d(at.x + vertex(value(-1, 0), value(0, 0), value(1, 0)),
                         at.y + vertex(value(0, -1), value(0, 0), value(0, 1))) +
         picture.reference_px;
}

}  // namespace

std::vector<Feature> mark(const Camera& camera, const MarkPose& pose, double level) {
  struct Part {
    Feature::Shape shape;
    double x_px, y_px, size_px, inner_px, angle;
  };
  constexpr std::array kParts = {Part{Feature::Shape::Ring, -14, 10, 34, 18, 0},
                                 Part{Feature::Shape::Rectangle, 16, 18, 30, 10, 0.3},
                                 Part{Feature::Shape::Rectangle, 2, -20, 56, 8, 0},
                                 Part{Feature::Shape::Disc, 24, -4, 14, 0, 0}};
  const auto middle = camera.mapping(position_px<frame::Image>(pose.center_px));
  const double scale_mm = kScaleMm * pose.scale;
  Eigen::Matrix2d turn;
  turn << std::cos(pose.turn), -std::sin(pose.turn), std::sin(pose.turn), std::cos(pose.turn);
  std::vector<Feature> features;
  for (const Part& part : kParts) {
    Feature feature;
    feature.shape = part.shape;
    const Eigen::Vector2d at_mm = scale_mm * (turn * Eigen::Vector2d(part.x_px, part.y_px));
    feature.center = middle + displacement_mm<frame::Optical>(at_mm);
    feature.size = mm(scale_mm * part.size_px);
    feature.inner_size = mm(scale_mm * part.inner_px);
    feature.angle = rad(part.angle + pose.turn);
    feature.level = level;
    features.push_back(feature);
  }
  return features;
}

std::shared_ptr<const TemplatePicture> template_of_mark(const TemplateTrialOptions& options,
                                                        const Eigen::Vector2d& phase_px,
                                                        Random& random) {
  const Camera camera =
      camera_of(kTemplateWidth, kTemplateHeight, options.template_blur_px, options.template_noise);
  const Eigen::Vector2d middle(0.5 * (kTemplateWidth - 1), 0.5 * (kTemplateHeight - 1));
  const MarkPose pose{middle + phase_px, 0, 1};
  Scene scene;
  set_weave(options, random, scene);
  scene.features = mark(camera, pose, level_of(options));
  return std::make_shared<TemplatePicture>(
      TemplatePicture{"mark.png", render(scene, camera, random), pose.center_px});
}

TemplateTrial draw_template_trial(const TemplateTrialOptions& options, Random& random) {
  Random of_template = options.fixed_template ? Random(options.seed) : random.fork(1000);
  TemplateTrial trial{.scene = {},
                      .camera = camera_of(kTrialSide, kTrialSide, options.blur_px, options.noise),
                      .target = {},
                      .pose = {},
                      .image = {}};
  const Eigen::Vector2d phase(of_template.uniform(-0.5, 0.5), of_template.uniform(-0.5, 0.5));
  trial.target.shape = Shape::Template;
  trial.target.picture = template_of_mark(options, phase, of_template);
  if (options.with_mapping) {
    trial.target.size = mm(kTemplateWidth * kScaleMm);
  } else {
    trial.target.size_px = px(kTemplateWidth);
  }
  const double middle = 0.5 * (kTrialSide - 1);
  trial.pose.center_px = {middle + random.uniform(-20, 20), middle + random.uniform(-20, 20)};
  trial.pose.turn = deg(random.uniform(-options.max_turn_deg, options.max_turn_deg)).in_rad();
  trial.pose.scale = 1 + options.size_change;
  set_weave(options, random, trial.scene);
  trial.scene.light_gradient = {random.uniform(-1, 1) * options.light_gradient,
                                random.uniform(-1, 1) * options.light_gradient};
  trial.scene.features = mark(trial.camera, trial.pose, level_of(options));
  add_debris(options, random, trial);
  trial.image = render(trial.scene, trial.camera, random);
  return trial;
}

Eigen::Matrix2d template_bound(const TemplateTrial& trial, const TemplateTrialOptions& options) {
  constexpr int kUnknowns = 11;
  const auto levels_of = [&](const MarkPose& pose, double blur_px) {
    Scene scene;
    scene.background = kBackground;
    scene.features = mark(trial.camera, pose, level_of(options));
    Camera camera = trial.camera;
    camera.blur_px = blur_px;
    return render_levels(scene, camera);
  };
  constexpr double kStep = 0.01;  // px, rad / 30, relative / 30
  const auto derivative = [&](const std::function<void(MarkPose&, double&, double)>& move,
                              double h) {
    MarkPose high = trial.pose;
    MarkPose low = trial.pose;
    double blur_high = options.blur_px;
    double blur_low = options.blur_px;
    move(high, blur_high, h);
    move(low, blur_low, -h);
    std::vector<double> d = levels_of(high, blur_high);
    const std::vector<double> other = levels_of(low, blur_low);
    for (std::size_t i = 0; i < d.size(); ++i) d[i] = (d[i] - other[i]) / (2 * h);
    return d;
  };
  const std::array columns = {
      derivative([](MarkPose& p, double&, double h) { p.center_px.x() += h; }, kStep),
      derivative([](MarkPose& p, double&, double h) { p.center_px.y() += h; }, kStep),
      derivative([](MarkPose& p, double&, double h) { p.turn += h; }, kStep / 30),
      derivative([](MarkPose& p, double&, double h) { p.scale += h; }, kStep / 30),
      derivative([](MarkPose&, double& blur, double h) { blur += h; }, kStep)};
  const std::vector<double> levels = levels_of(trial.pose, options.blur_px);
  Eigen::Matrix<double, kUnknowns, kUnknowns> fisher;
  fisher.setZero();
  const double variance = std::pow(options.noise, 2) + std::pow(options.template_noise, 2);
  const double c = std::cos(trial.pose.turn);
  const double s = std::sin(trial.pose.turn);
  std::size_t i = 0;
  for (int y = 0; y < kTrialSide; ++y) {
    for (int x = 0; x < kTrialSide; ++x, ++i) {
      const Eigen::Vector2d d = Eigen::Vector2d(x, y) - trial.pose.center_px;
      // Back into the template: y points down here and up where the mark is turned.
      const Eigen::Vector2d t(c * d.x() - s * d.y(), s * d.x() + c * d.y());
      if (std::abs(t.x()) > 0.5 * kTemplateWidth || std::abs(t.y()) > 0.5 * kTemplateHeight)
        continue;
      Eigen::Matrix<double, kUnknowns, 1> row;
      for (std::size_t k = 0; k < columns.size(); ++k)
        row[static_cast<Eigen::Index>(k)] = columns[k][i];
      const Eigen::Vector3d plane(1, d.x() / 50, d.y() / 50);
      row.segment<3>(5) = plane;
      row.segment<3>(8) = (levels[i] / (255 * kBackground) - 1) * plane;
      fisher += row * row.transpose() / variance;
    }
  }
  return fisher.inverse().topLeftCorner<2, 2>();
}

TemplateStatistics run_template_trials(const TemplateTrialOptions& options) {
  TemplateStatistics out;
  out.n = options.n;
  Eigen::Vector2d bound_px = Eigen::Vector2d::Zero();
  for (int i = 0; i < options.n; ++i) {
    Random random = Random(options.seed).fork(static_cast<std::uint64_t>(i));
    const TemplateTrial trial = draw_template_trial(options, random);
    // It hardly depends on the place, and rendering takes its time.
    if (i % 25 == 0) bound_px = template_bound(trial, options).diagonal().cwiseSqrt();
    const auto start = std::chrono::steady_clock::now();
    const Detection detection =
        locate(trial.image, trial.target, options.with_mapping ? &trial.camera.mapping : nullptr);
    out.milliseconds +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    const Eigen::Vector2d peer =
        peer_place(trial.image, *trial.target.picture) - trial.pose.center_px;
    out.peer_rmse_px += peer.cwiseAbs2();
    if (detection.status != DetectionStatus::Found) {
      if (out.first_failure.empty()) {
        out.first_failure = fmt::format(
            "seed {} draw {}: {}, {}", options.seed, i, name(detection.status), detection.reason);
      }
      continue;
    }
    ++out.n_found;
    const TargetFit& fit = *detection.best;
    const Eigen::Vector2d e_px = fit.center.position.in_px() - trial.pose.center_px;
    const Eigen::Vector2d e = e_px.cwiseQuotient(bound_px);
    out.mean += e;
    out.rmse += e.cwiseAbs2();
    out.rmse_px += e_px.cwiseAbs2();
    out.nees += 0.5 * e_px.dot(fit.center.cov.inverse() * e_px);
    const double turn = options.with_mapping ? trial.pose.turn : -trial.pose.turn;
    out.angle_nees += std::pow((fit.angle.in_rad() - turn) / fit.angle_sigma.in_rad(), 2);
    out.mean_score += fit.score;
  }
  const double n = std::max(1, out.n_found);
  out.mean /= n;
  out.rmse = (out.rmse / n).cwiseSqrt();
  out.rmse_px = (out.rmse_px / n).cwiseSqrt();
  out.peer_rmse_px = (out.peer_rmse_px / options.n).cwiseSqrt();
  out.nees /= n;
  out.angle_nees /= n;
  out.mean_score /= n;
  out.milliseconds /= options.n;
  return out;
}

std::string TemplateStatistics::text() const {
  return fmt::format(
      "found {}/{}; rmse / bound {:.3f} {:.3f}; mean / bound {:.3f} {:.3f}; NEES {:.3f}, of the "
      "angle "
      "{:.3f}; rmse {:.5f} {:.5f} px, matchTemplate {:.5f} {:.5f} px; score {:.4f}; {:.1f} ms{}{}",
      n_found,
      n,
      rmse.x(),
      rmse.y(),
      mean.x(),
      mean.y(),
      nees,
      angle_nees,
      rmse_px.x(),
      rmse_px.y(),
      peer_rmse_px.x(),
      peer_rmse_px.y(),
      mean_score,
      milliseconds,
      first_failure.empty() ? "" : "; ",
      first_failure);
}

}  // namespace panelcal::test
