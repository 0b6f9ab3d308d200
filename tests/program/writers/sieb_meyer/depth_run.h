// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER programs that are executed and written, with the depth state of each stroke.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "program/walk/walk.h"
#include "program/writers/program_writer.h"
#include "program/writers/sieb_meyer/writer.h"
#include <Eigen/Core>
#include <fmt/format.h>

#include "tests/support/matchers.h"

namespace panelcal::test {

/// A board 5 mm above the table that rises by 10 um a mm along x: each place has a height of its
/// own.
class SlopingBoard final : public ProbeSource {
 public:
  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    const Length height = mm(5 + 0.01 * request.nominal.in_mm().x());
    return ProbeReading{request, ProbeStatus::Found, {{height, um(1)}}, ""};
  }
};

/// A hole, a slot, or the end of a line or arc.
struct Stroke {
  Eigen::Vector2d at_mm;
  DepthOfCut cut;
};

class StrokeRecorder final : public OperationSink {
 public:
  explicit StrokeRecorder(OperationSink* next = nullptr) : next_(next) {}

  void begin(const ProgramInfo& info) override {
    if (next_ != nullptr) next_->begin(info);
  }
  void put(const Operation& operation) override {
    const auto add = [this](const PlacedPoint& place, const DepthOfCut& cut) {
      strokes_.push_back({place.corrected.in_mm(), cut});
    };
    if (const auto* drill = std::get_if<Drill>(&operation.what)) add(*drill, drill->cut);
    if (const auto* rout = std::get_if<Rout>(&operation.what)) add(*rout, rout->cut);
    if (const auto* slot = std::get_if<Slot>(&operation.what)) add(slot->end, slot->cut);
    if (next_ != nullptr) next_->put(operation);
  }
  std::vector<Stroke> take() { return std::move(strokes_); }

 private:
  OperationSink* next_;
  std::vector<Stroke> strokes_;
};

struct DepthRun {
  std::vector<Stroke> strokes;
  std::vector<std::string> errors;    ///< of the walks
  std::vector<std::string> warnings;  ///< of the walks
  std::string text;                   ///< as written
  std::vector<std::string> losses;
  std::string failure;  ///< of the writer
};

/// Executes a program on the sloping board, and writes it.
inline DepthRun run_and_write(const std::string& source,
                              std::unique_ptr<ProgramWriter> writer,
                              StringSink& bytes,
                              const WalkOptions& options = {}) {
  DiagnosticLog log;
  DepthRun run;
  NominalSource targets;
  SlopingBoard board;
  const Program program = load_program({"p.s5", source}, log);
  const Survey found = survey(program, options, targets, board, log);
  StrokeRecorder recorder(writer.get());
  if (!log.has_errors()) execute(program, options, found, recorder, log);
  const Expected<void> done = writer->finish();
  if (!done) run.failure = done.error().text();
  for (const Diagnostic& loss : writer->losses().kept()) run.losses.push_back(loss.text());
  for (const Diagnostic& diagnostic : log.kept()) {
    (diagnostic.severity() == Severity::Error ? run.errors : run.warnings)
        .push_back(diagnostic.text());
  }
  run.strokes = recorder.take();
  run.text = bytes.text();
  return run;
}

inline DepthRun run_to_sieb_meyer(const std::string& source, const WalkOptions& options = {}) {
  StringSink bytes;
  return run_and_write(
      source, std::make_unique<SiebMeyerWriter>(bytes, ProgramWriterOptions{}), bytes, options);
}

}  // namespace panelcal::test
