// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "calib/base/units.h"
#include "surface/fit/probe_point.h"

// Not installed: part of surface/fit/outliers.h.
namespace panelcal::internal {

/// Result of a search among few probes.
struct WildProbe {
  std::optional<std::size_t> i_worst;  ///< the likeliest to be wild; empty: none can be judged
  Length deviation;                    ///< of it, measured minus predicted by the others
  bool is_found = false;               ///< it is wild
  bool is_doubtful = false;            ///< not found, but one may be there all the same
};

/// Leaves each of few probes out and compares two explanations of its height: the board bends as
/// the others let expect, or the probe is wild.
///
///   odds_i = p_wild / (1 - p_wild) 1 / (2 |d_i| ln 1000) / t(d_i; nu, sigma_i)
///
/// d_i is its deviation from what the others predict, sigma_i that of it. The board's bending is
/// known from the others' nu contrasts alone, so that Student's t has their tails: of 9 probes a
/// dome's middle and a wild probe look alike until the deviation is gross. A wild probe's deviation
/// may have any size within three decades. A probe is found if the odds that it is the only wild
/// one are above 20; odds above 1/2 in all without such a probe are a doubt.
///
/// Cost   a Gaussian process for each probe
/// Source Box and Tiao 1968 (odds of a bad value)
/// See    tests/surface/fit/outliers_test.cc
WildProbe wild_probe(std::span<const ProbePoint> points);

}  // namespace panelcal::internal
