// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/files/byte_sink.h"
#include "program/judge/tally.h"
#include "program/walk/walk.h"
#include "program/writers/csv_writer.h"
#include "program/writers/excellon/writer.h"
#include "program/writers/jsonl_writer.h"
#include "program/writers/svg/writer.h"

#include "tests/fuzz/walk_checks.h"

namespace panelcal::fuzz {

/// Stored patterns that fuzzed programs can call by name.
inline const std::map<std::string, SourceText, std::less<>>& stored_patterns() {
  static const std::map<std::string, SourceText, std::less<>> patterns = {
      {"LOGO", {"LOGO", "X01Y01\nR3X001\nG82\nX02Y02\nX03Y023\n"}},
      {"STEP", {"STEP", "M25\nX01\nM01\nR3M02X01\nM08\nG00X01Y01\nM15\nG01X02\nM17\nG05\n"}}};
  return patterns;
}

/// Passes the job through every writer. The plain Excellon that comes out must be readable and hold
/// the same places to 0.1 um.
inline std::optional<std::string> writers_complaint(const Program& program,
                                                    const WalkOptions& options,
                                                    const Survey& survey,
                                                    const CountingSink& expected) {
  StringSink jsonl_text;
  StringSink csv_text;
  StringSink excellon_text;
  StringSink svg_text;
  JsonlWriter jsonl(jsonl_text);
  CsvWriter csv(csv_text);
  // With all digits, so that only what is read and written counts.
  ExcellonWriter excellon(excellon_text, {.comments = {"fuzzed"}, .resolution = um(0.001)});
  Tally tally;
  DiagnosticLog ignored;
  Tee tee({&jsonl, &csv, &excellon, &tally});
  WalkOptions whole = options;
  whole.step_slots = Cycles::Kept;
  execute(program, whole, survey, tee, ignored);
  SvgWriter svg(svg_text, {});
  execute(program, options, survey, svg, ignored);
  if (!jsonl.finish() || !csv.finish() || !svg.finish()) return "a writer fails";
  if (!excellon.finish()) return std::nullopt;  // what Excellon cannot say is refused

  // Lengths above a kilometre have more digits than numbers may have.
  if (expected.most_mm() > 1e6) return std::nullopt;
  DiagnosticLog log;
  NominalSource source;
  WalkOptions generous = options;
  generous.max_operations = 100 * options.max_operations;
  const Program again = load_program({"again.exc", excellon_text.text()}, log);
  const Survey nominal = panelcal::survey(again, generous, source, log);
  if (!log.has_errors()) {
    CountingSink read;
    execute(again, generous, nominal, read, log);
    constexpr double kTolerance_mm = 1e-4;
    const bool is_same = std::ranges::equal(
        read.places_mm(), expected.places_mm(), [](const auto& a_mm, const auto& b_mm) {
          return (a_mm - b_mm).norm() <= kTolerance_mm;
        });
    if (!is_same) {
      return "the written program drills elsewhere:\n" + excellon_text.text();
    }
  }
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) {
      return "the written program is refused: " + diagnostic.text() + "\n" + excellon_text.text();
    }
  }
  return std::nullopt;
}

/// Reads, checks, executes and writes any bytes as an Excellon program.
///
/// Out    what is wrong with panelcal, never with the program; empty if all is well
inline std::optional<std::string> run_excellon(std::string_view bytes) {
  WalkOptions options;
  options.max_operations = 5'000;
  options.max_measurements = 500;
  DiagnosticLog log;
  options.scaling = ReferenceScaling{
      .x = 1.001, .y = 0.999, .about = position_mm<frame::Nominal>(5, 5), .starts_enabled = false};
  // Few changed inputs still have their end, and few state their format: half of them are read as
  // the last setting has it, the others as their numbers say.
  ReadOptions reading{.accepts_unterminated = true};
  if (bytes.size() % 2 == 0) {
    reading.last_format.unit = LengthUnit::Inch;
    reading.last_format.zeros = Zeros::LeadingKept;
  }
  Program program = load_program({"fuzz.exc", std::string(bytes)}, log, reading);
  if (program.dialect == Dialect::Excellon) program.patterns = stored_patterns();
  BentSource source;
  const Survey found = survey(program, options, source, log);
  if (auto complaint = report_complaint(log, found)) return complaint;
  if (log.has_errors()) return std::nullopt;
  if (!found.is_complete()) return "the survey is not complete, and no error says so";

  CountingSink first;
  if (auto complaint = execution_complaint(program, options, found, first)) return complaint;
  CountingSink second;
  if (auto complaint = execution_complaint(program, options, found, second)) return complaint;
  if (first.has_nan()) return "a hole without a place";
  if (!(first == second)) return "two executions differ";
  BentSource again;
  NominalProbeSource probes;
  if (auto complaint = checked_complaint(program, options, found, again, probes)) return complaint;
  if (auto complaint = gcode_complaint(program, options, found, first.most_mm())) return complaint;
  return writers_complaint(program, options, found, first);
}

}  // namespace panelcal::fuzz
