// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/diagnostic.h"
#include "calib/correction/breaking_probability.h"
#include "calib/correction/tolerance.h"
#include "program/judge/job_decision.h"
#include "program/judge/place_budget.h"
#include "program/judge/risk_basis.h"
#include "program/model/operation.h"

namespace panelcal {

/// Distances from the right place: what people of this trade sum up a drilled panel by.
struct RadialFigures {
  std::int64_t n = 0;
  double sum_mm = 0;
  double sum_squares_mm2 = 0;

  Length mean() const;
  /// Over the places and over what may happen at each.
  Length deviation() const;
  Length mean_plus_3_sigma() const { return mean() + 3 * deviation(); }
  /// (tolerance - mean) / (3 deviation): the one-sided index, since a distance has no lower limit.
  /// A radial error is not normal, so this is the trade's figure and no probability. Absent without
  /// scatter.
  ///
  /// Source Montgomery, Introduction to Statistical Quality Control, process capability ratios
  std::optional<double> cpk(Length tolerance) const;
};

/// Holds every place that a tool works at against [tolerance] as a job passes: holes, ends of
/// slots, corners of routs and where they begin. Memory does not grow with the job.
///
/// Errors of one job are correlated, since all places share its fits; means, expected numbers and
/// risks are the same with and without correlation. (What correlation does: the broken holes come
/// together or not at all.)
///
/// See    tests/program/judge/job_verdict_test.cc; docs/formulation.md
class JobVerdict final : public OperationSink {
 public:
  struct WorstPlace {
    int line = 0;
    std::string file;  ///< of a stored pattern; empty: the program itself
    InstancePath path;
    Position<frame::Nominal> nominal;
    double risk = 0;  ///< that [tolerance] is held against (PlacedPoint::judged_risk)
    /// Of a hole, as `run --explain` counts places: from 1. Absent for other places, and behind a
    /// slot that is passed on whole.
    std::optional<std::int64_t> number;
    /// For its error budget; absent where the origin of the place is not recorded.
    std::optional<BudgetPlace> budget_place;
  };

  struct ToolFigures {
    std::optional<Length> tolerance;  ///< the smallest, where the program changes the diameter
    std::int64_t n_uncorrected = 0;   ///< places without a predicted error
    RadialFigures predicted;          ///< of the other ones
    Length largest_sigma;             ///< in the worst direction
    Length largest_radius_95;         ///< of the circles that hold a place's error in 95 %
    std::int64_t n_judged = 0;        ///< places with a tolerance and a predicted error
    std::int64_t n_told = 0;          ///< those of them whose risk may be stated
    double stated_risk = 0;           ///< the largest of these, as outputs state it
    std::int64_t n_warned = 0;        ///< above warn_above, those above hold_above included
    std::int64_t n_held = 0;
    double expected_broken = 0;  ///< the sum of the risks
    WorstPlace worst;            ///< the likeliest to break, if n_judged > 0
  };

  /// The place that an unnoticed error of a target moves furthest, of those whose risk is not told
  /// below kMinStatedRisk.
  struct UnseenPlace {
    int line = 0;
    std::string file;
    Length shift;
    std::optional<BudgetPlace> budget_place;
  };

  /// Risks by decade: the first is below kLowestDecade, the last is 0.1 to 1.
  static constexpr int kLowestDecade = -12;
  static constexpr std::size_t kDecades = 1 - kLowestDecade;
  struct Decade {
    std::int64_t n_good = 0;
    std::int64_t n_warned = 0;
    std::int64_t n_held = 0;
    std::int64_t n() const { return n_good + n_warned + n_held; }
  };

  explicit JobVerdict(const Tolerances& tolerances);
  JobVerdict(const JobVerdict&) = delete;
  JobVerdict& operator=(const JobVerdict&) = delete;

  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

  const Tolerances& tolerances() const { return tolerances_; }
  const std::map<int, ToolFigures>& by_tool() const { return by_tool_; }
  const std::array<Decade, kDecades>& decades() const { return decades_; }
  std::int64_t n_judged() const;
  std::int64_t n_told() const;
  std::int64_t n_uncorrected() const;
  /// Places with a predicted error, but without a tolerance to hold it against.
  std::int64_t n_not_asked() const;
  /// Places whose tool has a tolerance, without a predicted error to hold against it.
  std::int64_t n_unjudged() const;
  std::int64_t n_warned() const;
  std::int64_t n_held() const;
  double expected_broken() const;
  /// The tool whose worst place is the worst of the job; null if nothing was judged.
  const ToolFigures* worst_tool() const;
  /// Null if all risks are told.
  const UnseenPlace* worst_unseen() const { return worst_unseen_ ? &*worst_unseen_ : nullptr; }
  /// The basis of the figures: once, when the job has passed. Sentences, messages and tables
  /// follow.
  void set_basis(RiskBasis basis) { basis_ = std::move(basis); }
  const RiskBasis& basis() const { return basis_; }
  JudgedPlaces places() const;
  JobDecision decision() const { return decide(places()); }
  /// One line for people: "hold: ...".
  std::string sentence() const;
  /// tolerance-hold and tolerance-warning: one a tool, with its worst place.
  void report(const std::string& file, DiagnosticLog& log) const;

 private:
  ToolFigures& figures(int tool);
  void put_place(const Operation& operation, int tool, const PlacedPoint& place);
  void put_plunge(const Operation& operation, int tool);
  void judge(const Operation& operation, ToolFigures& tool, const PlacedPoint& place);
  void count_told(const Operation& operation, ToolFigures& tool, const PlacedPoint& place);
  std::string risks_sentence() const;
  bool tells(double risk) const;  ///< this figure may be printed
  /// A length that grows with the larger sigma, by its values at ratios of the sigmas; to 1e-5 of
  /// itself.
  static constexpr int kRatios = 256;
  using ByRatio = std::array<double, kRatios + 1>;
  static Length interpolated(const ByRatio& table, const PrincipalSigmas& sigmas);

  Tolerances tolerances_;
  std::map<int, Tool> tools_;
  std::map<int, ToolFigures> by_tool_;
  std::array<Decade, kDecades> decades_;
  PlacedPoint router_;  ///< place of the router
  std::int64_t n_places_ = 0;
  bool has_slots_ = false;  ///< passed on whole
  std::optional<UnseenPlace> worst_unseen_;
  RiskBasis basis_;
  int tool_ = 0;  ///< of last_
  ToolFigures* last_ = nullptr;
  // Every place asks for them.
  ByRatio radii_95_;  ///< radius_exceeded by 5 %
  ByRatio means_;     ///< mean_radial_error
};

}  // namespace panelcal
