// SPDX-License-Identifier: Apache-2.0
#include "tools/history/diff.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "calib/advice/convex_hull.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

using Shift = Displacement<frame::Actual>;

/// Places whose positions are kept at a time.
constexpr std::size_t kWindow = std::size_t{1} << 22;
/// Cells of the sample's grid along each side.
constexpr int kShiftCells = 20;
constexpr double kSame_mm = 1e-6;
constexpr double kNothing_mm = 1e-9;

/// Answers as an earlier survey was answered, each target moved.
class MovedTargets final : public MeasurementSource {
 public:
  MovedTargets(const Survey& before, const CalibrationChange& change) : change_(change) {
    for (const Measurement& m : before.measurements) by_seq_.emplace(m.request.seq, &m);
  }

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    const auto found = by_seq_.find(request.seq);
    if (found == by_seq_.end()) {
      return failure({Code::MeasurementMissing,
                      {request.file, request.line, 0},
                      fmt::format("target {} has no earlier measurement", request.seq),
                      "the same targets with either calibration"});
    }
    Measurement answer = *found->second;
    if (answer.status == MeasurementStatus::Found) {
      PANELCAL_TRY(const Shift shift, change_.target_shift(*found->second));
      answer.measured.position = answer.measured.position + shift;
    }
    answer.request = request;
    return answer;
  }

 private:
  std::map<std::int64_t, const Measurement*> by_seq_;
  const CalibrationChange& change_;
};

/// A place that passes; valid during the call.
struct PassingPoint {
  std::size_t i = 0;
  const Operation& operation;
  const PlacedPoint& point;
  int tool = 0;
};

/// Passes on the places that a job works at, counted from 0.
class WorkedPlaces final : public OperationSink {
 public:
  using Visit = std::function<void(const PassingPoint&)>;
  WorkedPlaces(bool has_routs, Visit visit) : has_routs_(has_routs), visit_(std::move(visit)) {}

  void put(const Operation& operation) override {
    if (const auto* drill = std::get_if<Drill>(&operation.what)) {
      pass(operation, *drill, drill->tool);
    } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
      if (has_routs_) pass(operation, *rout, rout->tool);
    } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
      pass(operation, slot->start, slot->tool);
      pass(operation, slot->end, slot->tool);
    } else if (const auto* step_slot = std::get_if<StepSlot>(&operation.what)) {
      pass(operation, step_slot->start, step_slot->tool);
      pass(operation, step_slot->end, step_slot->tool);
    }
  }

  std::size_t n() const { return n_; }

 private:
  void pass(const Operation& operation, const PlacedPoint& point, int tool) {
    visit_({n_++, operation, point, tool});
  }

  bool has_routs_;
  Visit visit_;
  std::size_t n_ = 0;
};

bool is_corrected(const Operation& operation) {
  const Origin* const origin = operation.origin;
  if (origin == nullptr) return false;
  return (origin->base_series != nullptr && origin->base_series->has_value()) ||
         (origin->nested_series != nullptr && origin->nested_series->has_value()) ||
         origin->i_measurement.has_value();
}

plan::PlannedPlace planned(const PassingPoint& at) {
  return {at.point.nominal,
          at.operation.line,
          std::string(at.operation.file),
          at.tool,
          false,
          InstancePath(at.operation.path.begin(), at.operation.path.end())};
}

/// The places nearest to the middles of a grid's cells.
class GridSample {
 public:
  /// In     outline: of all places; empty if there are none
  explicit GridSample(const std::vector<Position<frame::Nominal>>& outline) {
    if (outline.empty()) return;
    Eigen::Vector2d high_mm = low_mm_ = outline.front().in_mm();
    for (const Position<frame::Nominal>& corner : outline) {
      low_mm_ = low_mm_.cwiseMin(corner.in_mm());
      high_mm = high_mm.cwiseMax(corner.in_mm());
    }
    cell_mm_ = std::max(1e-3, (high_mm - low_mm_).maxCoeff() / kShiftCells);
  }

  void add(const PassingPoint& at, const Shift& shift) {
    const Eigen::Vector2d cells = (at.point.nominal.in_mm() - low_mm_) / cell_mm_;
    const Eigen::Vector2d floor = cells.array().floor();
    if (!floor.allFinite() || floor.cwiseAbs().maxCoeff() > 1e6) return;
    const double distance = (cells - floor - Eigen::Vector2d::Constant(0.5)).norm();
    const std::pair<int, int> key(static_cast<int>(floor.x()), static_cast<int>(floor.y()));
    const auto found = nearest_.find(key);
    if (found != nearest_.end() && distance >= found->second.first) return;
    nearest_.insert_or_assign(key, std::pair(distance, MovedPlace{planned(at), shift}));
  }

  std::vector<MovedPlace> places() const {
    std::vector<MovedPlace> out;
    for (const auto& [key, place] : nearest_) out.push_back(place.second);
    return out;
  }

 private:
  Eigen::Vector2d low_mm_ = Eigen::Vector2d::Zero();
  double cell_mm_ = 1;
  std::map<std::pair<int, int>, std::pair<double, MovedPlace>> nearest_;
};

Expected<void> check_no_error(const DiagnosticLog& log) {
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) return failure(diagnostic);
  }
  return {};
}

/// Compares the job with either survey, window by window.
class Comparison {
 public:
  /// A survey, and what it is executed with.
  struct Side {
    const Survey& survey;
    const WalkOptions& options;
  };
  Comparison(const Program& program, const Side& before, const Side& after)
      : program_(program), before_(before), after_(after) {}

  Expected<std::optional<JobShift>> compare() {
    PANELCAL_TRY(const bool is_same, compare_all());
    if (!is_same) {
      // Corrected arcs, and moves on a bent panel, are cut where they need it, which need not be
      // the same twice. Holes are.
      has_routs_ = false;
      PANELCAL_TRY(const bool has_same_holes, compare_all());
      if (!has_same_holes) return failure(two_jobs());
    }
    if (n_ == 0) return std::optional<JobShift>();
    return std::optional(std::move(shift_));
  }

 private:
  Diagnostic two_jobs() const {
    return {Code::Internal,
            {program_.source.file, 0, 0},
            "the two calibrations make two jobs of it",
            "the same holes with either"};
  }

  /// False if there is not one place with the one calibration for each with the other.
  Expected<bool> compare_all() {
    shift_ = {};
    statistics_ = HoleShiftStatistics();
    longest_mm_ = -1;
    PANELCAL_CHECK(look_over());
    shift_.has_routs = has_routs_;
    GridSample sample(shift_.hull);
    for (std::size_t first = 0; first < n_; first += kWindow) {
      PANELCAL_TRY(const bool is_same, compare_window(first, sample));
      if (!is_same) return false;
    }
    shift_.sample = sample.places();
    if (n_ > 0) shift_.summary = *statistics_.summary();
    return true;
  }

  /// Counts the places and finds where they lie.
  Expected<void> look_over() {
    // Another table moves all.
    const bool moves_all = before_.options.table != after_.options.table;
    HullBuilder hull;
    WorkedPlaces places(has_routs_, [&](const PassingPoint& at) {
      hull.add(at.point.nominal);
      shift_.n_drilled += std::holds_alternative<Drill>(at.operation.what) ? 1 : 0;
      shift_.n_still += moves_all || is_corrected(at.operation) ? 0 : 1;
    });
    PANELCAL_CHECK(walk(before_, places));
    n_ = places.n();
    shift_.hull = hull.corners();
    for (const Measurement& m : before_.survey.measurements) {
      shift_.targets.push_back(m.request.nominal);
    }
    return {};
  }

  Expected<bool> compare_window(std::size_t first, GridSample& sample) {
    struct Kept {
      Position<frame::Nominal> nominal;
      Displacement<frame::Machine> commanded;
    };
    std::vector<Kept> kept;
    kept.reserve(std::min(kWindow, n_ - first));
    WorkedPlaces places(has_routs_, [&](const PassingPoint& at) {
      if (at.i >= first && at.i - first < kWindow) {
        kept.push_back({at.point.nominal, at.point.commanded});
      }
    });
    PANELCAL_CHECK(walk(before_, places));
    bool is_same = true;
    Expected<void> done;
    WorkedPlaces moved(has_routs_, [&](const PassingPoint& at) {
      if (!done || !is_same || at.i < first || at.i - first >= kept.size()) return;
      const Kept& old = kept[at.i - first];
      is_same = (at.point.nominal - old.nominal).in_mm().norm() < kSame_mm;
      if (!is_same) return;
      const Displacement<frame::Machine> shift = at.point.commanded - old.commanded;
      done = take(at, displacement_mm<frame::Actual>(shift.in_mm()), sample);
    });
    PANELCAL_CHECK(walk(after_, moved));
    PANELCAL_CHECK(done);
    return is_same && moved.n() == places.n();
  }

  Expected<void> take(const PassingPoint& at, const Shift& shift, GridSample& sample) {
    PANELCAL_CHECK(statistics_.add(at.point.nominal, shift));
    // The first of those that move alike, whatever the last bits say.
    if (shift.in_mm().norm() > longest_mm_ + kNothing_mm) {
      longest_mm_ = shift.in_mm().norm();
      shift_.worst = {planned(at), shift};
    }
    sample.add(at, shift);
    return {};
  }

  /// Warnings were said already.
  Expected<void> walk(const Side& side, OperationSink& sink) const {
    DiagnosticLog log;
    execute(program_, side.options, side.survey, sink, log);
    return check_no_error(log);
  }

  const Program& program_;
  Side before_;
  Side after_;
  bool has_routs_ = true;
  std::size_t n_ = 0;
  double longest_mm_ = -1;
  HoleShiftStatistics statistics_;
  JobShift shift_;
};

}  // namespace

bool JobShift::is_uniform() const {
  return summary.max.in_mm() - summary.mean_shift.in_mm().norm() < kSame_mm;
}

Expected<std::optional<JobShift>> job_shift(const Program& program,
                                            const WalkOptions& options,
                                            const Survey& before,
                                            const CalibrationChange& change) {
  // Measurements behind it follow the offset that the job found, by as much as the change moved it;
  // that is not measured.
  if (!before.calibrations.empty()) {
    const CalibrationOrder& order = before.calibrations.front().order;
    return failure({Code::Usage,
                    {order.file.empty() ? program.source.file : order.file, order.line, 0},
                    describe(order) + " calibrates the offset anew while the job is measured, so "
                                      "that a stored one does not determine where holes go",
                    "a program that measures with the stored calibration"});
  }
  WalkOptions without_limits = options;
  without_limits.base_limits = {};
  without_limits.nested_limits = {};
  MovedTargets source(before, change);
  DiagnosticLog log;
  WalkOptions options_after = without_limits;
  if (change.table_before != nullptr) {
    without_limits.table = change.table_before;
    options_after.table = change.table_after;
  }
  const Survey after = survey(program, options_after, source, log);
  PANELCAL_CHECK(check_no_error(log));
  return Comparison(program, {before, without_limits}, {after, options_after}).compare();
}

}  // namespace panelcal::history
