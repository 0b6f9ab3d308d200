// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/correction/tolerance.h"
#include "program/model/operation.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

/// Excess of a tool's depth over the wanted one at a place: normal, of this mean and sigma.
struct DepthError {
  Length mean;
  Length sigma;
  // Sigma has these independent errors.
  Length map_sigma;        ///< of the surface at the place
  Length reference_sigma;  ///< and where a plane's reference was measured
  Length machine_sigma;    ///< [uncertainty] depth_um
  /// Of a machine with several Z axes the one that this is about, from 0.
  std::optional<std::size_t> axis = std::nullopt;
};

/// `12.0 um too shallow if the map is right, sigma 3.1 um`, and the axis if there are several.
std::string error_text(const DepthError& error);

/// That a depth breaks its tolerance to either side.
struct DepthRisk {
  double too_shallow = 0;
  double too_deep = 0;

  double either() const { return too_shallow + too_deep; }
};
DepthRisk depth_risk(const DepthError& error, const DepthTolerance& tolerance);

/// Errors of depths, as far as they are known.
///
/// The machine's commands count on a height of the surface: one that was probed once for many
/// strokes, a grid's, interpolated, or a map's. The map says how high the surface really is and how
/// sure that is, so
///
///   deeper = surface of the map - surface counted on + e,   e ~ N(0, map^2 + depth^2)
///
/// with the map's sigma at that place and [uncertainty] depth_um. A plane that follows a grid
/// counts from a reference (G78), which is measured like any probe: what it is off is taken away,
/// and its sigma added, as if both were independent; they are not, so the sum is the larger of what
/// it may be. A stroke at which the machine finds the surface by itself is wrong by depth_um alone.
///
/// Every Z axis has a map of its own, for its own probe counts on it.
///
/// See    tests/program/judge/depth_errors_test.cc; docs/formulation.md
class DepthErrors {
 public:
  /// In     depth_sigma: [uncertainty] depth_um
  ///        maps: of the surface, one for each Z axis, or why there is none
  ///        finds_surface: false: the output is for a machine that cannot, so that it is unknown
  ///        how wrong a depth is that counts on no measured height
  /// Precondition: at least one map
  DepthErrors(Length depth_sigma, std::vector<Expected<ZonedMap>> maps, bool finds_surface = true)
      : depth_sigma_(depth_sigma), maps_(std::move(maps)), finds_surface_(finds_surface) {}

  Length depth_sigma() const { return depth_sigma_; }
  std::span<const Expected<ZonedMap>> maps() const { return maps_; }

  /// On the axis that is likeliest to break the tolerance; empty where it is unknown, if only of
  /// one axis, and for planes above the table that no probe has moved: their depth is not stated.
  std::optional<DepthError> worst_at(const Position<frame::Nominal>& place,
                                     const DepthOfCut& cut,
                                     const DepthTolerance& tolerance) const;

 private:
  std::optional<DepthError> at(const Position<frame::Nominal>& place,
                               const DepthOfCut& cut,
                               std::size_t axis) const;

  Length depth_sigma_;
  std::vector<Expected<ZonedMap>> maps_;
  bool finds_surface_;
};

/// The tolerance of a depth, and its sigma.
struct JudgedDepth {
  DepthTolerance tolerance;
  DepthError error;
  DepthRisk risk;
};

/// Knows the tools of a job as it passes, and what [tolerance] asks of their depths.
class DepthJudge {
 public:
  DepthJudge(Tolerances tolerances, DepthErrors errors)
      : tolerances_(std::move(tolerances)), errors_(std::move(errors)) {}

  void begin(const ProgramInfo& info) { tools_ = info.tools; }
  void take(const ToolChange& change) {
    if (change.tool.number > 0) tools_[change.tool.number] = change.tool;
  }

  const Tolerances& tolerances() const { return tolerances_; }
  const DepthErrors& errors() const { return errors_; }
  /// Empty where nothing is asked of the tool, or it works to no depth.
  DepthTolerance tolerance_of(int tool, const DepthOfCut& cut) const;
  /// Absent where nothing is asked, and where it is unknown.
  std::optional<JudgedDepth> judge(int tool,
                                   const Position<frame::Nominal>& place,
                                   const DepthOfCut& cut) const;
  /// The same of a hole, or of where a line or an arc ends; tools that pass are remembered.
  std::optional<JudgedDepth> judge(const Operation& operation);

 private:
  Tolerances tolerances_;
  DepthErrors errors_;
  std::map<int, Tool> tools_;
};

}  // namespace panelcal
