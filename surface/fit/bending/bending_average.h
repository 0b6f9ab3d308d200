// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "surface/fit/bending/bending_likelihood.h"

// Not installed: part of surface/fit/fit.h.
namespace panelcal::internal {

/// A bending and its share of a surface.
struct BendingShare {
  Bending bending;
  double weight = 1;  ///< all together 1
};

/// Of each logarithm of a likelihood this part counts: no kernel is a board's own, so readings tell
/// kernels and lengths less well apart than the likelihood of the right one among them would. With
/// all of it 25 readings of a step choose one smooth kernel, whose heights ring.
inline constexpr double kEvidenceShare = 1.0 / 3;

/// The bendings that explain readings, each with its posterior weight: Matern 1/2, Matern 3/2 and
/// Gaussian kernels of lengths that halve from the size of the panel to a third of the readings'
/// spacing, each with its mean strength.
///
/// All are as likely before, Matern 1/2 four times: it alone has steps. The lightest are dropped, 3
/// % of the weight in all, and more where readings are many and each costs time.
///
/// In     likelihood: of the trend that all of them have in common
/// Out    heaviest first
/// Cost   O(n^3) for each kernel and length
/// Source Hoeting et al. 1999 (model averages); Bissiri, Holmes and Walker 2016 (a share of the
///        likelihood); Grunwald and van Ommen 2017 (why, if no model is true)
/// See    tests/surface/fit/bending/bending_average_test.cc
std::vector<BendingShare> bending_average(const BendingLikelihood& likelihood);

}  // namespace panelcal::internal
