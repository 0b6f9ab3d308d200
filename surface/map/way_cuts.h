// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"

namespace panelcal {

/// A profile has no more samples than this, however fine the tolerance.
inline constexpr std::size_t kMostWaySamples = 4096;

/// The fewest chords between samples of a profile that keep within the tolerance at all samples.
///
/// From each sample, the slopes of chords that pass all samples so far are an interval, which only
/// shrinks; the fewest pieces to each sample follow by dynamic programming. Of equally few the last
/// piece is the longest.
///
/// In     heights_mm: at even steps
/// Out    the samples to cut at, rising, without the first and the last
/// Cost   O(n^2) at worst, O(n) times the samples of a piece
/// Source Imai and Iri 1986
/// See    tests/surface/map/way_cuts_test.cc
std::vector<std::size_t> fewest_cuts(std::span<const double> heights_mm, Length tolerance);

/// Number of samples that a way over a surface of such cells begins with, so that no bend is
/// overlooked.
std::size_t way_samples(double length_mm, Length cell);

/// Parameters at which a way over a surface must be cut, so that a tool that goes evenly from the
/// height at one cut to that at the next stays within `tolerance` of the surface.
///
/// The profile is sampled ever finer until what a smooth surface can do between two samples, a
/// quarter of the largest second difference (twice its bound), is a fiftieth of the tolerance or
/// less; the cuts keep to the rest. A piece then has some eight samples or more.
///
/// In     profile_mm: heights at n + 1 even steps, the first and the last place included
///        least_samples: the first n, fine enough to see every bend of the surface
/// Out    rising parameters t, 0 < t < 1
/// Fails  as `profile_mm`; argument-invalid: kMostWaySamples are not enough
Expected<std::vector<double>> way_cuts(
    const std::function<Expected<std::vector<double>>(std::size_t n)>& profile_mm,
    std::size_t least_samples,
    Length tolerance);

}  // namespace panelcal
