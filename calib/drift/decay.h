// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// A value seen a time after something was disturbed.
struct DecaySample {
  double time = 0;  ///< since then, 0 or more
  Eigen::VectorXd value;
  double sigma = 0;  ///< of each axis, above 0
};

enum class DecayShape : std::uint8_t { Still, Exponential, Oscillation };

/// value(t) = rest + exp(-t / time_constant) (cosine cos(frequency t) + sine sin(frequency t))
///
/// Parameters are in the order [log time_constant, frequency, then rest, cosine and sine of each
/// axis]; an exponential has neither frequency nor sine, what is still only rest.
struct Decay {
  DecayShape shape = DecayShape::Still;
  double time_constant = 0;
  double frequency = 0;  ///< rad per unit of time
  Eigen::VectorXd rest;
  Eigen::VectorXd cosine;
  Eigen::VectorXd sine;
  Eigen::MatrixXd cov;  ///< of the parameters
  double chi_square = 0;
  int degrees_of_freedom = 0;

  /// No axis, nor all of them together, are farther from rest than this at time 0.
  double amplitude() const;
  /// By how much the samples scatter more than their sigmas, squared and counted as one who
  /// estimates it has to (nu / (nu - 2)); 1 where they do not.
  double variance() const;
};

/// Time from which |value - rest| stays below a limit, with one standard deviation.
struct DecayTime {
  double time = 0;
  double sigma = 0;
};

/// From the envelope: time_constant log(amplitude / limit), 0 if that is negative.
DecayTime time_to(const Decay& decay, double limit);

/// Fits the decays that explain the samples, or says that they stand still.
///
/// For a time constant and a frequency the rest is linear (variable projection, Golub and Pereyra
/// 1973), so both are searched for on a grid, frequencies up to half a turn between the nearest two
/// samples, and from every valley of it all parameters are refined together (Levenberg and
/// Marquardt). An exponential has to be better than standing still, and an oscillation than that,
/// by what chance would gain in that number of trials. Of one shape all minima are returned that
/// the samples do not reject: a swing that is sampled seldom has aliases.
///
/// In     samples: 6 or more at different times, any order, one size of value; finite
/// Out    the best first; empty: `reason` says why
/// Cost   36 samples of two axes: 0.1 s
/// Source Golub and Pereyra 1973
std::vector<Decay> fit_decays(const std::vector<DecaySample>& samples,
                              bool may_oscillate,
                              std::string* reason);

/// The best of them.
std::optional<Decay> fit_decay(const std::vector<DecaySample>& samples,
                               bool may_oscillate,
                               std::string* reason);

}  // namespace panelcal::internal
