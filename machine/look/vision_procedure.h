// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/vision_options.h"
#include "machine/look/picture_locator.h"
#include "machine/look/view_taker.h"
#include "program/model/measurement.h"

namespace panelcal {

/// Answers requests by looking at the panel, whatever shows it: all that recorded, simulated and
/// live pictures have in common.
///
/// One view    at the expected place.
/// Inspections ($uvis,insp) are pictures of one view. Each has to show the target. The place is the
///             one in their mean picture, with that picture's covariance: noise is averaged away in
///             it, weave is not, and the covariance of a fit knows the difference. Pictures taken
///             at different places cannot be added up; then it is the mean of the single places
///             with the covariance of one. Either is enlarged if the places scatter more than that
///             allows. The scatter is reported.
/// Four views  (G34 with a distance) see four marks around the target. Each may be searched for and
///             inspected as a target of its own; if one is not found, the target is not. Their mean
///             is the target's place. Marks that disagree are rejected.
/// Search      ($uvis,search with $uvis,searcharea or [vision] search_area_mm): if the target is
///             not in the first view, the camera walks in a spiral of overlapping views until one
///             shows it or the area is seen. The first view that shows exactly one decides. Of four
///             views the first is searched for, the others are looked for with the same shift.
/// Slots       show one coordinate; the other is answered as expected.
/// Focus       ($uvis,focus) stays for all later views.
///
/// See    tests/machine/look/vision_procedure_test.cc; docs/conventions.md
class VisionProcedure {
 public:
  /// Fails  config-value (no [camera])
  static Expected<VisionProcedure> create(const MachineConfig& config,
                                          PictureObserver observer = {});

  const PictureLocator& locator() const { return locator_; }
  /// Height that the last autofocus found; absent: the camera's focus axis is where it was.
  const std::optional<Length>& focus_z() const { return focus_z_; }

  /// Number of pictures that the answer to a request takes; absent for a search, which ends where
  /// it finds the target.
  std::optional<std::size_t> n_pictures(const MeasurementRequest& request) const;
  /// Places of a request's marks about its target, machine directions: the middle for one view,
  /// else the four places.
  std::vector<Displacement<frame::Machine>> mark_offsets(const MeasurementRequest& request) const;

  /// The looks that measure() will take at a request's target, as far as they do not depend on what
  /// earlier ones see: of a search the first.
  ///
  /// Fails  what PictureLocator::check reports
  Expected<std::vector<Look>> first_looks(const MeasurementRequest& request) const;

  /// Fails  what PictureLocator::check and PictureLocator::look report; what `taker` reports; not-
  ///        supported (a search of too many views)
  Expected<Measurement> measure(const MeasurementRequest& request, ViewTaker& taker);

  /// Empty without a focus axis.
  ///
  /// Fails  what PictureLocator::camera_of and `taker` report
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request, ViewTaker& taker);

 private:
  VisionProcedure(const MachineConfig& config, PictureLocator locator);
  /// The radius of a search; empty if there is none.
  std::optional<Length> search_area(const MeasurementRequest& request) const;
  /// The first look at a place: a view with its mark in the middle.
  Expected<Look> first_look(const MeasurementRequest& request,
                            const Position<frame::Machine>& expected,
                            int i_mark) const;
  Expected<Sight> inspect(const MeasurementRequest& request, Look look, ViewTaker& taker) const;
  Expected<Sight> search(const MeasurementRequest& request,
                         Length area,
                         Look& look,
                         ViewTaker& taker) const;
  Expected<Sight> find(const MeasurementRequest& request, Look& look, ViewTaker& taker) const;
  Expected<Measurement> measure_one(const MeasurementRequest& request, ViewTaker& taker) const;
  Expected<Measurement> measure_four(const MeasurementRequest& request, ViewTaker& taker) const;

  PictureLocator locator_;
  VisionOptions options_;
  std::optional<Length> focus_z_;  ///< of the last autofocus
};

}  // namespace panelcal
