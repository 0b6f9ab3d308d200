// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "panelcal/calib/base/diagnostic.h"
#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/tolerance.h"
#include "panelcal/program/job_decision.h"
#include "panelcal/program/operation.h"
#include "panelcal/surface/height_map.h"

namespace panelcal {

/// How much deeper than wanted a tool works at a place: normal, of this mean and sigma.
struct DepthError {
  Length mean;
  Length sigma;
};

/// That a depth breaks its tolerance to either side.
struct DepthRisk {
  double too_shallow = 0;
  double too_deep = 0;

  double either() const { return too_shallow + too_deep; }
};
DepthRisk depth_risk(const DepthError& error, const DepthTolerance& tolerance);

/// Holds the depths of a job against [tolerance] as it passes: of every hole, slot and contour that
/// works to a depth below the board's surface. Slots and contours are looked at all along their way
/// and count once each, by their worst place. Memory does not grow with the job.
///
/// What the machine is told counts on a height of the surface: one that was probed once for many
/// strokes, or a grid's, interpolated. The map of all probes says how high the surface really is
/// and how sure that is, so
///
///   deeper = surface of the map - surface counted on + e,   e ~ N(0, map^2 + depth^2)
///
/// with the map's sigma at that place and [uncertainty] depth_um. A plane that follows a grid
/// counts from a reference (G78), which is measured like any probe: what it is off is taken away,
/// and its sigma added, as if both were independent; they are not, so the sum is the larger of what
/// it may be. A stroke at which the machine finds the surface by itself is wrong by depth_um alone.
/// Planes above the table that no probe has moved are not judged: nobody says how deep they are
/// meant to be. Of several Z axes the first is judged.
///
/// A probe that does not fit the others is not in the map, but what the machine is told may count
/// on it: the places about it break their tolerance.
///
/// See    tests/program/depth_verdict_test.cc, depth_verdict_slow_test.cc; docs/formulation.md
class DepthVerdict final : public OperationSink {
 public:
  struct WorstPlace {
    int line = 0;
    std::string file;  ///< of a stored pattern; empty: the program itself
    InstancePath path;
    Position<frame::Nominal> nominal;
    DepthError error;
    DepthTolerance tolerance;
    DepthRisk risk;
  };

  struct ToolFigures {
    DepthTolerance tolerance;
    JudgedPlaces places;
    double expected_too_shallow = 0;  ///< sum of the risks
    double expected_too_deep = 0;
    Length largest_mean;   ///< of errors' means, by size
    Length largest_sigma;  ///< of errors
    WorstPlace worst;      ///< the likeliest to break, if places.n_judged > 0
  };

  /// In     depth_sigma: [uncertainty] depth_um
  ///        map: of the surface, or why there is none
  DepthVerdict(const Tolerances& tolerances, Length depth_sigma, Expected<HeightMap> map);
  DepthVerdict(const DepthVerdict&) = delete;
  DepthVerdict& operator=(const DepthVerdict&) = delete;

  void begin(const ProgramInfo& info) override { tools_ = info.tools; }
  void put(const Operation& operation) override;

  const Tolerances& tolerances() const { return tolerances_; }
  const Expected<HeightMap>& map() const { return map_; }
  Length depth_sigma() const { return depth_sigma_; }
  /// Tools that work to a depth and have a tolerance for it.
  const std::map<int, ToolFigures>& by_tool() const { return by_tool_; }
  JudgedPlaces places() const;
  /// Null if nothing was judged.
  const ToolFigures* worst_tool() const;
  JobDecision decision() const { return decide(places()); }
  /// One line for people: "hold: ...".
  std::string sentence() const;
  /// tolerance-hold and tolerance-warning: one a tool, with its worst place.
  void report(const std::string& file, DiagnosticLog& log) const;

 private:
  /// What counts once: a hole, a slot, or a contour from where the router goes down.
  struct Counted {
    bool is_judged = false;
    bool is_unjudged = false;  ///< a part of it
    DepthRisk risk;            ///< of its worst place
  };

  void add(Counted& counted,
           const Operation& operation,
           int tool,
           const Position<frame::Nominal>& place,
           const DepthOfCut& cut);
  void add_way(Counted& counted, const Operation& operation, const Rout& rout);
  void add_line(Counted& counted, const Operation& operation, const Slot& slot);
  void count(ToolFigures& tool, const DepthRisk& risk, int sign) const;
  int n_samples(double length_mm) const;
  std::optional<DepthError> error_at(const Position<frame::Nominal>& place,
                                     const DepthOfCut& cut) const;
  ToolFigures& figures(int tool, const DepthTolerance& tolerance);

  Tolerances tolerances_;
  Length depth_sigma_;
  Expected<HeightMap> map_;
  std::map<int, Tool> tools_;
  std::map<int, ToolFigures> by_tool_;
  // Where the router stands, how deep, and what it has routed since it went down.
  PlacedPoint router_;
  DepthOfCut router_cut_;
  Counted contour_;
};

}  // namespace panelcal
