// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/interruption.h"
#include "calib/base/thread_pool.h"
#include "machine/align/measure.h"
#include "machine/config/machine_config.h"
#include "machine/job/facts/job_facts.h"
#include "machine/job/facts/seen_pictures.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/operator_prompt.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include "tools/run/fits_summary.h"
#include <fmt/format.h>

namespace panelcal::align {
namespace {

constexpr const char* kAlignCommand = "panelcal align";

Diagnostic align_usage(std::string what, std::string expected) {
  return {Code::Usage, {kAlignCommand, 0, 0}, std::move(what), std::move(expected)};
}

Provenance align_provenance(const AlignOptions& options,
                            const MachineConfig& machine,
                            const CommandContext& context) {
  Program none;
  Provenance rows = provenance_of(context.options,
                                  none,
                                  {options.pads,
                                   options.alignment,
                                   options.machine,
                                   machine.spindle_setting.file.string(),
                                   machine.table_file.string(),
                                   options.measurements});
  std::erase_if(rows, [](const auto& row) { return row.first == "sha256 "; });
  rows.emplace_back("date", iso_8601(system_clock()()));
  return rows;
}

/// A command that looks at pads, or at what came of it.
class AlignRun {
 public:
  AlignRun(const AlignOptions& options, CommandContext& context)
      : options_(options), context_(context), now_(system_clock()()) {}

  Expected<Answer> measure() {
    PANELCAL_CHECK(check_options());
    begin();
    PANELCAL_TRY(machine_, read_machine_config(options_.machine));
    PadChoice choice{.vision_tool = options_.vision_tool,
                     .n_best_holes = options_.n_best_holes,
                     .reading = options_.reading,
                     .read = [this](const Program& program) {
                       return check_patterns(context_.options, program, context_.files);
                     }};
    if (options_.diameter_mm) choice.diameter = mm(*options_.diameter_mm);
    PANELCAL_TRY(const PadList pads, read_pads(options_.pads, choice, machine_));
    context_.console.say(pads.words);
    DiagnosticLog log;
    const Expected<JobResult> result = measure_pads(pads, opener(), machine_, now_, sinks(log));
    if (!result) {
      context_.console.print(log);
      context_.console.say("nothing was written to " + options_.output);
      return Answer{{}, exit_code(log)};
    }
    PANELCAL_TRY(const Alignment alignment, alignment_of(pads, *result));
    if (!options_.save_measurements.empty()) {
      PANELCAL_CHECK(
          context_.output.write_to(options_.save_measurements, measurement_lines(*result->survey)));
    }
    PANELCAL_CHECK(context_.output.write_to(options_.output, alignment_text(alignment)));
    std::string summary = fits_summary(*result->survey);
    if (summary.ends_with('\n')) summary.pop_back();
    context_.console.say(summary);
    context_.console.print(log);
    const bool is_held = !alignment.held.empty();
    context_.console.say(fmt::format(
        "{} written to {}",
        is_held ? "the alignment is held: nothing is drilled by it; it is" : "alignment",
        options_.output));
    return state(*result, pads.file, is_held ? "" : options_.output, log);
  }

  Expected<Answer> verify() {
    begin();
    PANELCAL_TRY(machine_, read_machine_config(options_.machine));
    PANELCAL_TRY(Alignment alignment, read_alignment(options_.alignment));
    // Checks that run backwards in time make a file that is refused.
    PANELCAL_CHECK(check_age(alignment, now_, std::chrono::seconds::max()));
    PANELCAL_TRY(const AlignedPanel panel, restore_panel(alignment, machine_, now_));
    Expected<SecondLook> look = look_again(panel, machine_, opener());
    context_.console.end_progress();
    if (!look) return failure(of_alignment(std::move(look).error()));
    AlignmentCheck* const check = &look->check;
    check->time = now_;
    check->by = asking_person(options_.by);
    alignment.checks.push_back(*check);
    PANELCAL_CHECK(context_.output.write_to(options_.alignment, alignment_text(alignment)));
    if (look->lost) return failure(of_alignment(*std::move(look->lost)));
    const std::string words = fmt::format("pads {}: chi square {:.2f}, limit {:.2f}",
                                          fmt::join(check->pads, " and "),
                                          check->chi_square,
                                          check->limit);
    if (check->is_accepted) {
      return Answer{fmt::format("{}\nthe panel lies where it lay; the alignment counts from {}\n",
                                words,
                                iso_8601(check->time))};
    }
    return failure({Code::GateFailed,
                    {options_.alignment, 0, 0},
                    "the panel has moved: " + words,
                    "`panelcal align` again; if it has not moved, [uncertainty] "
                    "stage_repeatability_um of machine.toml is too small"});
  }

  Expected<Answer> show() {
    PANELCAL_TRY(machine_, read_machine_config(options_.machine));
    PANELCAL_TRY(const Alignment alignment, read_alignment(options_.alignment));
    Answer answer{text_of(alignment)};
    const auto valid = std::chrono::seconds(std::llround(options_.valid_hours * 3600));
    const Expected<void> age = check_age(alignment, now_, valid);
    const Expected<AlignedPanel> panel = restore_panel(alignment, machine_, now_);
    DiagnosticLog log;
    if (!panel) log.add(panel.error());
    if (!age) log.add(age.error());
    context_.console.print(log);
    if (!log.has_errors()) answer.text += "in force\n";
    answer.code = exit_code(log);
    if (!panel || !options_.facts.any()) return answer;
    JobFactsInput input;
    input.survey = panel->survey().get();
    input.source = alignment.source;
    return state_input(std::move(input),
                       options_.alignment,
                       log.has_errors() ? "" : options_.alignment,
                       log,
                       std::move(answer));
  }

 private:
  Diagnostic of_alignment(Diagnostic problem) const {
    if (problem.place.file.empty()) problem.place.file = options_.alignment;
    return problem;
  }

  void begin() {
    if (!options_.camera.empty()) heed_interruptions();
  }

  Expected<void> check_options() const {
    if (options_.pads.empty())
      return failure(align_usage("there are no PADS", "a list, or a file"));
    if (options_.machine.empty()) return failure(align_usage("there is no machine.toml", "-m"));
    if (options_.output.empty() || options_.output == "-") {
      return failure(align_usage("there is no file for the alignment", "-o board.align.json"));
    }
    return {};
  }

  OpenJobSources opener() {
    return [this](const Survey& nominal) {
      if (!options_.images.empty()) {
        pool_ = make_thread_pool(options_.n_threads, nominal.measurements.size());
      }
      SourceChoice choice{
          .command = kAlignCommand,
          .images = options_.images,
          .measurements = options_.measurements,
          .camera = options_.camera,
          .machine_driver = options_.machine_driver,
          .executor = pool_.get(),
          .prompt = [this] { return operator_prompt(kAlignCommand, context_.console); }};
      if (options_.facts.any()) choice.observer = pictures_.observer();
      return open_sources(choice, machine_, nominal);
    };
  }

  JobSinks sinks(DiagnosticLog& log) {
    return {.progress = [this](std::string_view text) { context_.console.progress(text); },
            .end_progress =
                [this](std::string_view remark) {
                  context_.console.end_progress();
                  if (!remark.empty()) context_.console.say(remark);
                },
            .log = &log};
  }

  Expected<Alignment> alignment_of(const PadList& pads, const JobResult& result) const {
    Alignment alignment{.file = options_.output,
                        .made_by = std::string("panelcal ") + kVersion,
                        .machine = machine_.name,
                        .panel = options_.panel,
                        .time = now_,
                        .by = asking_person(options_.by),
                        .source = result.source,
                        .pads = pads.words};
    PANELCAL_TRY(alignment.inputs, alignment_inputs(machine_));
    for (const Pad& pad : pads.pads) alignment.names.push_back(pad.name);
    put_result(result, alignment);
    return alignment;
  }

  static std::string text_of(const Alignment& alignment) {
    std::string text = fmt::format("{}{}, measured {} by {}\npads: {}\nfrom: {}\n",
                                   alignment.machine,
                                   alignment.panel.empty() ? "" : ", panel " + alignment.panel,
                                   iso_8601(alignment.time),
                                   alignment.by,
                                   alignment.pads,
                                   alignment.source);
    for (std::size_t i = 0; i < alignment.measurements.size(); ++i) {
      const Measurement& pad = alignment.measurements[i];
      const Eigen::Vector2d nominal_mm = pad.request.nominal.in_mm();
      text += fmt::format("pad {}{}{} ({:.4f}, {:.4f}) mm: ",
                          i + 1,
                          alignment.names[i].empty() ? "" : " ",
                          alignment.names[i],
                          nominal_mm.x(),
                          nominal_mm.y());
      if (pad.status != MeasurementStatus::Found) {
        text += fmt::format("{}: {}\n", name(pad.status), pad.reason);
        continue;
      }
      const Eigen::Vector2d seen_mm = pad.measured.position.in_mm();
      text += fmt::format("seen at ({:.4f}, {:.4f}) mm, sigma {:.2f} {:.2f} um\n",
                          seen_mm.x(),
                          seen_mm.y(),
                          std::sqrt(pad.measured.cov(0, 0)) * 1e3,
                          std::sqrt(pad.measured.cov(1, 1)) * 1e3);
    }
    if (alignment.fit) {
      text += fmt::format("fit: {}, chi square {:.2f} of {} degrees of freedom\n",
                          alignment.fit->model,
                          alignment.fit->chi_square,
                          alignment.fit->degrees_of_freedom);
    }
    for (const AlignmentGate& gate : alignment.gates) {
      text += fmt::format("gate {}: {:.4g} {}, limit {:.4g}{}\n",
                          gate.gate,
                          gate.value,
                          gate.unit,
                          gate.limit,
                          gate.is_accepted ? "" : ": exceeded");
    }
    for (const AlignmentCheck& check : alignment.checks) {
      text += fmt::format("looked again {} by {}: chi square {:.2f}, limit {:.2f}{}\n",
                          iso_8601(check.time),
                          check.by,
                          check.chi_square,
                          check.limit,
                          check.is_accepted      ? ""
                          : check.has_seen_all() ? ": moved"
                                                 : ": a pad was not found");
    }
    return text;
  }

  Expected<Answer> state(const JobResult& result,
                         const std::string& subject,
                         const std::string& output,
                         const DiagnosticLog& log) {
    Answer answer{{}, exit_code(log)};
    if (!options_.facts.any()) return answer;
    return state_input(facts_input(result), subject, output, log, std::move(answer));
  }

  Answer state_input(JobFactsInput input,
                     const std::string& subject,
                     const std::string& output,
                     const DiagnosticLog& log,
                     Answer answer) {
    input.program_file = subject;
    input.machine_name = machine_.name;
    input.output_file = output;
    input.pictures = std::move(pictures_.by_seq);
    input.diagnostics = log.kept();
    input.provenance = align_provenance(options_, machine_, context_);
    return state_facts(
        context_,
        options_.facts,
        subject + " - panelcal",
        [&] { return job_facts(input); },
        std::move(answer),
        job_pictures(input));
  }

  const AlignOptions& options_;
  CommandContext& context_;
  std::chrono::sys_seconds now_;
  MachineConfig machine_;
  SeenPictures pictures_;
  std::unique_ptr<ThreadPool> pool_;
};

}  // namespace

Expected<Answer> measure(const AlignOptions& options, CommandContext& context) {
  return AlignRun(options, context).measure();
}

Expected<Answer> verify(const AlignOptions& options, CommandContext& context) {
  return AlignRun(options, context).verify();
}

Expected<Answer> show(const AlignOptions& options, CommandContext& context) {
  return AlignRun(options, context).show();
}

}  // namespace panelcal::align
