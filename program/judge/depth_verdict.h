// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "calib/correction/tolerance.h"
#include "program/judge/depth_errors.h"
#include "program/judge/job_decision.h"
#include "program/model/operation.h"
#include "surface/map/height_map.h"

namespace panelcal {

/// Holds the depths of a job against [tolerance] as it passes: of every hole, slot and contour that
/// works to a depth below the board's surface. Slots and contours are looked at all along their way
/// and count once each, by their worst place. Memory does not grow with the job.
///
/// DepthErrors give the error of each; of several Z axes the one counts that is likeliest to break
/// the tolerance. Planes above the table that no probe has moved are not judged.
///
/// A probe that does not fit the others is not in the map, but what the machine is told may count
/// on it: the places about it break their tolerance.
///
/// See    tests/program/judge/depth_verdict_test.cc, depth_verdict_slow_test.cc;
/// docs/formulation.md
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

  DepthVerdict(const Tolerances& tolerances, DepthErrors errors)
      : judge_(tolerances, std::move(errors)) {}
  /// Of a machine with one Z axis.
  DepthVerdict(const Tolerances& tolerances, Length depth_sigma, const Expected<ZonedMap>& map)
      : DepthVerdict(tolerances, DepthErrors(depth_sigma, {map})) {}
  DepthVerdict(const DepthVerdict&) = delete;
  DepthVerdict& operator=(const DepthVerdict&) = delete;

  void begin(const ProgramInfo& info) override { judge_.begin(info); }
  void put(const Operation& operation) override;

  const Tolerances& tolerances() const { return judge_.tolerances(); }
  const DepthErrors& errors() const { return judge_.errors(); }
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
  /// A thing that counts once: a hole, a slot, or a contour from where the router goes down.
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
  ToolFigures& figures(int tool, const DepthTolerance& tolerance);

  DepthJudge judge_;
  std::map<int, ToolFigures> by_tool_;
  // Place and depth of the router, and its contour since it went down.
  PlacedPoint router_;
  DepthOfCut router_cut_;
  Counted contour_;
};

}  // namespace panelcal
