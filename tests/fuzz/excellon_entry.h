// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "panelcal/program/measurement.h"
#include "panelcal/program/walk.h"

namespace panelcal::fuzz {

/// What an execution passed on, reduced to numbers that two executions can be compared by.
class CountingSink final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    ++n_operations_;
    const auto* drill = std::get_if<Drill>(&operation.what);
    if (drill == nullptr) return;
    const Eigen::Vector2d& actual_mm = drill->actual.in_mm();
    has_nan_ |= std::isnan(actual_mm.x()) || std::isnan(actual_mm.y());
    sum_mm_ += actual_mm.x() - actual_mm.y();
  }

  bool has_nan() const { return has_nan_; }
  friend bool operator==(const CountingSink& a, const CountingSink& b) {
    return a.n_operations_ == b.n_operations_ &&
           (a.sum_mm_ == b.sum_mm_ || (std::isnan(a.sum_mm_) && std::isnan(b.sum_mm_)));
  }

 private:
  std::int64_t n_operations_ = 0;
  double sum_mm_ = 0;
  bool has_nan_ = false;
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

/// Reads, checks and executes any bytes as an Excellon program.
///
/// Out    what is wrong with panelcal, never with the program; empty if all is well
inline std::optional<std::string> run_excellon(std::string_view bytes) {
  WalkOptions options;
  options.max_operations = 5'000;
  options.max_measurements = 500;
  DiagnosticLog log;
  const Program program = load_program({"fuzz.exc", std::string(bytes)}, log);
  NominalSource source;
  const Survey found = survey(program, options, source, log);
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.code == Code::Internal) return diagnostic.text();
    if (diagnostic.text().empty()) return "a diagnostic without a text";
  }
  for (const Measurement& measurement : found.measurements) {
    if (to_json(measurement).empty()) return "a measurement without a text";
  }
  if (log.has_errors()) return std::nullopt;
  if (!found.is_complete()) return "the survey is not complete, and no error says so";

  CountingSink first;
  if (auto complaint = execution_complaint(program, options, found, first)) return complaint;
  CountingSink second;
  if (auto complaint = execution_complaint(program, options, found, second)) return complaint;
  if (first.has_nan()) return "a hole without a place";
  if (!(first == second)) return "two executions differ";
  return std::nullopt;
}

}  // namespace panelcal::fuzz
