// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace panelcal {

/// A probability as a sum of normal ones, of a value whose sigma is itself uncertain.
struct NormalMixture {
  struct Part {
    double weight = 0;
    double mean = 0;
    double variance = 0;
  };
  std::vector<Part> parts;  ///< weights add up to 1

  double mean() const;
  double variance() const;
  /// The score that a value has among these: normal_score of its two tails.
  double score(double value) const;
  /// The same with at most n parts, by groups of about equal weight in the order of their
  /// variances, each with the mean and variance of its group.
  NormalMixture condensed(int n) const;
};

}  // namespace panelcal
