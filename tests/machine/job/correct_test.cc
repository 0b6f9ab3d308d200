// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <string_view>
#include <vector>

#include "machine/job/job.h"
#include "program/writers/excellon/writer.h"
#include <gtest/gtest.h>
#include <panelcal/panelcal.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using namespace std::chrono_literals;
using test::FailsWith;
using test::IsNearPosition;

constexpr std::chrono::sys_seconds kNoon = std::chrono::sys_days{2026y / 11 / 21} + 12h;
constexpr Length kRounding = um(1e-6);

constexpr std::string_view kOneTarget =
    "M48\nMETRIC,LZ\nT1C1.0F100\n%\nG34,1\nT1\nG35X0.0Y0.0\nX10.0Y20.0\nX11.0\nM30\n";
constexpr std::string_view kNoTarget =
    "M48\nMETRIC,LZ\nT1C1.0F100\n%\nT1\nX10.0Y20.0\nX11.0\nM30\n";
constexpr std::string_view kRepeated =
    "M48\nMETRIC,LZ\nT1C1.0F100\n%\nT1\nM25\nX10.0Y20.0\nM01\nM02X5.0\nM08\nM30\n";
constexpr std::string_view kMeasured =
    R"({"seq":0,"line":7,"command":"G35","tool":1,"nominal":[0,0],"expected":[0,0],"path":[],)"
    R"("measured":[0.25,-0.5],"cov":[1e-06,0,1e-06],"status":"found"})"
    "\n";

Job job_of(std::string_view text) {
  Job job;
  job.program = load_program({"job.exc", std::string(text)}, job.reading);
  job.now = kNoon;
  return job;
}

MachineConfig machine_of(std::string_view toml) {
  auto config = parse_machine_config(toml, "machine.toml");
  EXPECT_TRUE(config) << config.error().text();
  return *std::move(config);
}

MeasurementFileSource recorded(std::string_view lines) {
  auto read = parse_measurements(lines, "measurements.jsonl");
  EXPECT_TRUE(read) << read.error().text();
  return MeasurementFileSource(*std::move(read));
}

class Holes final : public OperationSink {
 public:
  void begin(const ProgramInfo&) override { ++n_begun; }
  void put(const Operation& operation) override {
    if (const auto* drill = std::get_if<Drill>(&operation.what)) {
      places.push_back(drill->corrected);
    }
  }

  std::vector<Position<frame::Actual>> places;
  int n_begun = 0;
};

/// Counts what it is asked.
class CountingSource final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    ++n_asked;
    return panel_.measure(request);
  }

  int n_asked = 0;

 private:
  NominalSource panel_;
};

/// The errors of a log, as code and place.
std::vector<std::pair<Code, int>> errors(const DiagnosticLog& log) {
  std::vector<std::pair<Code, int>> found;
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) {
      found.emplace_back(diagnostic.code, diagnostic.place.line);
    }
  }
  return found;
}

using Errors = std::vector<std::pair<Code, int>>;

TEST(Correct, PutsHolesWhereTheTargetWasMeasured) {
  const Job job = job_of(kOneTarget);
  MeasurementFileSource source = recorded(kMeasured);
  Holes holes;
  const auto result = correct(job, source, machine_of(""), {.operations = &holes});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_TRUE(result->may_be_drilled());
  ASSERT_EQ(holes.places.size(), 2u);
  EXPECT_THAT(holes.places[0], IsNearPosition(position_mm<frame::Actual>(10.25, 19.5), kRounding));
  EXPECT_THAT(holes.places[1], IsNearPosition(position_mm<frame::Actual>(11.25, 19.5), kRounding));
  EXPECT_EQ(holes.n_begun, 1);
  EXPECT_EQ(result->survey->measurements.size(), 1u);
  EXPECT_EQ(result->tally.n_holes(), 2);
}

TEST(Correct, RefusesAFormatWithoutAnOutputAndTheReverse) {
  Job job = job_of(kNoTarget);
  StringSink written;
  SpooledOutput output(written);
  NominalSource source;
  EXPECT_THAT(correct(job, source, machine_of(""), {.output = &output}),
              FailsWith(Code::Usage, "JobSinks::output without Job::format"));
  job.format = OutputFormat::Excellon;
  EXPECT_THAT(correct(job, source, machine_of(""), {}),
              FailsWith(Code::Usage, "Job::format without JobSinks::output"));
  EXPECT_EQ(written.text(), "");
}

TEST(Correct, WalksOnceToCheckOnceToMeasureAndOnceToWork) {
  const Job job = job_of(kOneTarget);
  MeasurementFileSource source = recorded(kMeasured);
  Holes holes;
  const auto result = correct(job, source, machine_of(""), {.operations = &holes});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_EQ(result->n_walks, 3);
}

TEST(Correct, WalksAProgramWithoutTargetsOnce) {
  Job job = job_of(kNoTarget);
  job.format = OutputFormat::Excellon;
  job.explain = parse_explain_choice("L6");
  job.finds_worst_place = true;
  CountingSource source;
  StringSink written;
  SpooledOutput output(written);
  const auto result =
      correct(job, source, machine_of("[tolerance]\nposition_um = 25\n"), {.output = &output});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_EQ(result->n_walks, 1);
  EXPECT_EQ(source.n_asked, 0);
  EXPECT_TRUE(result->is_committed);
  EXPECT_FALSE(result->explanation.empty());

  StringSink expected;
  ExcellonWriter writer(expected, {.allow_losses = true});
  DiagnosticLog log;
  execute(job.program, {.slots = Cycles::Kept, .step_slots = Cycles::Kept}, {}, writer, log);
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(written.text(), expected.text());
}

TEST(Correct, ChecksCopiesByCountingBeforeItExecutesThem) {
  Job job = job_of(kRepeated);
  job.format = OutputFormat::Csv;
  CountingSource source;
  StringSink written;
  SpooledOutput output(written);
  const auto result = correct(job, source, machine_of(""), {.output = &output});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_EQ(result->n_walks, 2);
  EXPECT_EQ(result->tally.n_holes(), 2);
}

/// A panel that the job drills into while it is measured.
class DrilledSource final : public MeasurementSource, public DrilledPanel {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    return panel_.measure(request);
  }
  DrilledPanel* drilled_panel() override { return this; }
  void drill(const DrilledHole& hole) override { places.push_back(hole.place); }

  std::vector<Position<frame::Actual>> places;

 private:
  NominalSource panel_;
};

TEST(Correct, TellsThePanelOfHolesThatAreDrilledBeforeItIsMeasured) {
  const Job job = job_of("%%5000\nX1.Y2.T1\nX1.Y2.G32\nG31\nX3.Y4.T1\nG30\n$\nT1D1.F3.\n$\n");
  DrilledSource source;
  Holes holes;
  const auto result = correct(job, source, machine_of(""), {.operations = &holes});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_EQ(holes.places.size(), 2U);
  // Behind its last target the program asks for nothing.
  ASSERT_FALSE(source.places.empty());
  EXPECT_THAT(source.places[0], IsNearPosition(position_mm<frame::Actual>(1, 2), kRounding));
}

TEST(Correct, RefusesAnOffsetOutsideItsGate) {
  Job job = job_of(kOneTarget);
  job.format = OutputFormat::Jsonl;
  MeasurementFileSource source = recorded(kMeasured);
  StringSink written;
  SpooledOutput output(written);
  const auto result =
      correct(job, source, machine_of("[gates]\noffset_mm = 0.1\n"), {.output = &output});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_FALSE(result->may_be_drilled());
  EXPECT_EQ(errors(result->log), (Errors{{Code::GateFailed, 7}, {Code::SeriesInconsistent, 7}}));
  EXPECT_FALSE(result->is_executed);
  EXPECT_FALSE(result->is_committed);
  EXPECT_EQ(written.text(), "");
}

TEST(Correct, WritesByForceWhatAGateRefuses) {
  Job job = job_of(kOneTarget);
  job.format = OutputFormat::Jsonl;
  job.force = true;
  MeasurementFileSource source = recorded(kMeasured);
  StringSink written;
  SpooledOutput output(written);
  const auto result =
      correct(job, source, machine_of("[gates]\noffset_mm = 0.1\n"), {.output = &output});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_TRUE(result->is_committed);
  EXPECT_NE(written.text(), "");
  EXPECT_FALSE(result->may_be_drilled());
}

TEST(Correct, HoldsAJobThatMayBreakItsTolerance) {
  Job job = job_of(kOneTarget);
  job.format = OutputFormat::Jsonl;
  MeasurementFileSource source = recorded(kMeasured);
  StringSink written;
  SpooledOutput output(written);
  const auto result =
      correct(job, source, machine_of("[tolerance]\nposition_um = 2\n"), {.output = &output});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_TRUE(result->is_judged);
  EXPECT_TRUE(result->is_held);
  EXPECT_FALSE(result->may_be_drilled());
  EXPECT_EQ(errors(result->log), (Errors{{Code::ToleranceHold, 8}}));
  EXPECT_EQ(written.text(), "");
}

TEST(Correct, MeasuresNothingForAProgramWithAMistake) {
  const Job job =
      job_of("M48\nMETRIC,LZ\nT1C1.0F100\n%\nG34,1\nT1\nG35X0.0Y0.0\nX10.0Y20.0\nQ7\nM30\n");
  CountingSource source;
  DiagnosticLog log;
  const auto result = correct(job, source, machine_of(""), {.log = &log});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::CommandUnknown);
  EXPECT_EQ(result.error().place.line, 9);
  EXPECT_EQ(result.error().place.column, 1);
  EXPECT_EQ(errors(log), (Errors{{Code::CommandUnknown, 9}}));
  EXPECT_EQ(source.n_asked, 0);
}

TEST(Correct, MeasuresNothingForAnOutputThatCannotBeWritten) {
  Job job = job_of(kOneTarget);
  job.format = OutputFormat::Excellon;
  for (const char* const target : {"no/such/folder/x.drl", "."}) {
    FileOutput output(target);
    Holes holes;
    for (OperationSink* const operations :
         {static_cast<OperationSink*>(nullptr), static_cast<OperationSink*>(&holes)}) {
      CountingSource source;
      const JobSinks sinks{.output = &output, .operations = operations};
      EXPECT_THAT(correct(job, source, machine_of(""), sinks), FailsWith(Code::DeviceWrite));
      EXPECT_EQ(source.n_asked, 0);
    }
  }
}

TEST(Correct, RefusesARecordOfAnotherProgram) {
  const Job job = job_of(kNoTarget);
  MeasurementFileSource source = recorded(kMeasured);
  EXPECT_THAT(correct(job, source, machine_of("")), FailsWith(Code::MeasurementMismatch, ""));
}

TEST(Correct, RefusesAnOffsetThatWasFoundLater) {
  const Job job = job_of(kNoTarget);
  CountingSource source;
  const auto result = correct(job,
                              source,
                              machine_of("[spindle]\ncamera_offset_mm = [60, 0]\n"
                                         "camera_offset_date = 2026-11-22T00:00:00\n"));
  EXPECT_THAT(result, FailsWith(Code::ConfigValue, ""));
}

TEST(Correct, ExplainsAPlaceWithoutAnOutput) {
  Job job = job_of(kOneTarget);
  job.explain = parse_explain_choice("2");
  MeasurementFileSource source = recorded(kMeasured);
  const auto result = correct(job, source, machine_of(""));
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_NE(result->explanation, "");
  EXPECT_FALSE(result->is_committed);
  EXPECT_EQ(result->n_walks, 3);
}

TEST(Correct, RefusesToExplainAPlaceThatIsNotThere) {
  Job job = job_of(kOneTarget);
  job.explain = parse_explain_choice("3");
  MeasurementFileSource source = recorded(kMeasured);
  const auto result = correct(job, source, machine_of(""));
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_EQ(result->explanation, "");
  EXPECT_EQ(errors(result->log), (Errors{{Code::Usage, 0}}));
}

TEST(Correct, TellsWhatWasMeasuredBeforeItWorks) {
  const Job job = job_of(kOneTarget);
  MeasurementFileSource source = recorded(kMeasured);
  Holes holes;
  int n_told = 0;
  const auto tell = [&](const Survey& survey) -> Expected<void> {
    ++n_told;
    EXPECT_EQ(survey.series.size(), 1u);
    EXPECT_TRUE(holes.places.empty());
    return failure({Code::DeviceWrite, {"record", 0, 0}, "disk full", ""});
  };
  const auto result =
      correct(job, source, machine_of(""), {.operations = &holes, .measured = tell});
  EXPECT_THAT(result, FailsWith(Code::DeviceWrite, "disk full"));
  EXPECT_EQ(n_told, 1);
  EXPECT_TRUE(holes.places.empty());
}

}  // namespace
}  // namespace panelcal
