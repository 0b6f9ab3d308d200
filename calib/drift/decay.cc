// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/decay.h"

#include <algorithm>
#include <cmath>
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
/// A minimum whose sum of squares is worse by more, in units of the noise's variance, is rejected:
/// chance puts the true one so far behind another once in four hundred times.
constexpr double kNotRejected = 12;

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
    // A longer step would lead into another valley: to an alias.
    const double farthest = 0.5 / best.time_constant;
    const Decay next = project_decay(
        samples,
        values,
        best.shape,
        best.time_constant * std::exp(log_step),
        n_nonlinear > 1 ? best.frequency + std::clamp(change(1), -farthest, farthest) : 0);
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

/// The shortest time between two samples that are not of one delay: such differ by what a clock
/// rounds, far less than samples would lie apart if they were spread evenly.
double resolved_gap(const std::vector<DecaySample>& sorted) {
  constexpr double kOneDelay = 0.05;
  const double span = sorted.back().time - sorted.front().time;
  const double one_delay = kOneDelay * span / static_cast<double>(sorted.size());
  double gap = span;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double here = sorted[i].time - sorted[i - 1].time;
    if (here > one_delay) gap = std::min(gap, here);
  }
  return gap;
}

struct DecayStart {
  int i_time_constant = 0;
  double time_constant = 0;
  double frequency = 0;
  double chi_square = 0;
};

/// Minima along the frequency for every time constant of the grid, the best first. Frequencies go
/// up to half a turn between the nearest two samples; a step turns the last one that is still
/// moving by a quarter.
std::vector<DecayStart> decay_starts(const std::vector<DecaySample>& samples,
                                     const Eigen::MatrixXd& values,
                                     DecayShape shape) {
  const bool turns = shape == DecayShape::Oscillation;
  const double last = samples.back().time;
  const double span = last - samples.front().time;
  const double gap = resolved_gap(samples);
  const double shortest = 0.3 * gap;
  const double ratio = std::pow(3 * last / shortest, 1.0 / (kDecayTimeConstants - 1));
  constexpr double kMoving = 4;
  constexpr double kMostFrequencies = 2000;
  std::vector<DecayStart> starts;
  for (int i = 0; i < kDecayTimeConstants; ++i) {
    const double time_constant = shortest * std::pow(ratio, i);
    const double step = 0.5 * std::numbers::pi / std::min(span, kMoving * time_constant);
    const int n =
        turns ? static_cast<int>(std::min(kMostFrequencies, std::numbers::pi / gap / step)) : 0;
    std::vector<double> chi_square;
    for (int f = turns ? 1 : 0; f <= n; ++f) {
      chi_square.push_back(
          project_decay(samples, values, shape, time_constant, f * step).chi_square);
    }
    for (std::size_t f = 0; f < chi_square.size(); ++f) {
      const bool is_left = f == 0 || chi_square[f] <= chi_square[f - 1];
      const bool is_right = f + 1 == chi_square.size() || chi_square[f] < chi_square[f + 1];
      if (!is_left || !is_right) continue;
      const double frequency = turns ? static_cast<double>(f + 1) * step : 0;
      starts.push_back({i, time_constant, frequency, chi_square[f]});
    }
  }
  std::ranges::stable_sort(starts, {}, &DecayStart::chi_square);
  return starts;
}

/// One valley is one start: its neighbours on the grid lead to the same minimum.
bool is_one_valley(const DecayStart& a, const DecayStart& b) {
  constexpr double kQuarterTurn = 0.5 * std::numbers::pi;
  const double reach = 4 * std::max(a.time_constant, b.time_constant);
  return std::abs(a.i_time_constant - b.i_time_constant) <= 2 &&
         std::abs(a.frequency - b.frequency) * reach <= 1.5 * kQuarterTurn;
}

bool is_same_minimum(const Decay& a, const Decay& b) {
  return std::abs(std::log(a.time_constant / b.time_constant)) < 0.1 &&
         std::abs(std::abs(a.frequency) - std::abs(b.frequency)) *
                 std::max(a.time_constant, b.time_constant) <
             0.1;
}

/// Minima of the sum of squares, the lowest first.
std::vector<Decay> search(const std::vector<DecaySample>& samples,
                          const Eigen::MatrixXd& values,
                          DecayShape shape) {
  constexpr std::size_t kMostStarts = 24;
  constexpr double kBeyond = 1.05;
  const double highest = kBeyond * std::numbers::pi / resolved_gap(samples);
  std::vector<DecayStart> taken;
  std::vector<Decay> minima;
  for (const DecayStart& start : decay_starts(samples, values, shape)) {
    if (taken.size() == kMostStarts) break;
    if (std::ranges::any_of(taken, [&](const auto& t) { return is_one_valley(t, start); }))
      continue;
    taken.push_back(start);
    const Decay found =
        refine(samples,
               values,
               project_decay(samples, values, shape, start.time_constant, start.frequency));
    if (std::abs(found.frequency) > highest) continue;
    if (!std::ranges::any_of(minima, [&](const auto& m) { return is_same_minimum(m, found); })) {
      minima.push_back(found);
    }
  }
  std::ranges::stable_sort(minima, {}, &Decay::chi_square);
  if (minima.empty()) minima.push_back(project_decay(samples, values, DecayShape::Still, 1, 0));
  return minima;
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

double Decay::variance() const {
  constexpr int kFewest = 3;
  if (degrees_of_freedom < kFewest) return 1;
  return std::max(1.0, chi_square / (degrees_of_freedom - 2));
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

std::vector<Decay> fit_decays(const std::vector<DecaySample>& samples,
                              bool may_oscillate,
                              std::string* reason) {
  const auto none = [reason](std::string text) {
    if (reason != nullptr) *reason = std::move(text);
    return std::vector<Decay>();
  };
  const std::string problem = problem_with(samples);
  if (!problem.empty()) return none(problem);
  std::vector<DecaySample> sorted = samples;
  std::ranges::sort(sorted, {}, &DecaySample::time);
  const Eigen::MatrixXd values = weighted_values(sorted);
  const auto n_axes = static_cast<double>(values.cols());
  std::vector<Decay> best = {project_decay(sorted, values, DecayShape::Still, 1, 0)};
  double needed = 2 * (1 + n_axes) + kWorthExponential;
  std::vector<Decay> exponential = search(sorted, values, DecayShape::Exponential);
  if (exponential[0].chi_square + needed < best[0].chi_square) best = std::move(exponential);
  needed = 2 * (1 + n_axes) + kWorthOscillation;
  if (may_oscillate) {
    std::vector<Decay> oscillation = search(sorted, values, DecayShape::Oscillation);
    const double also = best[0].shape == DecayShape::Still ? 2 * (1 + n_axes) : 0;
    if (oscillation[0].chi_square + needed + also < best[0].chi_square) {
      best = std::move(oscillation);
    }
  }
  if (!finish_decay(sorted, best[0])) return none("the views do not determine a decay");
  const double limit = best[0].chi_square + kNotRejected * best[0].variance();
  std::vector<Decay> out;
  for (Decay& one : best) {
    if (one.chi_square <= limit && finish_decay(sorted, one)) out.push_back(std::move(one));
  }
  return out;
}

std::optional<Decay> fit_decay(const std::vector<DecaySample>& samples,
                               bool may_oscillate,
                               std::string* reason) {
  std::vector<Decay> all = fit_decays(samples, may_oscillate, reason);
  if (all.empty()) return std::nullopt;
  return std::move(all.front());
}

}  // namespace panelcal::internal
