// SPDX-License-Identifier: Apache-2.0
#include "vision/round/texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "vision/texture/ground_texture.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

/// A texture is only nearly what its model says: measured on woven boards, its part of the variance
/// is larger by this (tests/bench/README.md).
constexpr double kTextureDoubt = 1.1;
/// Ground and rim as the generalised step wants them: the rim's parameters, then the waves'
/// amplitudes.
class CircleObservations {
 public:
  CircleObservations(const RimWindow& window,
                     const RimVector& p,
                     const RimFreedom& freedom,
                     const GroundTexture& texture)
      : window_(window),
        p_(p),
        freedom_(freedom),
        texture_(texture),
        n_rim_(freedom.columns(columns_)),
        n_(n_rim_ + 2 * static_cast<int>(texture.lines.size())),
        information_(Eigen::MatrixXd::Zero(n_, n_)),
        gradient_(Eigen::VectorXd::Zero(n_)),
        row_(n_) {
    for (std::size_t k = 0; k < texture.lines.size(); ++k) {
      const Eigen::Index i = n_rim_ + 2 * static_cast<Eigen::Index>(k);
      const double amplitude = texture.lines[k].amplitude;
      information_(i, i) = information_(i + 1, i + 1) = 2 / (amplitude * amplitude);
    }
  }

  void add_band() {
    RimGradient gradient{};
    for (const RimPixel pixel : window_.band()) {
      // A linear step cannot use what clipped pixels say.
      if (pixel.clipped != 0) continue;
      const RimValue value = rim_value(pixel, p_, freedom_.is_ring, &gradient);
      add(pixel.x, pixel.y, 1 - value.share, pixel.value - value.level, gradient);
    }
  }

  /// Flat ground: within `reach_px` of a rim pixel by pixel, farther off every other one as sums.
  void add_ground(double reach_px) {
    const double far_weight =
        GroundTexture::kFarStride * GroundTexture::kFarStride / texture_.far_variance();
    for (const RimSpan& span : window_.spans()) {
      if (span.is_band || span.zone == RimZone::Target) continue;
      for (int x = span.x0; x < span.x1; ++x) {
        if (window_.is_excluded(x, span.y)) continue;
        const Eigen::Vector2d at = window_.plane_at(x, span.y);
        const bool is_far =
            span.zone == RimZone::Outside && at.norm() * window_.unit_px() > p_[kRadius] + reach_px;
        if (is_far &&
            (x % GroundTexture::kFarStride != 0 || span.y % GroundTexture::kFarStride != 0))
          continue;
        const Eigen::Vector3d b(1, at.x(), at.y());
        const RimVector slope = zone_level_jacobian(p_, span.zone).transpose() * b;
        RimGradient gradient{};
        std::copy_n(slope.data(), gradient.size(), gradient.begin());
        const double level = b.dot(zone_level(p_, span.zone));
        const double residual = static_cast<double>(window_.value(x, span.y)) - level;
        if (!is_far) {
          add(x, span.y, 1, residual, gradient);
          continue;
        }
        fill_row(x, span.y, 1, gradient);
        const Eigen::VectorXd row = row_.cast<double>();
        information_.noalias() += far_weight * row * row.transpose();
        gradient_ += far_weight * residual * row;
      }
    }
  }

  /// The flat part of the target, which has no texture: its moments say all.
  void add_target(double sigma) {
    const FlatMoments& m = window_.flat()[static_cast<std::size_t>(RimZone::Target)];
    const double w = 1 / (sigma * sigma);
    Eigen::Vector3d level = zone_level(p_, RimZone::Target);
    level[0] -= static_cast<double>(window_.reference());
    const auto all = zone_level_jacobian(p_, RimZone::Target);
    Eigen::MatrixXd d = Eigen::MatrixXd::Zero(3, n_);
    for (int k = 0; k < n_rim_; ++k) d.col(k) = all.col(columns_[static_cast<std::size_t>(k)]);
    information_ += w * d.transpose() * m.bb * d;
    gradient_ += w * d.transpose() * (m.bv - m.bb * level);
  }

  std::optional<GeneralizedStep> step() const {
    const Eigen::MatrixXf jacobian =
        Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            rows_.data(), static_cast<Eigen::Index>(pixels_.size()), n_);
    return generalized_step(pixels_, jacobian, texture_.rest, information_, gradient_);
  }
  int n_rim() const { return n_rim_; }
  int column(int i) const { return columns_[static_cast<std::size_t>(i)]; }

 private:
  void fill_row(int x, int y, double background, const RimGradient& gradient) {
    for (int i = 0; i < n_rim_; ++i) {
      row_[i] = static_cast<float>(gradient[static_cast<std::size_t>(column(i))]);
    }
    for (std::size_t k = 0; k < texture_.lines.size(); ++k) {
      const Eigen::Vector2d& wave = texture_.lines[k].wave_per_px;
      const auto phase = static_cast<float>(wave.x() * x + wave.y() * y);
      const Eigen::Index i = n_rim_ + 2 * static_cast<Eigen::Index>(k);
      row_[i] = static_cast<float>(background) * std::cos(phase);
      row_[i + 1] = static_cast<float>(background) * std::sin(phase);
    }
  }

  void add(int x, int y, double background, double residual, const RimGradient& gradient) {
    const double share = std::clamp(background, 0.0, 1.0);
    pixels_.push_back({static_cast<float>(x),
                       static_cast<float>(y),
                       static_cast<float>(share),
                       static_cast<float>(residual)});
    fill_row(x, y, share, gradient);
    rows_.insert(rows_.end(), row_.data(), row_.data() + n_);
  }

  const RimWindow& window_;
  const RimVector& p_;
  RimFreedom freedom_;
  const GroundTexture& texture_;
  std::array<int, kRimParameters> columns_{};
  int n_rim_;
  int n_;
  Eigen::MatrixXd information_;  ///< of what is not listed pixel by pixel
  Eigen::VectorXd gradient_;
  Eigen::VectorXf row_;
  std::vector<TexturedPixel> pixels_;
  std::vector<float> rows_;
};

std::optional<GroundTexture> circle_ground_texture(const RimWindow& window,
                                                   const RimResiduals& residuals) {
  std::vector<float> ground(residuals.values.size(), 0.0F);
  double n = 0;
  for (std::size_t i = 0; i < ground.size(); ++i) {
    if (residuals.kinds[i] != RimResiduals::kZone) continue;
    if (!window.excluded().empty() && window.excluded()[i] != 0) continue;
    ground[i] = residuals.values[i];
    ++n;
  }
  return ground_texture_of({ground, residuals.width, n});
}

}  // namespace

std::optional<TexturedRim> fit_on_texture(const RimWindow& window,
                                          const RimSolution& plain,
                                          const RimResiduals& residuals,
                                          const RimNoiseEstimate& noise) {
  const auto texture = circle_ground_texture(window, residuals);
  if (!texture) return std::nullopt;
  const double reach_px = texture->reach_px();
  // The plain fit's information is in units of the noise it was given.
  const Eigen::Index n = plain.information.rows();
  const Eigen::MatrixXd inverse = plain.information.ldlt().solve(Eigen::MatrixXd::Identity(n, 2));
  const Eigen::Matrix2d white_cov = inverse.topRows<2>();
  TexturedRim result{plain.parameters, {}};
  for (int pass = 0; pass < 2; ++pass) {
    const RimVector p = result.parameters;
    CircleObservations observations(window, p, plain.freedom, *texture);
    observations.add_band();
    observations.add_ground(reach_px);
    observations.add_target(noise.total[RimZone::Target]);
    const auto step = observations.step();
    if (!step && pass > 0) break;
    if (!step) return std::nullopt;
    for (int i = 0; i < observations.n_rim(); ++i) {
      result.parameters[observations.column(i)] += step->step[i];
    }
    const Eigen::Matrix2d cov = step->covariance.topLeftCorner<2, 2>();
    const Eigen::Matrix2d of_texture = cov - white_cov;
    result.center_cov = (white_cov + kTextureDoubt * of_texture) * std::max(1.0, step->chi_square);
    const double length_px = step->step.head<3>().norm();
    if (!(length_px < 0.1 * p[kRadius]) || !(result.parameters[kSigma] > 0.2)) return std::nullopt;
    if (length_px < GroundTexture::kLongStep_px) break;
  }
  return result;
}

}  // namespace panelcal::internal
