// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/decay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::size_t kMinTimes = 6;
/// By how much 2 log likelihood has to grow for a softer shape, beyond twice its parameters: chance
/// gains as much as twice the logarithm of the number of time constants and frequencies that
/// differ.
constexpr double kWorthExponential = 10;
constexpr double kWorthOscillation = 20;
constexpr int kDecayTimeConstants = 40;

int columns_of(DecayShape shape) {
  return shape == DecayShape::Still ? 1 : shape == DecayShape::Exponential ? 2 : 3;
}

int nonlinear_of(DecayShape shape) {
  return columns_of(shape) - 1;
}

/// Weighted columns of the linear part.
Eigen::MatrixXd columns(const std::vector<DecaySample>& samples,
                        DecayShape shape,
                        double time_constant,
                        double frequency) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(samples.size()), columns_of(shape));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double w = 1 / samples[i].sigma;
    const double t = samples[i].time;
    out(row, 0) = w;
    if (shape == DecayShape::Still) continue;
    const double left = w * std::exp(-t / time_constant);
    out(row, 1) = left * std::cos(frequency * t);
    if (shape == DecayShape::Oscillation) out(row, 2) = left * std::sin(frequency * t);
  }
  return out;
}

Eigen::MatrixXd weighted_values(const std::vector<DecaySample>& samples) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(samples.size()), samples[0].value.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    out.row(static_cast<Eigen::Index>(i)) = samples[i].value.transpose() / samples[i].sigma;
  }
  return out;
}

/// The linear part's best answer for this time constant and frequency.
Decay project_decay(const std::vector<DecaySample>& samples,
                    const Eigen::MatrixXd& values,
                    DecayShape shape,
                    double time_constant,
                    double frequency) {
  const Eigen::MatrixXd a = columns(samples, shape, time_constant, frequency);
  const Eigen::MatrixXd x = internal::solve_least_squares(a, values);
  Decay out;
  out.shape = shape;
  out.time_constant = time_constant;
  out.frequency = frequency;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(values.cols());
  out.rest = x.row(0);
  out.cosine = shape == DecayShape::Still ? zero : Eigen::VectorXd(x.row(1));
  out.sine = shape == DecayShape::Oscillation ? Eigen::VectorXd(x.row(2)) : zero;
  out.chi_square = (values - a * x).squaredNorm();
  return out;
}

/// Weighted derivatives by all parameters; rows by sample, then axis.
Eigen::MatrixXd jacobian(const std::vector<DecaySample>& samples, const Decay& d) {
  const Eigen::Index n_axes = d.rest.size();
  const int n_nonlinear = nonlinear_of(d.shape);
  const int n_columns = columns_of(d.shape);
  const auto n = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(n * n_axes, n_nonlinear + n_columns * n_axes);
  const Eigen::MatrixXd linear = columns(samples, d.shape, d.time_constant, d.frequency);
  for (Eigen::Index i = 0; i < n; ++i) {
    const DecaySample& s = samples[static_cast<std::size_t>(i)];
    const double left = std::exp(-s.time / d.time_constant) / s.sigma;
    const double c = std::cos(d.frequency * s.time);
    const double b = std::sin(d.frequency * s.time);
    for (Eigen::Index k = 0; k < n_axes; ++k) {
      const Eigen::Index row = i * n_axes + k;
      if (n_nonlinear > 0) {
        out(row, 0) = left * s.time / d.time_constant * (d.cosine(k) * c + d.sine(k) * b);
      }
      if (n_nonlinear > 1) out(row, 1) = left * s.time * (d.sine(k) * c - d.cosine(k) * b);
      out.block(row, n_nonlinear + k * n_columns, 1, n_columns) = linear.row(i);
    }
  }
  return out;
}

Eigen::VectorXd residuals(const std::vector<DecaySample>& samples,
                          const Eigen::MatrixXd& values,
                          const Decay& d) {
  const Eigen::MatrixXd a = columns(samples, d.shape, d.time_constant, d.frequency);
  Eigen::MatrixXd x(a.cols(), values.cols());
  x.row(0) = d.rest;
  if (x.rows() > 1) x.row(1) = d.cosine;
  if (x.rows() > 2) x.row(2) = d.sine;
  const Eigen::MatrixXd left = (values - a * x).transpose();
  return Eigen::Map<const Eigen::VectorXd>(left.data(), left.size());
}

/// Refines time constant and frequency; the linear part is projected anew in every step.
Decay refine(const std::vector<DecaySample>& samples, const Eigen::MatrixXd& values, Decay best) {
  constexpr int kSteps = 60;
  constexpr double kEnough = 1e-10;
  double damping = 1e-3;
  const int n_nonlinear = nonlinear_of(best.shape);
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::MatrixXd j = jacobian(samples, best);
    Eigen::MatrixXd normal = j.transpose() * j;
    const Eigen::VectorXd right = j.transpose() * residuals(samples, values, best);
    normal.diagonal() *= 1 + damping;
    const Eigen::VectorXd change = internal::solve_symmetric(normal, right);
    if (!change.allFinite()) break;
    const double log_step = std::clamp(change(0), -1.0, 1.0);
    const Decay next = project_decay(samples,
                                     values,
                                     best.shape,
                                     best.time_constant * std::exp(log_step),
                                     n_nonlinear > 1 ? best.frequency + change(1) : 0);
    if (next.chi_square < best.chi_square) {
      const double gain = best.chi_square - next.chi_square;
      best = next;
      damping *= 0.1;
      if (gain < kEnough) break;
    } else {
      damping *= 10;
      if (damping > 1e10) break;
    }
  }
  return best;
}

Decay search(const std::vector<DecaySample>& samples,
             const Eigen::MatrixXd& values,
             DecayShape shape) {
  const double last = samples.back().time;
  double gap = last;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double here = samples[i].time - samples[i - 1].time;
    if (here > 0) gap = std::min(gap, here);
  }
  const double span = last - samples.front().time;
  const bool turns = shape == DecayShape::Oscillation;
  // Up to half a turn between the nearest two samples; a step turns the last one by a quarter.
  constexpr double kMostFrequencies = 500;  // as of 250 samples
  const double step = 0.5 * std::numbers::pi / span;
  const int n_frequencies =
      turns ? static_cast<int>(std::min(kMostFrequencies, std::numbers::pi / gap / step)) : 1;
  Decay best;
  best.chi_square = std::numeric_limits<double>::infinity();
  const double shortest = 0.3 * gap;
  const double ratio = std::pow(3 * last / shortest, 1.0 / (kDecayTimeConstants - 1));
  for (int i = 0; i < kDecayTimeConstants; ++i) {
    for (int f = 1; f <= n_frequencies; ++f) {
      const Decay d = project_decay(
          samples, values, shape, shortest * std::pow(ratio, i), turns ? f * step : 0);
      if (d.chi_square < best.chi_square) best = d;
    }
  }
  return refine(samples, values, best);
}

/// False if some parameter is left open.
bool finish_decay(const std::vector<DecaySample>& samples, Decay& d) {
  const Eigen::MatrixXd j = jacobian(samples, d);
  // Scaled, since parameters have units of their own.
  const Eigen::VectorXd scale = j.colwise().norm();
  if (!(scale.minCoeff() > 0)) return false;
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  const Eigen::MatrixXd scaled = j * inverse.asDiagonal();
  const internal::Cholesky solver(scaled.transpose() * scaled);
  constexpr double kOpen = 1e-12;
  if (!solver.is_definite() || !(solver.rcond() > kOpen)) return false;
  d.cov = inverse.asDiagonal() * solver.inverse() * inverse.asDiagonal();
  d.degrees_of_freedom = static_cast<int>(j.rows() - j.cols());
  return true;
}

std::string problem_with(const std::vector<DecaySample>& samples) {
  std::set<double> times;
  for (const DecaySample& s : samples) {
    const bool is_good = std::isfinite(s.time) && s.time >= 0 && std::isfinite(s.sigma) &&
                         s.sigma > 0 && s.value.size() > 0 && s.value.allFinite() &&
                         s.value.size() == samples[0].value.size();
    if (!is_good) return "a view is no number, has no sigma or is from before the move";
    times.insert(s.time);
  }
  if (times.size() >= kMinTimes) return "";
  return fmt::format("{} times are too few for a curve, {} are needed", times.size(), kMinTimes);
}

}  // namespace

double Decay::amplitude() const {
  return std::sqrt(cosine.squaredNorm() + sine.squaredNorm());
}

DecayTime time_to(const Decay& decay, double limit) {
  const double amplitude = decay.amplitude();
  if (decay.shape == DecayShape::Still || !(amplitude > limit)) return {};
  const double time = decay.time_constant * std::log(amplitude / limit);
  // d time / d (log time constant) = time; / d cosine = time_constant cosine / amplitude^2
  const int n_nonlinear = nonlinear_of(decay.shape);
  const int n_columns = columns_of(decay.shape);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(decay.cov.rows());
  gradient(0) = time;
  const double by_amplitude = decay.time_constant / (amplitude * amplitude);
  for (Eigen::Index k = 0; k < decay.rest.size(); ++k) {
    const Eigen::Index first = n_nonlinear + k * n_columns;
    gradient(first + 1) = by_amplitude * decay.cosine(k);
    if (n_columns > 2) gradient(first + 2) = by_amplitude * decay.sine(k);
  }
  return {time, std::sqrt(gradient.dot(decay.cov * gradient))};
}

std::optional<Decay> fit_decay(const std::vector<DecaySample>& samples,
                               bool may_oscillate,
                               std::string* reason) {
  const auto none = [reason](std::string text) {
    if (reason != nullptr) *reason = std::move(text);
    return std::nullopt;
  };
  const std::string problem = problem_with(samples);
  if (!problem.empty()) return none(problem);
  std::vector<DecaySample> sorted = samples;
  std::ranges::sort(sorted, {}, &DecaySample::time);
  const Eigen::MatrixXd values = weighted_values(sorted);
  const auto n_axes = static_cast<double>(values.cols());
  Decay best = project_decay(sorted, values, DecayShape::Still, 1, 0);
  double needed = 2 * (1 + n_axes) + kWorthExponential;
  Decay exponential = search(sorted, values, DecayShape::Exponential);
  if (exponential.chi_square + needed < best.chi_square) best = exponential;
  needed = 2 * (1 + n_axes) + kWorthOscillation;
  if (may_oscillate) {
    Decay oscillation = search(sorted, values, DecayShape::Oscillation);
    const double also = best.shape == DecayShape::Still ? 2 * (1 + n_axes) : 0;
    if (oscillation.chi_square + needed + also < best.chi_square) best = oscillation;
  }
  if (!finish_decay(sorted, best)) return none("the views do not determine a decay");
  return best;
}

}  // namespace panelcal::internal
