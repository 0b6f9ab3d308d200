// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "vision/polygon/quality.h"
#include "vision/polygon/solver.h"
#include "vision/texture/ground_texture.h"

namespace panelcal::internal {
namespace {

bool is_ground(const CellPixel& pixel) {
  return pixel.is_flat && pixel.share < 0.5F && !pixel.is_excluded;
}

double pixel_level(const CellModel& model, const CellState& state, const CellPixel& pixel) {
  const Eigen::Vector3d plane = model.plane_terms(pixel.at);
  return plane.dot(state.levels.head<3>()) +
         static_cast<double>(pixel.share) * plane.dot(state.levels.tail<3>());
}

std::optional<GroundTexture> polygon_ground_texture(const CellModel& model, const CellFit& fit) {
  if (fit.pixels.empty()) return std::nullopt;
  const PixelBox box = box_of(fit.pixels);
  std::vector<float> ground(
      static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height), 0.0F);
  double n = 0;
  for (const CellPixel& pixel : fit.pixels) {
    if (!is_ground(pixel)) continue;
    const auto i =
        static_cast<std::size_t>(pixel.y - box.y0) * static_cast<std::size_t>(box.width) +
        static_cast<std::size_t>(pixel.x - box.x0);
    ground[i] = static_cast<float>(pixel.value - pixel_level(model, fit.state, pixel));
    ++n;
  }
  constexpr double kEnough = 200;
  if (n < kEnough) return std::nullopt;
  return ground_texture_of({ground, box.width, n});
}

/// Ground and lines as the generalised step wants them: the model's parameters, then the waves'
/// amplitudes.
class PolygonObservations {
 public:
  PolygonObservations(const CellModel& model, const CellState& state, const GroundTexture& texture)
      : model_(model),
        texture_(texture),
        view_(model, state),
        n_model_(model.n_parameters()),
        n_(n_model_ + 2 * static_cast<int>(texture.lines.size())),
        information_(Eigen::MatrixXd::Zero(n_, n_)),
        gradient_(Eigen::VectorXd::Zero(n_)),
        row_(n_) {
    for (std::size_t k = 0; k < texture.lines.size(); ++k) {
      const Eigen::Index i = n_model_ + 2 * static_cast<Eigen::Index>(k);
      const double amplitude = texture.lines[k].amplitude;
      information_(i, i) = information_(i + 1, i + 1) = 2 / (amplitude * amplitude);
    }
  }

  void add(const CellFit& fit, double full_scale, double reach_px) {
    CellState sharp = fit.state;
    sharp.sigma_px = 1e-3;
    CellView lines(model_, sharp);
    const double far_weight =
        GroundTexture::kFarStride * GroundTexture::kFarStride / texture_.far_variance();
    const double target_weight = 1 / (fit.noise_inside * fit.noise_inside);
    for (const CellPixel& pixel : fit.pixels) {
      if (pixel.is_excluded) continue;
      const auto value = view_.evaluate(pixel, &model_gradient_);
      if (!value.is_known || is_beyond_scale(pixel.value, value.level, full_scale)) continue;
      const double residual = pixel.value - value.level;
      if (pixel.is_flat && pixel.share > 0.5F) {
        add_sum(pixel, 0, residual, target_weight);
      } else if (pixel.is_flat && lines.flat_share(pixel, reach_px)) {
        const bool is_kept =
            pixel.x % GroundTexture::kFarStride == 0 && pixel.y % GroundTexture::kFarStride == 0;
        if (is_kept) add_sum(pixel, 1, residual, far_weight);
      } else {
        add_pixel(pixel, std::clamp(1 - value.share, 0.0, 1.0), residual);
      }
    }
  }

  /// A direction that nothing tells of: it stays where it is.
  void hold(int i) {
    for (std::size_t k = static_cast<std::size_t>(i); k < rows_.size();
         k += static_cast<std::size_t>(n_)) {
      rows_[k] = 0;
    }
    information_.row(i).setZero();
    information_.col(i).setZero();
    information_(i, i) = 1;
    gradient_[i] = 0;
  }

  std::optional<GeneralizedStep> step() const {
    const Eigen::MatrixXf jacobian =
        Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            rows_.data(), static_cast<Eigen::Index>(pixels_.size()), n_);
    return generalized_step(pixels_, jacobian, texture_.rest, information_, gradient_);
  }

 private:
  void fill_row(const CellPixel& pixel, double background) {
    row_.head(n_model_) = model_gradient_.head(n_model_);
    for (std::size_t k = 0; k < texture_.lines.size(); ++k) {
      const Eigen::Vector2d& wave = texture_.lines[k].wave_per_px;
      const double phase = wave.x() * pixel.x + wave.y() * pixel.y;
      const Eigen::Index i = n_model_ + 2 * static_cast<Eigen::Index>(k);
      row_[i] = background * std::cos(phase);
      row_[i + 1] = background * std::sin(phase);
    }
  }

  void add_sum(const CellPixel& pixel, double background, double residual, double weight) {
    fill_row(pixel, background);
    information_.noalias() += weight * row_ * row_.transpose();
    gradient_ += weight * residual * row_;
  }

  void add_pixel(const CellPixel& pixel, double background, double residual) {
    fill_row(pixel, background);
    pixels_.push_back({static_cast<float>(pixel.x),
                       static_cast<float>(pixel.y),
                       static_cast<float>(background),
                       static_cast<float>(residual)});
    for (Eigen::Index i = 0; i < n_; ++i) rows_.push_back(static_cast<float>(row_[i]));
  }

  const CellModel& model_;
  const GroundTexture& texture_;
  CellView view_;
  int n_model_;
  int n_;
  Eigen::MatrixXd information_;  ///< of what is not listed pixel by pixel
  Eigen::VectorXd gradient_;
  Eigen::VectorXd row_;
  CellVector model_gradient_;
  std::vector<TexturedPixel> pixels_;
  std::vector<float> rows_;
};

}  // namespace

void refit_on_texture(const CellModel& model,
                      double full_scale,
                      bool is_blind_along_x,
                      CellFit& fit) {
  const auto texture = polygon_ground_texture(model, fit);
  if (!texture) return;
  const double reach_px = texture->reach_px();
  const int n = model.n_parameters();
  const double half = half_extent(model.pattern());
  CellFit better = fit;
  for (int pass = 0; pass < 2; ++pass) {
    const CellState state = better.state;
    PolygonObservations observations(model, state, *texture);
    observations.add(better, full_scale, reach_px);
    if (is_blind_along_x) observations.hold(0);
    const auto step = observations.step();
    if (!step || !step->step.allFinite() || !step->covariance.allFinite()) return;
    CellVector move = CellVector::Zero();
    move.head(n) = step->step.head(n);
    const double length = move.head<2>().norm() + half * move.segment<2>(2).norm();
    if (!(length < 0.1 * half) || !(state.sigma_px + move[model.i_sigma()] > 0.2)) return;
    better.state = model.moved(state, move);
    better.cov.topLeftCorner(n, n) =
        step->covariance.topLeftCorner(n, n) * std::max(1.0, step->chi_square);
    if (length < GroundTexture::kLongStep_px) break;
  }
  fit.state = better.state;
  fit.cov = better.cov;
}

}  // namespace panelcal::internal
