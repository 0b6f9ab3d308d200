// SPDX-License-Identifier: Apache-2.0
// Properties to which every reader's fuzz target holds a walk.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "calib/base/files/byte_sink.h"
#include "program/gcode/block.h"
#include "program/gcode/motion.h"
#include "program/model/measurement.h"
#include "program/walk/walk.h"
#include "program/writers/gcode/writer.h"

namespace panelcal::fuzz {

/// Operations that an execution passed on, reduced to numbers that two executions can be compared
/// by.
class CountingSink final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    ++n_operations_;
    if (const auto* drill = std::get_if<Drill>(&operation.what)) see(*drill, drill->cut);
    if (const auto* rout = std::get_if<Rout>(&operation.what)) see(*rout, rout->cut);
    if (const auto* function = std::get_if<Function>(&operation.what)) {
      if (function->kind == FunctionKind::ToolExpired) ++n_expired_;
    }
  }

  bool has_nan() const { return has_nan_; }
  bool is_finite() const { return is_finite_; }
  /// Without what the control does by itself, which no limit counts.
  std::int64_t n_counted() const { return n_operations_ - n_expired_; }
  /// Every hole and rout vertex in work coordinates, so that it does not matter which zero an
  /// output is relative to.
  const std::vector<Eigen::Vector2d>& places_mm() const { return places_mm_; }
  double most_mm() const { return most_mm_; }
  friend bool operator==(const CountingSink& a, const CountingSink& b) {
    return a.n_operations_ == b.n_operations_ &&
           (a.sum_mm_ == b.sum_mm_ || (std::isnan(a.sum_mm_) && std::isnan(b.sum_mm_)));
  }

 private:
  void see(const PlacedPoint& place, const DepthOfCut& cut) {
    const Eigen::Vector2d& at_mm = place.corrected.in_mm();
    has_nan_ |= std::isnan(at_mm.x()) || std::isnan(at_mm.y());
    is_finite_ &= at_mm.allFinite() && place.actual.in_mm().allFinite();
    for (const auto& depth : {cut.z, cut.depth, cut.surface}) {
      is_finite_ &= !depth || std::isfinite(depth->in_mm());
    }
    places_mm_.push_back(at_mm);
    sum_mm_ += at_mm.x() - 3 * at_mm.y();
    most_mm_ = std::max({most_mm_, std::abs(at_mm.x()), std::abs(at_mm.y())});
  }

  std::int64_t n_operations_ = 0;
  std::int64_t n_expired_ = 0;
  std::vector<Eigen::Vector2d> places_mm_;
  double sum_mm_ = 0;
  double most_mm_ = 0;
  bool has_nan_ = false;
  bool is_finite_ = true;
};

/// A panel that is turned, moved and stretched a little.
class BentSource final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement measurement{.request = request, .status = MeasurementStatus::Found};
    const Eigen::Vector2d& at_mm = request.expected.in_mm();
    measurement.measured = {position_mm<frame::Actual>(1.0001 * at_mm.x() - 1e-3 * at_mm.y() + 0.1,
                                                       1e-3 * at_mm.x() + 0.9998 * at_mm.y() - 0.2),
                            1e-6 * Eigen::Matrix2d::Identity()};
    return measurement;
  }
};

/// Executes and gives the first error that checking the program should have found.
inline std::optional<std::string> execution_complaint(const Program& program,
                                                      const WalkOptions& options,
                                                      const Survey& survey,
                                                      CountingSink& sink) {
  DiagnosticLog log;
  execute(program, options, survey, sink, log);
  for (const Diagnostic& diagnostic : log.kept()) {
    // Copies without vision are first counted when they are executed.
    if (diagnostic.code != Code::TooManyOperations) return diagnostic.text();
  }
  return std::nullopt;
}

/// A machine that leaves nothing open, but refuses what would cut elsewhere.
inline GcodeSetting complete_setting() {
  GcodeSetting setting;
  setting.safe_z = mm(1e4);
  setting.table_z = setting.board_z = mm(0);
  setting.usual.drill_z = setting.usual.rout_z = mm(-1);
  setting.usual.peck = mm(0.5);
  setting.usual.infeed = setting.usual.feed = mm_per_s(10);
  setting.usual.speed = rpm(30'000);
  return setting;
}

/// Writes the job as G-code, which our own reader has to follow to the end.
inline std::optional<std::string> gcode_complaint(const Program& program,
                                                  const WalkOptions& options,
                                                  const Survey& survey,
                                                  double most_mm) {
  StringSink text;
  GcodeWriter writer(text, {.comments = {"fuzzed"}}, complete_setting());
  DiagnosticLog ignored;
  execute(program, options, survey, writer, ignored);
  const auto done = writer.finish();
  // Beyond, arcs have no digits left for one radius.
  constexpr double kMost_mm = 1e5;
  if (!done) {
    const bool is_ours = done.error().code == Code::Internal && most_mm < kMost_mm;
    return is_ours ? std::optional(done.error().text()) : std::nullopt;
  }
  gcode::MotionReader reader("fuzz.ngc");
  LineCursor cursor(text.text());
  while (!cursor.at_end()) {
    const SourceLine line = cursor.next();
    if (line.text.size() > 255) return "a line of G-code that is too long";
    const auto block = gcode::read_gcode_block(line, "fuzz.ngc");
    if (!block) return "G-code that cannot be read: " + block.error().text();
    const auto motion = reader.read(*block);
    if (!motion) return "G-code that cannot be followed: " + motion.error().text();
  }
  return reader.has_ended() ? std::nullopt : std::optional<std::string>("G-code without an end");
}

/// Complaint about the reports of a survey itself.
inline std::optional<std::string> report_complaint(const DiagnosticLog& log, const Survey& found) {
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.code == Code::Internal) return diagnostic.text();
    if (diagnostic.text().empty()) return "a diagnostic without a text";
  }
  for (const Measurement& measurement : found.measurements) {
    if (to_json(measurement).empty()) return "a measurement without a text";
  }
  return std::nullopt;
}

/// A check that executes passes the operations that a walk of its own does, and a measuring walk
/// that ends early finds what a whole one does.
///
/// In     found: what `source` and `probes` have answered a whole walk
inline std::optional<std::string> checked_complaint(const Program& program,
                                                    const WalkOptions& options,
                                                    const Survey& found,
                                                    MeasurementSource& source,
                                                    ProbeSource& probes) {
  DiagnosticLog log;
  CountingSink tried;
  const CheckedWalk checked = check(program, options, Execution::OfNominal, &tried, log);
  if (log.has_errors()) return std::nullopt;
  CountingSink nominal;
  DiagnosticLog working_log;
  if (checked.survey.is_complete()) {
    execute(program, options, checked.survey, nominal, working_log);
    if (checked.is_executed && !(tried == nominal)) {
      return "a check executes otherwise than a working walk";
    }
    if (checked.is_executed && checked.working_log.n_errors() != working_log.n_errors()) {
      return "a check that executes finds other errors than a working walk";
    }
  }
  DiagnosticLog early_log;
  const Survey early = survey(program, options, checked, source, probes, early_log);
  if (measurement_lines(early) != measurement_lines(found) ||
      early.series.size() != found.series.size() || early_log.has_errors()) {
    return "a measuring walk that ends early finds something else";
  }
  return std::nullopt;
}

}  // namespace panelcal::fuzz
