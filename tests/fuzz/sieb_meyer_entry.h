// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/files/byte_sink.h"
#include "program/judge/tally.h"
#include "program/sieb_meyer/sections/subprograms.h"
#include "program/sieb_meyer/text/file_layout.h"
#include "program/walk/probing.h"
#include "program/walk/walk.h"
#include "program/writers/csv_writer.h"
#include "program/writers/excellon/writer.h"
#include "program/writers/jsonl_writer.h"
#include "program/writers/sieb_meyer/writer.h"
#include "program/writers/svg/writer.h"

#include "tests/fuzz/walk_checks.h"

namespace panelcal::fuzz {

/// A board that leans and bulges, touched by two spindles.
class BentProbes final : public ProbeSource {
 public:
  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    ProbeReading reading{.request = request, .status = ProbeStatus::Found};
    const Eigen::Vector2d& at_mm = request.nominal.in_mm();
    const double bulge_mm = 0.05 * std::sin(at_mm.x() / 50) + 0.02 * std::cos(at_mm.y() / 70);
    const Length height = request.reference + mm(bulge_mm);
    constexpr Length kSigma = um(1);
    reading.heights = {{height, kSigma}, {height + um(5), kSigma}};
    return reading;
  }
};

/// A program, and the file of subprograms that begins at its first line with an @. The line in
/// front of the %% may name what the machine decides: MODE2, MODE3, MODE5, CAMA, SCALE, BLKD,
/// AXIS2, INCH and LZ (--format), MILS, RATES and IPM (the setting of the control).
struct SiebMeyerInput {
  std::string program;
  std::string subprograms;
  WalkOptions options;
  ReadOptions reading;
};

inline SiebMeyerInput split_input(std::string_view bytes) {
  SiebMeyerInput input;
  std::size_t begin = bytes.starts_with('@') ? 0 : bytes.find("\n@");
  if (begin != std::string_view::npos && begin != 0) ++begin;
  const std::string_view program = bytes.substr(0, begin);
  if (begin != std::string_view::npos) input.subprograms = bytes.substr(begin);
  const bool has_head = sieb_meyer::is_program(program);
  input.program = (has_head ? "" : "%%5000\n") + std::string(program);

  // Few changed inputs still have their end, which an empty tool table is as well.
  if (input.program.find("\n$") == std::string::npos) input.program += "\n$\n$\n";

  const std::string_view first = program.substr(0, program.find('\n'));
  const auto says = [&](std::string_view word) {
    return has_head && first.find(word) != std::string_view::npos;
  };
  input.options.max_operations = 300;
  input.options.max_measurements = 50;
  sieb_meyer::Settings& settings = input.options.sieb_meyer;
  if (says("MODE2")) settings.measurement_mode = 2;
  if (says("MODE3")) settings.measurement_mode = 3;
  if (says("MODE5")) settings.measurement_mode = 5;
  settings.pattern_mode = says("CAMA");
  settings.fits_scale = says("SCALE");
  if (says("BLKD")) input.reading.block_delete = true;
  if (says("AXIS2")) input.reading.axis_version = 2;
  if (says("INCH")) input.reading.forced_format.unit = LengthUnit::Inch;
  if (says("LZ")) {
    input.reading.forced_format.zeros = Zeros::LeadingKept;
    input.reading.forced_format.digits = {2, 4};
  }
  if (says("MILS")) input.reading.last_format = *parse_format("inch,tz,2.3");
  if (says("RATES")) input.reading.inch_rates = RateUnit::MetersPerMinute;
  if (says("IPM")) input.reading.inch_rates = RateUnit::InchesPerMinute;
  return input;
}

/// Every subprogram of the file under its name, as load_program finds them in a folder.
inline std::map<std::string, SourceText, std::less<>> subprograms_of(const std::string& file) {
  constexpr std::size_t kMost = 20;
  std::map<std::string, SourceText, std::less<>> found;
  LineCursor cursor(file);
  while (!cursor.at_end() && found.size() < kMost) {
    std::string_view line = cursor.next().text;
    if (!line.starts_with('@')) continue;
    line = line.substr(1, line.find_last_not_of(" \t"));
    if (!sieb_meyer::is_subprogram_name(line) || found.contains(line)) continue;
    if (!sieb_meyer::find_subprogram(file, line)) continue;
    found.emplace(std::string(line), SourceText{"FUZZ.SS5", file});
  }
  return found;
}

inline Program load_input(const SiebMeyerInput& input, DiagnosticLog& log) {
  Program program = load_program({"fuzz.sm5", input.program}, log, input.reading);
  program.patterns = subprograms_of(input.subprograms);
  return program;
}

/// Passes the job through every writer; each has to finish, but for the two that write programs,
/// which may refuse.
inline std::optional<std::string> all_writers_complaint(const Program& program,
                                                        const WalkOptions& options,
                                                        const Survey& survey) {
  StringSink jsonl_text;
  StringSink csv_text;
  StringSink excellon_text;
  StringSink sieb_meyer_text;
  StringSink svg_text;
  JsonlWriter jsonl(jsonl_text);
  CsvWriter csv(csv_text);
  const bool is_kept = options.structure == Structure::Kept;
  const ProgramWriterOptions writing = {
      .comments = {"fuzzed"}, .allow_losses = is_kept, .keeps_vision = is_kept};
  ExcellonWriter excellon(excellon_text, writing);
  SiebMeyerWriter sieb_meyer(sieb_meyer_text, writing);
  Tally tally;
  DiagnosticLog ignored;
  if (is_kept) {
    Tee tee({&excellon, &sieb_meyer});
    execute(program, options, survey, tee, ignored);
    (void)excellon.finish();
    (void)sieb_meyer.finish();
    return std::nullopt;
  }
  Tee tee({&jsonl, &csv, &excellon, &sieb_meyer, &tally});
  execute(program, options, survey, tee, ignored);
  SvgWriter svg(svg_text, {});
  execute(program, options, survey, svg, ignored);
  (void)excellon.finish();
  (void)sieb_meyer.finish();
  if (!jsonl.finish() || !csv.finish() || !svg.finish()) return "a writer fails";
  return std::nullopt;
}

/// Checking and execution count the same operations: a limit of their number passes, one less does
/// not. The limit on idle lines is far above both.
inline std::optional<std::string> count_complaint(const Program& program,
                                                  const WalkOptions& options) {
  NominalSource source;
  DiagnosticLog log;
  const Survey found = survey(program, options, source, log);
  if (log.has_errors() || !found.is_complete()) return std::nullopt;
  CountingSink sink;
  if (auto complaint = execution_complaint(program, options, found, sink)) return complaint;
  const auto is_refused_with = [&](std::int64_t most) {
    WalkOptions limited = options;
    limited.max_operations = most;
    DiagnosticLog limited_log;
    survey(program, limited, source, limited_log);
    const std::string refusal = "more than " + std::to_string(most) + " operations";
    return std::ranges::any_of(limited_log.kept(), [&](const Diagnostic& diagnostic) {
      return diagnostic.code == Code::TooManyOperations && diagnostic.what == refusal;
    });
  };
  const std::int64_t n = sink.n_counted();
  if (n > 0 && !is_refused_with(n - 1)) {
    return "checking counts fewer than " + std::to_string(n) + " operations";
  }
  if (is_refused_with(n)) {
    return "checking counts more than " + std::to_string(n) + " operations";
  }
  return std::nullopt;
}

/// Translation: structure, slots and vision sequences are passed on whole.
inline std::optional<std::string> translation_complaint(const Program& program,
                                                        WalkOptions options) {
  options.structure = Structure::Kept;
  options.slots = options.step_slots = Cycles::Kept;
  NominalSource source;
  DiagnosticLog log;
  const Survey found = survey(program, options, source, log);
  if (log.has_errors()) return std::nullopt;
  CountingSink sink;
  if (auto complaint = execution_complaint(program, options, found, sink)) return complaint;
  if (!sink.is_finite()) return "a place of a kept pattern is not finite";
  return all_writers_complaint(program, options, found);
}

/// Reads, checks, executes and writes any bytes as a SIEB & MEYER program.
///
/// Out    what is wrong with panelcal, never with the program; empty if all is well
inline std::optional<std::string> run_sieb_meyer(std::string_view bytes) {
  const SiebMeyerInput input = split_input(bytes);
  DiagnosticLog log;
  const Program program = load_input(input, log);
  const bool is_read = !log.has_errors();
  BentSource source;
  BentProbes probes;
  const Survey found = survey(program, input.options, source, probes, log);
  if (auto complaint = report_complaint(log, found)) return complaint;
  for (const ProbeReading& reading : found.probes) {
    if (to_json(reading).empty()) return "a probe reading without a text";
  }
  if (is_read) {
    if (auto complaint = translation_complaint(program, input.options)) return complaint;
  }
  if (log.has_errors()) return std::nullopt;
  if (!found.is_complete()) return "the survey is not complete, and no error says so";

  CountingSink first;
  if (auto complaint = execution_complaint(program, input.options, found, first)) return complaint;
  CountingSink second;
  if (auto complaint = execution_complaint(program, input.options, found, second)) return complaint;
  if (!first.is_finite()) return "a place or a depth that is not finite";
  if (!(first == second)) return "two executions differ";
  BentSource again;
  BentProbes probes_again;
  if (auto complaint = checked_complaint(program, input.options, found, again, probes_again)) {
    return complaint;
  }
  if (auto complaint = count_complaint(program, input.options)) return complaint;
  if (auto complaint = gcode_complaint(program, input.options, found, first.most_mm())) {
    return complaint;
  }
  return all_writers_complaint(program, input.options, found);
}

}  // namespace panelcal::fuzz
