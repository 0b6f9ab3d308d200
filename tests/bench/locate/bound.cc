// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/bound.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace panelcal::bench {
namespace {

/// All that can differ from the truth.
struct Unknowns {
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  double radius_px = 0;
  double mark_level = 0;                               // grey levels
  double background_level = 0;                         // grey levels
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();  // across the window
  double blur_px = 0;
  double inner_radius_px = 0;
  double angle_deg = 0;
  double bar_width_px = 0;
};

/// Renders windows that differ from the truth.
class Window {
 public:
  Window(const Condition& condition,
         const Mark& mark,
         const Eigen::Vector2d& offset_px,
         int side_px)
      : condition_(condition), mark_(mark), offset_px_(offset_px), side_px_(side_px) {}

  /// Grey levels of 255.
  Eigen::VectorXd levels(const Unknowns& change) const {
    const Camera camera = make_camera(side_px_, side_px_, condition_.blur_px + change.blur_px, 0);
    Mark mark = mark_;
    mark.radius_px += change.radius_px;
    mark.inner_radius_px += change.inner_radius_px;
    mark.angle_deg += change.angle_deg;
    mark.bar_width_px += change.bar_width_px;
    Scene scene;
    scene.background = background_level(condition_, mark.polarity) + change.background_level / 255;
    scene.light_gradient = change.gradient;
    const Eigen::Vector2d middle = Eigen::Vector2d::Constant(0.5 * (side_px_ - 1));
    scene.features =
        features_of(mark,
                    camera,
                    middle + offset_px_ + change.center_px,
                    bench::mark_level(condition_, mark.polarity) + change.mark_level / 255);
    const std::vector<double> levels = render_levels(scene, camera);
    return Eigen::VectorXd::Map(levels.data(), static_cast<Eigen::Index>(levels.size()));
  }

  /// Central difference per unit of one unknown.
  template <class Set>
  Eigen::VectorXd derivative(double step, const Set& set) const {
    Unknowns up;
    Unknowns down;
    set(up, step);
    set(down, -step);
    return (levels(up) - levels(down)) / (2 * step);
  }

 private:
  Condition condition_;
  Mark mark_;
  Eigen::Vector2d offset_px_;
  int side_px_;
};

/// Small against the blur: the difference is 0.02 % off for a blur of 1 px.
constexpr double kStepPx = 0.05;

std::vector<Eigen::VectorXd> common_columns(const Window& window) {
  return {
      window.derivative(kStepPx, [](Unknowns& u, double d) { u.center_px.x() = d; }),
      window.derivative(kStepPx, [](Unknowns& u, double d) { u.center_px.y() = d; }),
      window.derivative(kStepPx, [](Unknowns& u, double d) { u.radius_px = d; }),
      window.derivative(5, [](Unknowns& u, double d) { u.mark_level = d; }),
      window.derivative(5, [](Unknowns& u, double d) { u.background_level = d; }),
      window.derivative(0.1, [](Unknowns& u, double d) { u.gradient.x() = d; }),
      window.derivative(0.1, [](Unknowns& u, double d) { u.gradient.y() = d; }),
      window.derivative(kStepPx, [](Unknowns& u, double d) { u.blur_px = d; }),
  };
}

/// Inverse of a Fisher matrix, its upper left 2 x 2; scaled first, as units differ.
Eigen::Matrix2d center_part_of_inverse(const Eigen::MatrixXd& fisher) {
  const Eigen::VectorXd scale = fisher.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * fisher * scale.asDiagonal();
  const Eigen::MatrixXd inverse = scaled.fullPivLu().inverse();
  const Eigen::Matrix2d block = inverse.topLeftCorner<2, 2>();
  return scale.head<2>().asDiagonal() * block * scale.head<2>().asDiagonal();
}

}  // namespace

LinearModel linearise(const Condition& condition,
                      const Mark& mark,
                      const Eigen::Vector2d& offset_px,
                      int margin_px) {
  const int side_px = 2 * (static_cast<int>(std::ceil(mark.radius_px)) + margin_px) + 1;
  const Window window(condition, mark, offset_px, side_px);
  std::vector<Eigen::VectorXd> columns = common_columns(window);
  if (mark.shape == Shape::Ring) {
    columns.push_back(
        window.derivative(kStepPx, [](Unknowns& u, double d) { u.inner_radius_px = d; }));
    // The hole may be off-centre: its two coordinates are unknown as well. Moving it changes the
    // picture by as much as moving a disc of its size would, the other way round.
    Mark hole = mark;
    hole.shape = Shape::Disc;
    hole.radius_px = mark.inner_radius_px;
    const Window of_hole(condition, hole, offset_px + mark.hole_offset_px, side_px);
    for (const int axis : {0, 1}) {
      columns.push_back(
          -of_hole.derivative(kStepPx, [axis](Unknowns& u, double d) { u.center_px[axis] = d; }));
    }
  }
  if (mark.shape == Shape::Square || mark.shape == Shape::Diamond || mark.shape == Shape::Cross) {
    columns.push_back(window.derivative(0.1, [](Unknowns& u, double d) { u.angle_deg = d; }));
  }
  if (mark.shape == Shape::Cross) {
    columns.push_back(
        window.derivative(kStepPx, [](Unknowns& u, double d) { u.bar_width_px = d; }));
  }
  LinearModel model;
  model.side_px = side_px;
  model.value = window.levels({});
  model.jacobian.resize(model.value.size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    model.jacobian.col(static_cast<Eigen::Index>(i)) = columns[i];
  }
  // Raising the background by a level raises a pixel by what it sees of the background.
  model.background_share = columns[4];
  return model;
}

Eigen::Matrix2d white_bound(const LinearModel& model,
                            double noise,
                            const Eigen::VectorXd& visible) {
  const Eigen::MatrixXd& j = model.jacobian;
  const Eigen::MatrixXd fisher = visible.size() == 0
                                     ? Eigen::MatrixXd(j.transpose() * j)
                                     : Eigen::MatrixXd(j.transpose() * visible.asDiagonal() * j);
  return noise * noise * center_part_of_inverse(fisher);
}

Eigen::MatrixXd solve_coloured(const LinearModel& model, double noise, const Texture& texture) {
  const Eigen::VectorXd& share = model.background_share;
  const auto covariance_times = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
    const Eigen::VectorXd seen = share.cwiseProduct(v);
    return noise * noise * v + share.cwiseProduct(texture.times(seen, model.side_px));
  };
  constexpr int kMaxIterations = 3000;
  constexpr double kTolerance = 1e-7;
  Eigen::MatrixXd solution(model.jacobian.rows(), model.jacobian.cols());
  for (Eigen::Index c = 0; c < model.jacobian.cols(); ++c) {
    // Conjugate gradients: the matrix is known by its products only.
    const Eigen::VectorXd b = model.jacobian.col(c);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
    Eigen::VectorXd r = b;
    Eigen::VectorXd p = r;
    double rr = r.squaredNorm();
    for (int k = 0; k < kMaxIterations && rr > kTolerance * kTolerance * b.squaredNorm(); ++k) {
      const Eigen::VectorXd q = covariance_times(p);
      const double alpha = rr / p.dot(q);
      x += alpha * p;
      r -= alpha * q;
      const double next = r.squaredNorm();
      p = r + (next / rr) * p;
      rr = next;
    }
    solution.col(c) = x;
  }
  return solution;
}

Eigen::Matrix2d coloured_bound(const LinearModel& model, double noise, const Texture& texture) {
  const Eigen::MatrixXd solution = solve_coloured(model, noise, texture);
  const Eigen::MatrixXd fisher = model.jacobian.transpose() * solution;
  return center_part_of_inverse(0.5 * (fisher + fisher.transpose()));
}

double closed_form_bound(const Condition& condition, double radius_px) {
  const double s = std::sqrt(condition.blur_px * condition.blur_px + 1.0 / 12);
  return condition.noise / condition.contrast *
         std::sqrt(2 * s / (std::sqrt(std::numbers::pi) * radius_px));
}

Eigen::VectorXd visible_pixels(const Sample& sample) {
  std::vector<Feature> others;
  for (std::size_t i = 0; i < sample.scene.features.size(); ++i) {
    const bool is_mark = i >= sample.first_of_mark && i < sample.first_debris;
    if (!is_mark) others.push_back(sample.scene.features[i]);
  }
  constexpr double kTouched = 0.03;
  const std::vector<bool> touched = touched_pixels(others, sample.camera, kTouched);
  const int reach = static_cast<int>(std::ceil(sample.mark.radius_px)) + kWindowMarginPx;
  const int x0 = static_cast<int>(std::lround(sample.center_px.x())) - reach;
  const int y0 = static_cast<int>(std::lround(sample.center_px.y())) - reach;
  const int side = 2 * reach + 1;
  Eigen::VectorXd visible = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(side) * side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const int u = x0 + x;
      const int v = y0 + y;
      if (u < 0 || v < 0 || u >= sample.camera.width || v >= sample.camera.height) continue;
      const bool is_touched =
          touched[static_cast<std::size_t>(v) * static_cast<std::size_t>(sample.camera.width) +
                  static_cast<std::size_t>(u)];
      visible[y * side + x] = is_touched ? 0 : 1;
    }
  }
  return visible;
}

}  // namespace panelcal::bench
