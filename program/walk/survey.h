// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "calib/correction/stack.h"
#include "calib/faults/series_fault.h"
#include "calib/panel/panel_fit.h"
#include "calib/panel/reliability.h"
#include "program/model/measurement.h"
#include "program/model/operation.h"
#include "program/walk/probing.h"
#include "program/walk/series_assignment.h"

namespace panelcal {

/// One series of targets, the fit that came of it, and its summary.
struct SeriesResult : PanelFitSummary {
  CorrectionLevel level = CorrectionLevel::Base;
  int line = 0;  ///< of the first target
  InstancePath path;
  Placement placement;                    ///< of the instance it was measured on
  std::vector<std::size_t> measurements;  ///< indices into Survey::measurements
  /// The measurement that names each point of the fit, whose residuals are in this order: one of
  /// `measurements` each, but of several layers of a target only the last.
  std::vector<std::size_t> points;
  PanelModel prescribed = PanelModel::Offset;  ///< by the manual or the machine's file
  std::shared_ptr<const BaseFit> base;         ///< set for a fitted base series
  std::shared_ptr<const NestedFit> nested;     ///< set for a fitted nested series
  std::optional<std::size_t> base_series;      ///< the base correction a nested one is relative to
  GateLimits limits;                 ///< of the fit, with its share of the job's false alarms
  std::optional<SeriesFault> fault;  ///< if the targets do not fit each other
  /// Errors that the targets would not show of each other; null without a fit.
  std::shared_ptr<const Reliability> reliability;
  /// Measurements that [gates] max_dropped allowed to leave out; they are not among `points`.
  std::vector<std::size_t> dropped;
  /// A person has left out its board, which is neither fitted nor worked.
  bool is_left_out = false;
  /// If pictures had several candidates: which were taken, or why none was.
  std::optional<SeriesAssignment> assignment;
  /// Greatest distance of the layers of one target (SIEB & MEYER, measurement modes 2 and 3).
  std::optional<Length> layer_spread;

  bool is_fitted() const { return base != nullptr || nested != nullptr; }
  bool is_accepted() const;
};

/// A node of a probed grid whose height the other nodes predict.
struct FilledNode {
  int line = 0;  ///< of the grid's first use
  Position<frame::Nominal> place;
  std::vector<HeightEstimate> heights;  ///< one per Z axis
  HeightSource source;
};

/// The result of the measuring walk: everything the working walk and a report need.
struct Survey {
  std::vector<Measurement> measurements;
  std::vector<SeriesResult> series;
  std::vector<ProbeReading> probes;
  /// Nodes of a G79 grid that are not probed, as [surface] fill_gaps allows.
  std::vector<FilledNode> filled_nodes;
  std::vector<FocusResult> focus;  ///< results of autofocus orders, in the order of execution
  /// The results of orders to calibrate, in the order of execution; those that were not performed
  /// are not here.
  std::vector<CalibrationAnswer> calibrations;
  /// Files and lines of orders to calibrate or to focus that were not performed.
  std::set<std::pair<std::string, int>> unperformed;
  /// The source failed: nothing is known of what the program asks for behind it.
  bool was_stopped = false;

  /// Every series is fitted or of a board that is left out, so that a corrected program could be
  /// written at all. A target that a person has skipped is missing from its series' fit only.
  bool is_complete() const;
  /// Every series is fitted and inside its limits, and every measured hole was found.
  bool is_accepted() const;

  /// Boards that persons have left out, each by its first series.
  std::vector<const SeriesResult*> left_out_boards() const;

  /// Default gates that are off: "residual", "mirror of nested fits"; an ungated offset over 10 mm.
  std::vector<std::string> gates_off() const;

  /// The calibration of this job that a measurement was made with; null: the machine's own.
  const CalibrationAnswer* calibration_of(std::size_t i_measurement) const;
  /// Of the last one of a series, which is made with one calibration.
  const CalibrationAnswer* calibration_of(const SeriesResult& one_series) const;
};

/// The uncertainty of the offset that measurements were made with: of a calibration of this job,
/// which has not drifted yet, or else the machine's own.
OffsetUncertainty offset_uncertainty(const CalibrationAnswer* calibration,
                                     const MachineUncertainty& machine);

/// Measurements and calibrations, a line each, in the order in which they were made: what a run is
/// replayed from.
std::string measurement_lines(const Survey& survey);

}  // namespace panelcal
