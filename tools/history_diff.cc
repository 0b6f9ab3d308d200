// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/history_diff.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include <fmt/format.h>

#include "panelcal/calib/calibration_file.h"
#include "panelcal/calib/convex_hull.h"
#include "panelcal/calib/table_calibration_file.h"
#include "panelcal/tools/report_svg.h"

namespace panelcal::history {
namespace {

using Shift = Displacement<frame::Actual>;

/// Places whose positions are kept at a time.
constexpr std::size_t kWindow = std::size_t{1} << 22;
/// Cells of the picture's grid along each side.
constexpr int kCells = 20;
constexpr double kSame_mm = 1e-6;
constexpr double kNothing_mm = 1e-9;

Diagnostic no_difference(const std::string& file, std::string what, std::string expected) {
  return {Code::LedgerEntryInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

Expected<Displacement<frame::Machine>> offset_of(const LedgerEntry& entry,
                                                 const std::string& file) {
  Eigen::Vector2d offset_mm;
  for (int axis = 0; axis < 2; ++axis) {
    const std::string name = axis == 0 ? "offset_x" : "offset_y";
    const auto found = std::ranges::find(entry.record.parameters, name, &LedgerParameter::name);
    if (found == entry.record.parameters.end() || found->unit != "mm") {
      return failure(no_difference(
          file, fmt::format("entry {} has no {} in mm", entry.id, name), "offset_x and offset_y"));
    }
    offset_mm[axis] = found->value;
  }
  return displacement_mm<frame::Machine>(offset_mm);
}

Expected<CalibrationChange> offset_change(const LedgerEntry& before,
                                          const LedgerEntry& after,
                                          const std::string& file) {
  SpindleCameraOffset from;
  SpindleCameraOffset to;
  PANELCAL_TRY(from.offset, offset_of(before, file));
  PANELCAL_TRY(to.offset, offset_of(after, file));
  const HoleShift shift = shift_between(from, to);
  CalibrationChange change;
  change.target_shift = [shift](const Measurement& target) -> Expected<Shift> {
    return shift(target.request.nominal);
  };
  change.notes = {
      "The offset lies between what is seen and what is drilled, so it moves whatever is placed by "
      "targets, and all of it alike, however they were fitted.",
      "If work zero is set with the camera, places that no target corrects move by it as well."};
  return change;
}

/// Whether a target is looked at with the camera that a subject of the ledger names: "zoom 3" is
/// that of `$uvis,zoom,3`, any other name that of targets without a zoom level.
bool is_seen_with(const std::string& subject, const std::optional<double>& zoom) {
  if (!subject.starts_with("zoom ")) return !zoom;
  return zoom && subject == fmt::format("zoom {}", *zoom);
}

/// The camera of one calibration, and what of its picture it may be asked about.
struct SeenBy {
  CameraModel model;
  int width_px;
  int height_px;

  bool shows(const Position<frame::Image>& u) const {
    const Eigen::Vector2d& u_px = u.in_px();
    return u_px.minCoeff() >= -0.5 && u_px.x() <= width_px - 0.5 && u_px.y() <= height_px - 0.5;
  }
};

/// Of a slot one coordinate is only assumed; a search measures from a view that it does not name.
Expected<void> check_says_where_seen(const MeasurementRequest& request) {
  const bool is_searched = request.settings.search.value_or(false);
  if (!is_searched && request.axes == ObservedAxes::Both) return {};
  return failure({Code::MeasurementMismatch,
                  {request.file, request.line, 0},
                  fmt::format("target {} {}: where in the picture it was seen is not recorded",
                              request.seq,
                              is_searched ? "was searched for" : "is a slot"),
                  "targets that show both coordinates, without a search"});
}

Expected<CalibrationChange> camera_change(const CalibrationEntry& before,
                                          const CalibrationEntry& after,
                                          const std::string& file) {
  const auto read = [&](const CalibrationEntry& side) {
    return parse_camera_calibration(side.result, fmt::format("{} entry {}", file, side.entry.id));
  };
  PANELCAL_TRY(const CameraCalibration from, read(before));
  PANELCAL_TRY(const CameraCalibration to, read(after));
  const SeenBy old{from.model(), from.picture_width_px, from.picture_height_px};
  const CameraModel now = to.model();
  CalibrationChange change;
  const std::string subject = before.entry.record.key.subject;
  change.target_shift = [old, now, subject](const Measurement& target) -> Expected<Shift> {
    if (!is_seen_with(subject, target.request.settings.zoom)) return Shift();
    PANELCAL_CHECK(check_says_where_seen(target.request));
    const Shift seen = target.measured.position - target.request.expected;
    const auto u = old.model.image_of(position_mm<frame::Optical>(seen.in_mm()));
    if (!u || !old.shows(*u) || !now.sees(*u)) {
      return failure(
          {Code::MeasurementMismatch,
           {target.request.file, target.request.line, 0},
           fmt::format("target {} was seen {:.3f} mm from where it was looked for, which "
                       "is outside of the picture",
                       target.request.seq,
                       seen.in_mm().norm()),
           "targets found without a search, or nobody knows where in the picture they "
           "were"});
    }
    return displacement_mm<frame::Actual>(now(*u).in_mm() - old.model(*u).in_mm());
  };
  change.notes = {
      "A camera calibration moves a target by where in the picture it is seen; on a perfect panel "
      "all are on the optical axis. --measurements of a job says where they were."};
  return change;
}

/// The stage erred alike whichever calibration is believed; they differ in where they say that it
/// stood.
Expected<CalibrationChange> table_change(const CalibrationEntry& before,
                                         const CalibrationEntry& after,
                                         const std::string& file,
                                         const LookingMachine& machine) {
  const auto read =
      [&](const CalibrationEntry& side) -> Expected<std::shared_ptr<const TableCorrection>> {
    const std::string name = fmt::format("{} entry {}", file, side.entry.id);
    PANELCAL_TRY(TableCalibration table, parse_table_calibration(side.result, name));
    return std::make_shared<const TableCorrection>(std::move(table.map), machine.table_hold, name);
  };
  CalibrationChange change;
  PANELCAL_TRY(change.table_before, read(before));
  PANELCAL_TRY(change.table_after, read(after));
  change.target_shift = [from = change.table_before,
                         to = change.table_after,
                         offset = machine.offset](const Measurement& target) -> Expected<Shift> {
    const auto place = offset.spindle_to_see(target.request.expected_in_machine());
    const auto command = from->command_for(place);
    if (!command) return failure(from->refusal(place));
    const auto now = to->place_of(*command);
    if (!now) return failure(to->refusal(*command));
    return displacement_mm<frame::Actual>((*now - place).in_mm());
  };
  change.notes = {
      "A table calibration moves targets, by where it has the stage that looked at them, and "
      "holes, "
      "by what the machine is told for them.",
      "How a table lies and is turned each calibration takes as it likes; panels that are measured "
      "take that out, places that no target corrects do not."};
  return change;
}

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
                      fmt::format("target {} was not asked for before", request.seq),
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
  explicit GridSample(const report::Extent& extent)
      : low_mm_(extent.low_mm), cell_mm_(std::max(1e-3, extent.size_mm().maxCoeff() / kCells)) {}

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
  Eigen::Vector2d low_mm_;
  double cell_mm_;
  std::map<std::pair<int, int>, std::pair<double, MovedPlace>> nearest_;
};

Expected<void> first_error(const DiagnosticLog& log) {
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
    extent_ = {};
    longest_mm_ = -1;
    PANELCAL_CHECK(look_over());
    shift_.has_routs = has_routs_;
    GridSample sample(extent_);
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
      extent_.add(at.point.nominal.in_mm());
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
      Displacement<frame::Machine> told;
    };
    std::vector<Kept> kept;
    kept.reserve(std::min(kWindow, n_ - first));
    WorkedPlaces places(has_routs_, [&](const PassingPoint& at) {
      if (at.i >= first && at.i - first < kWindow) {
        kept.push_back({at.point.nominal, at.point.told});
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
      const Displacement<frame::Machine> shift = at.point.told - old.told;
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
    return first_error(log);
  }

  const Program& program_;
  Side before_;
  Side after_;
  bool has_routs_ = true;
  std::size_t n_ = 0;
  double longest_mm_ = -1;
  report::Extent extent_;
  HoleShiftStatistics statistics_;
  JobShift shift_;
};

}  // namespace

bool JobShift::is_uniform() const {
  return summary.max.in_mm() - summary.mean_shift.in_mm().norm() < kSame_mm;
}

Expected<CalibrationChange> change_between(const CalibrationEntry& before,
                                           const CalibrationEntry& after,
                                           const std::string& file,
                                           const LookingMachine& machine) {
  const LedgerKey& key = before.entry.record.key;
  if (key != after.entry.record.key) {
    const auto words = [](const LedgerEntry& entry) {
      return fmt::format("entry {} is of {} {} of {}",
                         entry.id,
                         word(entry.record.key.kind),
                         quoted(std::string_view(entry.record.key.subject)),
                         quoted(std::string_view(entry.record.key.machine)));
    };
    return failure(no_difference(
        file, words(before.entry) + ", " + words(after.entry), "two calibrations of one thing"));
  }
  switch (key.kind) {
    case LedgerKind::SpindleCamera:
      return offset_change(before.entry, after.entry, file);
    case LedgerKind::Camera:
      return camera_change(before, after, file);
    case LedgerKind::Table:
      return table_change(before, after, file, machine);
    default:
      return failure(
          no_difference(file,
                        fmt::format("entry {} is of {}, which moves no hole of a program",
                                    before.entry.id,
                                    word(key.kind)),
                        "spindle-camera, camera or table"));
  }
}

Expected<std::optional<JobShift>> job_shift(const Program& program,
                                            const WalkOptions& options,
                                            const Survey& before,
                                            const CalibrationChange& change) {
  // What is measured behind it follows the offset that the job found, by as much as the change
  // moved it; nobody has measured that.
  if (!before.calibrations.empty()) {
    const CalibrationOrder& order = before.calibrations.front().order;
    return failure({Code::Usage,
                    {order.file.empty() ? program.source.file : order.file, order.line, 0},
                    describe(order) + " calibrates the offset anew while the job is measured, so "
                                      "that a stored one does not tell where holes go",
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
  PANELCAL_CHECK(first_error(log));
  return Comparison(program, {before, without_limits}, {after, options_after}).compare();
}

}  // namespace panelcal::history
