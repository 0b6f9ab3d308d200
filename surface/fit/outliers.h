// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "surface/fit/fit.h"

namespace panelcal {

/// A probe's name, else `probe at (x, y)`.
std::string name_of(const ProbePoint& point);

/// A probe that does not belong to the surface the others make.
struct SurfaceOutlier {
  std::size_t i_point = 0;
  std::string name;   ///< name_of() the probe
  Length deviation;   ///< measured minus what the others predict
  Length sigma;       ///< of that for a good probe
  double chance = 0;  ///< that a good probe deviates more

  /// `column 3 row 4 is 0.512 mm above what the others predict, 160 sigma`
  std::string text() const;
};

/// A surface of the probes that fit each other.
struct SoundSurface {
  SurfaceFit fit;
  std::vector<std::size_t> kept;         ///< indices, rising
  std::vector<SurfaceOutlier> outliers;  ///< in the order of the probes
  std::string doubt =
      {};  ///< that few probes cannot tell a wild one from a bend; empty: none shows
};

struct OutlierOptions {
  /// The chance that of good probes any is called an outlier. Smaller ones overlook smaller errors.
  double false_alarm = 0.01;
  /// If more of the probes than this do not fit the others, it is not known which are right.
  double most = 0.25;
  /// Probes that are off the surface by more than this multiple of their sigma make none; nor do
  /// probes of which that holds for a plane, if nothing else predicts them better.
  double most_noise = 10;

  /// Fails  config-value
  Expected<void> validate() const;
};

/// The bends that these outliers may show; none of more than kFewProbes, which judge them, and none
/// where a kept probe stands at the same place.
///
/// In     points: those that the outliers are indices of; kept: 1 or more indices
std::vector<PossibleBend> possible_bends(std::span<const ProbePoint> points,
                                         std::span<const std::size_t> kept,
                                         std::span<const SurfaceOutlier> outliers);

/// Fits a surface to the probes that fit each other, and names the others.
///
/// First the probe that deviates most from what the others predict is set aside, one at a time,
/// while it does so by the scatter of the better half, or by what the probes say if that is more:
/// of many wild probes none hides another, for the median does not see them. A thin plate does for
/// this search, as it has no length that wild probes could spoil. Then the model itself judges: a
/// probe is an outlier if, left out, it deviates by more than one of n good ones does with the
/// chance false_alarm / n (Bonferroni); whatever was set aside and does not, is taken back.
///
/// Up to 15 probes have no better half: of bent models each probe is judged by all the others
/// (surface/fit/wild_probe.h). They cannot tell a wild one from a bend of the board, and the result
/// says so: sigma about one that is left out, of any model, has the bend that it may show
/// (surface/fit/possible_bend.h); where a kept one is suspected, every sigma has its deviation.
///
/// A third of wild probes all over the panel cannot be told from a surface that is rougher than the
/// probes are dense: refused is one that predicts probes left out hardly better than a plane does,
/// if they scatter about that by more than `most_noise`.
///
/// Grid models need every probe: there a thin plate judges, and if it names an outlier the grid has
/// none for that node.
///
/// Of more than kMostProbes the search, and what judges a grid, sees about 100 neighbours at a
/// time.
///
/// Fails  as fit_surface() and OutlierOptions::validate(); grid-invalid: a grid model with
///        outliers; surface-out-of-tolerance: more than `most` of the probes, or of such
///        neighbours, do not fit, or fewer than 5 would be left; the others scatter
///        more than `most_noise` times what they say, or make no surface
/// Cost   a thin plate for each probe set aside, O(m^3) of m probes or neighbours; then some fits
/// Source Hadi and Simonoff 1993 (a clean part judges the rest); Rasmussen and Williams 2006, 5.4.2
/// See    tests/surface/fit/outliers_test.cc
Expected<SoundSurface> fit_without_outliers(std::span<const ProbePoint> points,
                                            SurfaceModel model,
                                            const OutlierOptions& options = {});

}  // namespace panelcal
