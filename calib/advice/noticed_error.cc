// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/noticed_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/base/statistics/chi_square.h"
#include "calib/base/statistics/linear_algebra.h"
#include "calib/panel/system.h"

namespace panelcal {
namespace {

/// A normal variable lies below this with probability kNoticedShare.
constexpr double kNoticed_sigmas = 0.8416212335729143;
/// Below this share of an error's own weight residuals show nothing of it.
constexpr double kBlind = 1e-9;
constexpr int kDirections = 36;  ///< over half a turn

/// A linear function of the coefficients [l00 l01 l10 l11 tx ty] with its limit.
struct LinearGate {
  NoticingGate gate;
  Eigen::Matrix<double, 1, 6> of;
  double limit;
};

/// The numbers that gates hold against limits, near the drawn panel; lengths in units of the noise.
std::vector<LinearGate> linear_gates(const GateLimits& limits, double noise_mm) {
  // Coefficients are in units of the noise as well.
  std::vector<LinearGate> gates;
  Eigen::Matrix<double, 1, 6> of;
  if (limits.rotation) {
    of << 0, 0, 1, 0, 0, 0;
    gates.push_back({NoticingGate::Rotation, of, limits.rotation->in_rad() / noise_mm});
  }
  if (!limits.stretch_ppm) return gates;
  const double limit = *limits.stretch_ppm * 1e-6 / noise_mm;
  of << 1, 0, 0, 0, 0, 0;
  gates.push_back({NoticingGate::Stretch, of, limit});
  of << 0, 0, 0, 1, 0, 0;
  gates.push_back({NoticingGate::Stretch, of, limit});
  of << 0, 1, 1, 0, 0, 0;
  gates.push_back({NoticingGate::Stretch, of, limit});
  return gates;
}

/// The error along a unit vector that is noticed, and by which gate.
struct Noticed {
  double from = std::numeric_limits<double>::infinity();
  NoticingGate by = NoticingGate::None;

  void take(double candidate, NoticingGate gate) {
    if (!(candidate < from)) return;
    from = candidate;
    by = gate;
  }
  /// By a number that an error of 1 moves by `shift`, with standard deviation `sigma`.
  void take_limit(double limit, double shift, double sigma, NoticingGate gate) {
    // A shift that rounding makes does not count.
    if (std::abs(shift) < kBlind * sigma) return;
    take((limit + kNoticed_sigmas * sigma) / std::abs(shift), gate);
  }
};

class Gates {
 public:
  Gates(std::span<const DesignTarget> targets,
        const PredictedFit& fit,
        double noise_mm,
        const GateLimits& limits)
      : targets_(targets), fit_(fit), linear_(linear_gates(limits, noise_mm)) {
    if (limits.false_alarm && fit.degrees_of_freedom > 0) {
      noncentrality_ =
          noticed_noncentrality(*limits.false_alarm, kNoticedShare, fit.degrees_of_freedom);
    }
    if (limits.residual) residual_ = limits.residual->in_mm() / noise_mm;
    if (limits.offset) offset_ = limits.offset->in_mm() / noise_mm;
    for (const DesignTarget& target : targets) {
      const auto jacobian = internal::design(target.nominal.in_mm());
      residual_covs_.emplace_back(target.cov - jacobian * fit.own_cov * jacobian.transpose());
      jacobians_.push_back(jacobian);
    }
    shifts_.resize(targets.size());
  }

  NoticedError of(std::size_t i) {
    weight_ = internal::weight(targets_[i]);
    gain_ = fit_.own_cov * jacobians_[i].transpose() * weight_;
    visible_ = weight_ - weight_ * jacobians_[i] * gain_;
    for (std::size_t k = 0; residual_ && k < targets_.size(); ++k) {
      shifts_[k].of = -jacobians_[k] * gain_;
      if (k == i) shifts_[k].of += Eigen::Matrix2d::Identity();
      shifts_[k].most = shifts_[k].of.norm();
    }
    NoticedError out;
    Noticed latest{.from = -1};
    for (const Eigen::Vector2d& direction : directions(targets_[i].axes)) {
      const Noticed noticed = along(i, direction);
      if (!(noticed.from > latest.from)) continue;
      latest = noticed;
      out.direction = direction;
    }
    out.by = latest.by;
    if (std::isfinite(latest.from)) out.from = latest.from;
    return out;
  }

 private:
  /// With the axes of what chi square shows least and most.
  std::vector<Eigen::Vector2d> directions(ObservedAxes axes) const {
    if (axes != ObservedAxes::Both) {
      return {Eigen::Vector2d::Unit(axes == ObservedAxes::X ? 0 : 1)};
    }
    const Eigen::Matrix2d vectors = internal::plane_eigensystem(visible_).vectors;
    std::vector<Eigen::Vector2d> out = {vectors.col(0), vectors.col(1)};
    for (int k = 0; k < kDirections; ++k) {
      const double angle = std::numbers::pi * k / kDirections;
      out.emplace_back(std::cos(angle), std::sin(angle));
    }
    return out;
  }

  Noticed along(std::size_t i, const Eigen::Vector2d& direction) const {
    Noticed out;
    const double shown = direction.dot(visible_ * direction);
    if (noncentrality_ && shown > kBlind * direction.dot(weight_ * direction)) {
      out.take(std::sqrt(*noncentrality_ / shown), NoticingGate::FalseAlarm);
    }
    const Eigen::Matrix<double, 6, 1> moved = gain_ * direction;
    for (const LinearGate& gate : linear_) {
      const double sigma =
          std::sqrt(std::max(0.0, (gate.of * fit_.own_cov * gate.of.transpose())(0)));
      out.take_limit(gate.limit, gate.of * moved, sigma, gate.gate);
    }
    if (residual_) take_residuals(i, direction, out);
    if (offset_) take_offset(direction, out);
    return out;
  }

  /// Its own residual first: others move less, and most of many cannot be noticed earlier.
  void take_residuals(std::size_t i, const Eigen::Vector2d& direction, Noticed& out) const {
    take_residual(i, direction, out);
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      if (k != i && *residual_ < shifts_[k].most * out.from) take_residual(k, direction, out);
    }
  }

  void take_residual(std::size_t k, const Eigen::Vector2d& direction, Noticed& out) const {
    const Eigen::Vector2d shift =
        internal::observed_part(shifts_[k].of * direction, targets_[k].axes);
    const double length = shift.norm();
    if (length < kBlind) return;
    const Eigen::Vector2d line = shift / length;
    const double variance = line.dot(residual_covs_[k] * line);
    out.take_limit(*residual_, length, std::sqrt(std::max(0.0, variance)), NoticingGate::Residual);
  }

  /// Of the targets' mean. What a slot does not show counts as fitted; that part is left out here,
  /// which can only make the error noticed later.
  void take_offset(const Eigen::Vector2d& direction, Noticed& out) const {
    const auto n = static_cast<double>(targets_.size());
    double variance = 0;
    for (const DesignTarget& target : targets_) {
      variance += internal::observed_part(direction, target.axes)
                      .dot(target.cov * internal::observed_part(direction, target.axes));
    }
    out.take_limit(*offset_, 1 / n, std::sqrt(variance) / n, NoticingGate::Offset);
  }

  std::span<const DesignTarget> targets_;
  const PredictedFit& fit_;
  std::vector<LinearGate> linear_;
  std::optional<double> noncentrality_;
  std::optional<double> residual_;
  std::optional<double> offset_;
  std::vector<Eigen::Matrix<double, 2, 6>> jacobians_;
  std::vector<Eigen::Matrix2d> residual_covs_;
  /// Of each target's residual by an error of the one in hand; no direction moves it by more.
  struct Shift {
    Eigen::Matrix2d of;
    double most;
  };
  std::vector<Shift> shifts_;
  Eigen::Matrix2d weight_;
  Eigen::Matrix<double, 6, 2> gain_;
  Eigen::Matrix2d visible_;
};

}  // namespace

std::string_view name(NoticingGate gate) {
  constexpr std::array<std::string_view, 6> kNames = {
      "none", "chi square", "residual", "rotation", "stretch", "offset"};
  return kNames[static_cast<std::size_t>(gate)];
}

std::vector<NoticedError> noticed_errors(std::span<const DesignTarget> targets,
                                         const PredictedFit& fit,
                                         Length noise,
                                         const GateLimits& limits) {
  Gates gates(targets, fit, noise.in_mm(), limits);
  std::vector<NoticedError> out;
  for (std::size_t i = 0; i < targets.size(); ++i) out.push_back(gates.of(i));
  return out;
}

std::size_t least_noticed(std::span<const NoticedError> errors) {
  const auto latest = std::ranges::max_element(errors, {}, [](const NoticedError& error) {
    return error.from.value_or(std::numeric_limits<double>::infinity());
  });
  return static_cast<std::size_t>(latest - errors.begin());
}

}  // namespace panelcal
