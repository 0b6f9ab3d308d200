// SPDX-License-Identifier: Apache-2.0
#include "tests/vision/polygon/trial.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::test {
namespace {

constexpr double kScaleMm = 0.01;  // per px

/// Crumbs of dirt along the outline until they hide the asked part of it.
void add_debris(const CellTrialOptions& options, Random& random, CellTrial& trial) {
  const double outline_px = 4 * trial.size_px;
  double hidden_px = 0;
  while (hidden_px < options.debris * outline_px) {
    const double diameter_px = random.uniform(4, 12);
    const double side = trial.size_px / 2;
    Eigen::Vector2d at(random.uniform(-side, side), random.uniform() < 0.5 ? -side : side);
    if (random.uniform() < 0.5) std::swap(at.x(), at.y());
    const double turn =
        trial.angle_rad + (options.shape == Shape::Diamond ? std::numbers::pi / 4 : 0);
    const Eigen::Vector2d offset(std::cos(turn) * at.x() - std::sin(turn) * at.y(),
                                 std::sin(turn) * at.x() + std::cos(turn) * at.y());
    Feature crumb;
    crumb.center =
        position_mm<frame::Optical>(Eigen::Vector2d(trial.center.in_mm() + kScaleMm * offset));
    crumb.size = mm(diameter_px * kScaleMm);
    crumb.roughness.rms = mm(0.1 * diameter_px * kScaleMm);
    crumb.roughness.seed = static_cast<std::uint64_t>(random.uniform(1, 1e9));
    crumb.level = random.uniform(0.1, 0.9);
    trial.scene.features.push_back(crumb);
    hidden_px += diameter_px;
  }
}

/// Unknowns of the mark itself; brightness comes on top.
struct Unknowns {
  Eigen::Vector2d center_mm;
  double angle_rad;
  double size_mm;
  double width_mm;
  double blur_px;
};

std::vector<double> share_of(Shape shape, const Unknowns& unknowns, Camera camera) {
  Scene scene;
  scene.background = 0;
  Feature mark = cell_feature(shape, unknowns.size_mm, unknowns.width_mm, unknowns.angle_rad, 1.0);
  mark.center = position_mm<frame::Optical>(unknowns.center_mm);
  scene.features.push_back(mark);
  camera.blur_px = unknowns.blur_px;
  camera.full_scale = 1;
  return render_levels(scene, camera);
}

}  // namespace

Feature cell_feature(Shape shape, double size_mm, double width_mm, double angle_rad, double level) {
  CellGrid grid;
  if (shape == Shape::Cross) {
    const double l = size_mm / 2;
    const double w = width_mm / 2;
    grid.x = {mm(-l), mm(-w), mm(w), mm(l)};
    grid.y = grid.x;
    const std::optional<double> none;
    grid.levels = {none, level, none, level, level, level, none, level, none};
  } else {
    // A slot runs through the picture.
    const double half_length = shape == Shape::Slot ? 4.0 : size_mm / 2;
    grid.x = {mm(-half_length), mm(half_length)};
    grid.y = {mm(-size_mm / 2), mm(size_mm / 2)};
    grid.levels = {level};
  }
  Feature feature;
  feature.shape = Feature::Shape::Cells;
  feature.angle = rad(angle_rad + (shape == Shape::Diamond ? std::numbers::pi / 4 : 0));
  feature.level = level;
  feature.cells = std::make_shared<const CellGrid>(std::move(grid));
  return feature;
}

CellTrial draw_cell_trial(const CellTrialOptions& options, Random& random) {
  const double middle = 0.5 * (options.picture_px - 1);
  CameraMapping::Parameters parameters{.scale_mm_per_px = kScaleMm,
                                       .rotation_rad = 0,
                                       .axis_px = Eigen::Vector2d::Constant(middle),
                                       .k1_per_px2 = 0};
  if (options.lens_at_corner_px != 0) {
    parameters.k1_per_px2 = options.lens_at_corner_px / std::pow(400.0, 3);
    parameters.axis_px += Eigen::Vector2d(random.uniform(-100, 100), random.uniform(-100, 100));
  }
  Camera camera{.mapping = CameraMapping(parameters),
                .width = options.picture_px,
                .height = options.picture_px,
                .blur_px = options.blur_px,
                .noise = options.noise,
                .full_scale = options.full_scale};
  if (options.full_scale > 255) camera.noise *= options.full_scale / 255;
  CellTrial trial{.scene = {},
                  .camera = camera,
                  .target = {},
                  .center_px = {middle + random.uniform(-3, 3), middle + random.uniform(-3, 3)},
                  .center = {},
                  .size_px = options.size_px};
  trial.center = camera.mapping(position_px<frame::Image>(trial.center_px));
  const bool is_dark = options.polarity == Polarity::Dark;
  Scene& scene = trial.scene;
  scene.background = (is_dark ? 200.0 : 60.0) / 255;
  scene.light_gradient = {random.uniform(-1, 1) * options.light_gradient,
                          random.uniform(-1, 1) * options.light_gradient};
  scene.weave.amplitude = options.weave / 255;
  scene.weave.panel_from_optical = Transform<frame::Nominal, frame::Optical>(
      Eigen::Matrix2d::Identity(), {random.uniform(0, 300), random.uniform(0, 300)});
  const double turn = random.uniform(-1, 1) * options.max_angle_deg * std::numbers::pi / 180;
  const double size_mm = options.size_px * kScaleMm;
  Feature mark = cell_feature(options.shape,
                              size_mm,
                              options.width_of_size * size_mm,
                              turn,
                              scene.background + (is_dark ? -1 : 1) * options.contrast / 255);
  mark.center = trial.center;
  scene.features.push_back(mark);
  // A picture's y points down, the machine's up.
  trial.angle_rad = turn;
  if (options.debris > 0) add_debris(options, random, trial);
  if (!options.with_mapping) trial.angle_rad = -turn;

  Target& target = trial.target;
  target.shape = options.shape;
  target.polarity = options.polarity;
  if (options.with_mapping) {
    target.size = mm(size_mm);
    if (options.shape == Shape::Cross) target.width = mm(options.width_of_size * size_mm);
  } else {
    target.size_px = px(options.size_px);
    if (options.shape == Shape::Cross) {
      target.width_px = px(options.width_of_size * options.size_px);
    }
  }
  return trial;
}

Eigen::Matrix2d cell_bound(const CellTrialOptions& options, const CellTrial& trial) {
  const Camera& camera = trial.camera;
  const double size_mm = trial.size_px * kScaleMm;
  const double turn = options.with_mapping ? trial.angle_rad : -trial.angle_rad;
  const Unknowns truth{
      trial.center.in_mm(), turn, size_mm, options.width_of_size * size_mm, camera.blur_px};
  const auto derivative = [&](auto field, double step) {
    Unknowns above = truth;
    Unknowns below = truth;
    field(above) += step;
    field(below) -= step;
    std::vector<double> a = share_of(options.shape, above, camera);
    const std::vector<double> b = share_of(options.shape, below, camera);
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = (a[i] - b[i]) / (2 * step);
    return a;
  };
  constexpr double kStepMm = 1e-4;
  const bool is_slot = options.shape == Shape::Slot;
  std::vector<std::vector<double>> columns = {
      derivative([](Unknowns& u) -> double& { return u.center_mm.x(); }, kStepMm),
      derivative([](Unknowns& u) -> double& { return u.center_mm.y(); }, kStepMm),
      derivative([](Unknowns& u) -> double& { return u.angle_rad; }, 1e-4),
      derivative([](Unknowns& u) -> double& { return u.size_mm; }, kStepMm),
      derivative([](Unknowns& u) -> double& { return u.blur_px; }, 1e-2)};
  if (options.shape == Shape::Cross) {
    columns.push_back(derivative([](Unknowns& u) -> double& { return u.width_mm; }, kStepMm));
  }
  const std::vector<double> share = share_of(options.shape, truth, camera);
  Scene empty = trial.scene;
  empty.features.clear();
  empty.background = 1;
  empty.weave.amplitude = 0;
  Camera unit = camera;
  unit.full_scale = 1;
  const std::vector<double> light = render_levels(empty, unit);
  const std::vector<Feature> debris(trial.scene.features.begin() + 1, trial.scene.features.end());
  const std::vector<bool> touched = touched_pixels(debris, camera);

  const int n = static_cast<int>(columns.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n + 6, n + 6);
  Eigen::VectorXd row(n + 6);
  const double contrast = options.contrast * options.full_scale / 255;
  for (std::size_t i = 0; i < share.size(); ++i) {
    if (touched[i]) continue;
    const double x = static_cast<double>(i % static_cast<std::size_t>(camera.width)) / 100 - 1;
    const double y = static_cast<double>(i / static_cast<std::size_t>(camera.width)) / 100 - 1;
    for (int k = 0; k < n; ++k) {
      row[k] = contrast * light[i] * columns[static_cast<std::size_t>(k)][i];
    }
    row.tail(6) << 1, x, y, share[i], share[i] * x, share[i] * y;
    information += row * row.transpose();
  }
  // Rounding to whole levels is noise as well.
  information /= camera.noise * camera.noise + 1.0 / 12;
  if (is_slot) {
    // Nothing is known along it: as good as nothing keeps the matrix regular.
    const Eigen::Vector2d along(std::cos(turn), std::sin(turn));
    information.topLeftCorner<2, 2>() += 1e-2 * along * along.transpose();
  }
  const Eigen::Matrix2d cov_mm = information.inverse().topLeftCorner<2, 2>();
  const Eigen::Matrix2d px_from_mm =
      camera.mapping.jacobian(position_px<frame::Image>(trial.center_px)).inverse();
  return px_from_mm * cov_mm * px_from_mm.transpose();
}

CellStatistics run_cell_trials(const CellTrialOptions& options) {
  CellStatistics out;
  out.n = options.n;
  for (int i = 0; i < options.n; ++i) {
    Random random = Random(options.seed).fork(static_cast<std::uint64_t>(i));
    const CellTrial trial = draw_cell_trial(options, random);
    const Image image = render(trial.scene, trial.camera, random);
    const std::clock_t before = std::clock();
    const Detection detection =
        locate(image, trial.target, options.with_mapping ? &trial.camera.mapping : nullptr);
    out.ms += 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    if (detection.status != DetectionStatus::Found) {
      if (out.first_failure.empty()) {
        out.first_failure = fmt::format(
            "seed {} draw {}: {}, {}", options.seed, i, name(detection.status), detection.reason);
      }
      continue;
    }
    ++out.n_found;
    const TargetFit& fit = *detection.best;
    Eigen::Vector2d e = fit.center.position.in_px() - trial.center_px;
    if (options.shape == Shape::Slot) {
      const double turn = options.with_mapping ? -trial.angle_rad : trial.angle_rad;
      const Eigen::Vector2d across(-std::sin(turn), std::cos(turn));
      e = across.dot(e) * across;
    }
    const Eigen::Matrix2d bound = cell_bound(options, trial);
    out.mean_px += e;
    out.rmse_px += e.cwiseAbs2();
    out.worst = std::max(out.worst, e.norm());
    out.ratio += 0.5 * e.dot(bound.inverse() * e);
    out.nees += 0.5 * e.dot(fit.center.cov.inverse() * e);
    const double turn = (fit.angle.in_rad() - trial.angle_rad) / fit.angle_sigma.in_rad();
    out.angle_nees += turn * turn;
  }
  if (options.shape == Shape::Slot) {  // one coordinate instead of two
    out.ratio *= 2;
    out.nees *= 2;
  }
  const double n = std::max(1, out.n_found);
  out.mean_px /= n;
  out.rmse_px = (out.rmse_px / n).cwiseSqrt();
  out.ratio = std::sqrt(out.ratio / n);
  out.nees /= n;
  out.angle_nees /= n;
  out.ms /= options.n;
  return out;
}

std::string CellStatistics::text() const {
  return fmt::format(
      "found {}/{}; rmse {:.5f} {:.5f} px, {:.3f} of the bound; worst {:.4f} px; mean {:.5f} "
      "{:.5f} px; NEES {:.3f}, angle {:.3f}; {:.2f} ms{}{}",
      n_found,
      n,
      rmse_px.x(),
      rmse_px.y(),
      ratio,
      worst,
      mean_px.x(),
      mean_px.y(),
      nees,
      angle_nees,
      ms,
      first_failure.empty() ? "" : "; ",
      first_failure);
}

}  // namespace panelcal::test
