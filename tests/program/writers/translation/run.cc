// SPDX-License-Identifier: Apache-2.0
#include "tests/program/writers/translation/run.h"

#include <memory>
#include <utility>

#include "program/writers/excellon/writer.h"
#include "program/writers/sieb_meyer/writer.h"

namespace panelcal::test {
namespace {

/// Both languages write six decimals of a millimetre or more.
constexpr double kSame_mm = 1e-5;

WalkOptions with_whole_cycles(WalkOptions options) {
  options.slots = options.step_slots = Cycles::Kept;
  return options;
}

class WorkReader {
 public:
  std::vector<Event> read(const std::vector<Event>& events) {
    for (const Event& event : events) std::visit([&](const auto& what) { see(what); }, event.what);
    return std::move(work_);
  }

 private:
  void keep(decltype(Operation::what) what) { work_.push_back({0, std::move(what), {}}); }
  bool is_at(const PlacedPoint& place) const {
    return (place.corrected.in_mm() - at_mm_).norm() < kSame_mm;
  }

  void see(const Drill& drill) {
    keep(drill);
    at_mm_ = drill.corrected.in_mm();
    is_up_there_ = false;
  }
  void see(const Slot& slot) {
    keep(slot);
    is_up_there_ = false;
  }
  void see(const RapidMove& move) {
    if (!is_up_there_ || !is_at(move)) keep(move);
    at_mm_ = move.corrected.in_mm();
    is_up_there_ = true;
  }
  void see(const Compensation& compensation) { side_ = compensation.side; }
  void see(const Plunge& plunge) {
    keep(Compensation{side_, {}});
    keep(Plunge{plunge.tool, PlungeKind::Plain, {}, plunge.cut});
  }
  /// An arc is one, in however many pieces it comes: half a circle is just at the limit.
  void see(const Rout& rout) {
    auto* before = work_.empty() ? nullptr : std::get_if<Rout>(&work_.back().what);
    if (before != nullptr && rout.kind != RoutKind::Line && rout.kind == before->kind &&
        (rout.corrected_center - before->corrected_center).in_mm().norm() < kSame_mm) {
      static_cast<PlacedPoint&>(*before) = rout;
    } else if (!is_at(rout)) {
      keep(rout);
    }
    at_mm_ = rout.corrected.in_mm();
  }
  void see(const Retract&) {
    keep(Retract{});
    is_up_there_ = true;
  }
  void see(const StepSlot& slot) {
    at_mm_ = slot.end.corrected.in_mm();
    is_up_there_ = false;
  }
  template <class What>
  void see(const What&) {}

  std::vector<Event> work_;
  Eigen::Vector2d at_mm_ = Eigen::Vector2d::Zero();
  bool is_up_there_ = false;
  CompensationSide side_ = CompensationSide::Off;
};

}  // namespace

WorkRun run_on(MeasurementSource& panel,
               const std::string& text,
               const WalkOptions& options,
               const ReadOptions& reading) {
  NominalProbeSource probes;
  return run_on(panel, probes, text, options, reading);
}

WorkRun run_on(MeasurementSource& panel,
               ProbeSource& probes,
               const std::string& text,
               const WalkOptions& options,
               const ReadOptions& reading) {
  const WalkOptions whole = with_whole_cycles(options);
  DiagnosticLog log;
  WorkRun run;
  const Program program = load_program({"p", text}, log, reading);
  const Survey found = survey(program, whole, panel, probes, log);
  for (const Measurement& measurement : found.measurements) {
    run.requests.push_back(measurement.request);
  }
  for (const ProbeReading& probe : found.probes) run.probes.push_back(probe.request);
  if (!log.has_errors()) {
    EventRecorder recorder;
    execute(program, whole, found, recorder, log);
    run.events = std::move(recorder.events());
  }
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) run.errors.push_back(diagnostic.text());
  }
  return run;
}

WorkRun run_nominally(const std::string& text,
                      const WalkOptions& options,
                      const ReadOptions& reading) {
  NominalSource panel;
  return run_on(panel, text, options, reading);
}

Translation translate(const std::string& text,
                      Dialect to,
                      const WalkOptions& options,
                      const ReadOptions& reading) {
  WalkOptions walk = with_whole_cycles(options);
  DiagnosticLog log;
  Translation translation;
  NominalSource source;
  const Program program = load_program({"p", text}, log, reading);
  const Survey found = survey(program, walk, source, log);
  StringSink bytes;
  // With all digits: what is compared here is the work, not its rounding.
  ProgramWriterOptions writing{.allow_losses = true, .keeps_vision = true, .resolution = um(0.001)};
  std::unique_ptr<ProgramWriter> writer;
  if (to == Dialect::Excellon) {
    writer = std::make_unique<ExcellonWriter>(bytes, writing);
  } else {
    writer = std::make_unique<SiebMeyerWriter>(bytes, writing);
  }
  walk.structure = Structure::Kept;
  if (!log.has_errors()) execute(program, walk, found, *writer, log);
  const Expected<void> done = writer->finish();
  if (!done) translation.errors.push_back(done.error().text());
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) translation.errors.push_back(diagnostic.text());
  }
  for (const Diagnostic& loss : writer->losses().kept()) translation.losses.push_back(loss.text());
  translation.is_refused = writer->losses().has_errors();
  translation.text = bytes.text();
  return translation;
}

Dialect other_language(const std::string& text) {
  return text.starts_with("%%") ? Dialect::Excellon : Dialect::SiebMeyer;
}

std::string sieb_meyer(const std::string& body) {
  return "%%5000\n" + body + "$\nT1D1.\nT2D2.\n$\n";
}

std::vector<Event> work_of(const std::vector<Event>& events) {
  return WorkReader().read(events);
}

std::string difference_of_work(const WorkRun& source, const WorkRun& translation) {
  return difference(work_of(source.events),
                    work_of(translation.events),
                    {.place_mm = kLastDigit_mm, .rate_mm_s = kWholeFeed_mm_s});
}

}  // namespace panelcal::test
