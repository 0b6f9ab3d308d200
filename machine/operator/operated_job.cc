// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/operated_job.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "machine/job/facts/job_facts.h"
#include "machine/job/facts/seen_pictures.h"
#include "machine/job/facts/survey_facts.h"
#include "machine/job/job.h"
#include "machine/job/output/output.h"
#include "machine/nightly/record/noted_heads.h"
#include "machine/operator/job_folder.h"
#include "machine/operator/operator_source.h"
#include "machine/operator/picture_feed.h"
#include "machine/operator/recheck.h"
#include "vision/suggest/common_scale.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::string_view kUnnamedOutput = "the corrected program";
constexpr std::chrono::milliseconds kPersonInterval{60'000};

using Rows = std::vector<std::pair<std::string, std::string>>;

std::string choice_row(const JobChoice& choice) {
  return fmt::format("{}, by {}, {}", choice.what, choice.who, choice.when);
}

/// From the order to the verdict.
class OperatedJob {
 public:
  OperatedJob(const StationSettings& settings, const JobOrder& order, Desk& desk)
      : settings_(settings), order_(order), desk_(desk) {}

  void run() {
    if (const Expected<void> ready = prepare(); !ready) return fail(ready.error());
    const JobSinks sinks{.output = output_.get(),
                         .fitted = [this](const Survey& survey) { show_fits(survey); },
                         .measured = [this](const Survey& survey) { return note(survey); },
                         .log = &log_};
    const OpenJobSources open = [this](const Survey& nominal) { return open_source(nominal); };
    const Expected<JobResult> result = correct(opened_.job, open, opened_.machine, sinks);
    // A job that the station's end cuts off stays resumable, as one that was killed.
    if (desk_.is_closing() && !result) return;
    if (!result) return fail(result.error());
    if (const Expected<void> stated = state_facts(*result); !stated) return fail(stated.error());
    conclude(*result);
  }

 private:
  Expected<void> prepare() {
    PANELCAL_TRY(opened_,
                 open_program(settings_.machine_file,
                              settings_.jobs_folder / "programs" / order_.program,
                              settings_.clock()));
    if (!order_.program_sha256.empty() && opened_.program_sha256 != order_.program_sha256) {
      return failure(
          refused("program " + quoted(order_.program) + " has changed since it was checked",
                  "the program opened again"));
    }
    PANELCAL_CHECK(open_folder());
    Job& job = opened_.job;
    job.format = output_format(job.program);
    job.compares_models = job.finds_worst_place = job.keeps_places = true;
    note_provenance();
    desk_.change([&](Screen& screen) {
      ScreenJob& shown = *screen.job;
      shown = checked_job(opened_, order_.id, order_.program);
      shown.state = JobState::Measuring;
    });
    output_ = std::make_unique<FileOutput>(folder_->file("output"));
    feed_.emplace(desk_, opened_.machine.vision, opened_.machine.locate.max_blur_px);
    return {};
  }

  Expected<void> open_folder() {
    if (order_.is_resumed) {
      PANELCAL_TRY(JobFolder folder, JobFolder::open(settings_.jobs_folder, order_.id));
      folder_.emplace(std::move(folder));
      return folder_->set_state(JobState::Measuring);
    }
    PANELCAL_TRY(JobFolder folder, JobFolder::create(settings_.jobs_folder, new_record()));
    folder_.emplace(std::move(folder));
    return {};
  }

  JobRecord new_record() const {
    JobRecord record;
    record.id = order_.id;
    record.program = order_.program;
    record.program_sha256 = opened_.program_sha256;
    record.machine_sha256 = machine_digest(opened_.machine);
    record.source = desk_.read([](const Screen& screen) { return screen.source; });
    record.who = order_.who;
    record.started = iso_8601(settings_.clock());
    return record;
  }

  void note_provenance() {
    provenance_ = {
        {"made by", settings_.software},
        {"job", fmt::format("{}, started by {}", order_.id, order_.who)},
        {"program", fmt::format("{}, SHA-256 {}", order_.program, opened_.program_sha256)},
        {"machine",
         fmt::format("{}, SHA-256 {}",
                     opened_.machine.file.filename().string(),
                     machine_digest(opened_.machine))}};
    note_comments();
  }
  void note_comments() {
    opened_.job.comments.clear();
    for (const auto& [key, value] : provenance_) opened_.job.comments.push_back(key + ": " + value);
  }

  SourceChoice source_choice() {
    return {.command = "panelcal serve",
            .images = settings_.images,
            .measurements = {},
            .camera = settings_.camera,
            .machine_driver = settings_.machine_driver,
            .probes = {},
            .observer =
                [this](const SeenView& seen) {
                  feed_->see(seen);
                  keep_(seen);
                  scale_.add(seen.detection);
                },
            .prompt = [this]() -> Expected<Prompt> {
              return Prompt([this](std::string_view what) { return have_done(what); });
            },
            .taken_by = {settings_.clock, order_.who, settings_.software, [this] {
                           return check_noted_heads(opened_.machine);
                         }}};
  }

  /// Asks a person to do something, and waits until it is done.
  Expected<void> have_done(std::string_view what) {
    ScreenQuestion question;
    question.id = ++n_asked_;
    question.reason = std::string(what);
    question.choices = {"done", "stop"};
    desk_.change([&](Screen& screen) {
      screen.job->state = JobState::Asking;
      screen.job->question = std::move(question);
    });
    while (true) {
      const Desk::Word word = desk_.wait_for_word(kPersonInterval);
      if (word.must_stop) return failure(stopped());
      if (!word.answer) continue;
      return folder_->append(JobChoice{
          -1, "done: " + std::string(what), word.answer->who, iso_8601(settings_.clock())});
    }
  }

  /// The first error of a check of the program where these measurements are of left-out boards.
  std::string why_not_leave_out(const std::set<std::size_t>& left_out) const {
    class Panel final : public MeasurementSource {
     public:
      explicit Panel(const std::set<std::size_t>& left_out) : left_out_(left_out) {}
      Expected<Measurement> measure(const MeasurementRequest& request) override {
        PANELCAL_TRY(Measurement out, NominalSource().measure(request));
        const bool is_out = request.is_of_left_out_board ||
                            left_out_.contains(static_cast<std::size_t>(request.seq));
        if (is_out) out.status = MeasurementStatus::BoardLeftOut;
        return out;
      }

     private:
      const std::set<std::size_t>& left_out_;
    } panel(left_out);
    WalkOptions options = opened_.machine.walk;
    options.base_limits = options.nested_limits = {};
    options.fitted = {};
    DiagnosticLog log;
    const Survey survey = panelcal::survey(opened_.job.program, options, panel, log);
    for (const Diagnostic& problem : log.kept()) {
      if (problem.severity() == Severity::Error) return problem.message();
    }
    const auto is_drilled = [](const SeriesResult& series) {
      return !series.path.empty() && !series.is_left_out;
    };
    return std::ranges::any_of(survey.series, is_drilled) ? "" : "no board would be left";
  }

  Expected<JobSources> open_source(const Survey& nominal) {
    PANELCAL_TRY(JobSources sources, open_sources(source_choice(), opened_.machine, nominal));
    nominal_ = nominal;
    const auto counted = held_measurements(*sources.targets);
    if (!counted) return failure(counted.error());
    const bool is_excellon = opened_.job.program.dialect == Dialect::Excellon;
    const OperatorSource::Station station{
        .desk = desk_,
        .folder = *folder_,
        .feed = *feed_,
        .machine = opened_.machine,
        .nominal = nominal_,
        .clock = settings_.clock,
        .n_questions = n_asked_,
        .may_skip = is_excellon,
        .may_jog = settings_.images.empty(),
        .is_live = !settings_.camera.empty(),
        .why_not_leave_out = [this](const auto& left_out) { return why_not_leave_out(left_out); }};
    sources.targets =
        std::make_shared<OperatorSource>(station, sources.targets, sources.eye, *counted);
    return sources;
  }

  // --- after an interruption --------------------------------------------------------------------

  /// The measurements that count again, by seq.
  Expected<std::map<std::int64_t, Measurement>> held_measurements(MeasurementSource& source) {
    std::map<std::int64_t, Measurement> held;
    if (!order_.is_resumed) return held;
    const std::vector<Measurement> measured = folder_->measurements();
    PANELCAL_TRY(const ScreenAgain again, look_again_at(measured, source));
    desk_.change([&](Screen& screen) { screen.job->again = again; });
    provenance_.emplace_back("resumed", fmt::format("{}, by {}", again.words, order_.who));
    if (!counts_) {
      PANELCAL_CHECK(folder_->begin_anew(new_record()));
      return held;
    }
    for (const Measurement& one : measured) held.emplace(one.request.seq, one);
    return held;
  }

  Expected<ScreenAgain> look_again_at(const std::vector<Measurement>& measured,
                                      MeasurementSource& source) {
    ScreenAgain again;
    const auto anew = [&](std::string why) {
      again.words = std::move(why) + ": all targets are measured anew";
      return again;
    };
    const JobRecord& record = folder_->record();
    if (record.program_sha256 != opened_.program_sha256) return anew("the program has changed");
    if (record.source != new_record().source) return anew("the pictures come from elsewhere");
    if (record.machine_sha256 != machine_digest(opened_.machine)) {
      return anew("machine.toml or a calibration has changed");
    }
    if (!nominal_.calibrations.empty()) return anew("the program calibrates between its targets");
    const auto pair = farthest_pair(measured);
    if (!pair) return anew("fewer than two targets were measured");
    const Measurement& first = measured[pair->first];
    const Measurement& second = measured[pair->second];
    again.seqs = {first.request.seq, second.request.seq};
    again.words = "two of the measured targets are looked at again";
    desk_.change([&](Screen& screen) { screen.job->again = again; });
    PANELCAL_TRY(const Recheck recheck,
                 look_again(first, second, nominal_, opened_.machine.walk.uncertainty, source));
    if (!recheck.agrees) return anew(recheck.words);
    counts_ = true;
    again.words = recheck.words + ": the others count";
    return again;
  }

  // --- while it runs ----------------------------------------------------------------------------

  void show_fits(const Survey& survey) {
    desk_.change([&](Screen& screen) { show_series(survey, *screen.job); });
  }

  /// Before anything is written, so that the output says what people have decided.
  Expected<void> note(const Survey& survey) {
    desk_.change([&](Screen& screen) {
      show_series(survey, *screen.job);
      // A series may have chosen among the candidates of its targets.
      for (const Measurement& one : survey.measurements) {
        show_measured(one, screen.job->targets[static_cast<std::size_t>(one.request.seq)]);
      }
    });
    for (const JobChoice& choice : folder_->choices()) {
      provenance_.emplace_back("decision", choice_row(choice));
    }
    note_comments();
    return write_file(folder_->file("measurements.jsonl"), measurement_lines(survey));
  }

  // --- afterwards -------------------------------------------------------------------------------

  JobFactsInput all_facts_of(const JobResult& result) {
    JobFactsInput input = facts_input(result);
    input.program_file = order_.program;
    input.machine_name = opened_.machine.name;
    input.output_file = result.is_committed ? "output" : "";
    input.output_words = kUnnamedOutput;
    input.common_scale = scale_.words().value_or("");
    input.pictures = std::move(pictures_.by_seq);
    input.diagnostics = log_.kept();
    input.provenance = provenance_;
    input.provenance.emplace_back("date", iso_8601(settings_.clock()));
    return input;
  }

  Expected<void> state_facts(const JobResult& result) {
    if (auto warning = scale_.warning(settings_.machine_file.string()))
      log_.add(*std::move(warning));
    const JobFactsInput input = all_facts_of(result);
    verdict_ = facts::verdict_sentence(input) + " " + facts::next_step(input);
    const std::string facts = job_facts(input);
    PANELCAL_CHECK(write_file(folder_->file("facts.json"), facts));
    if (!settings_.page) return {};
    const std::string title = order_.program + " - panelcal";
    return write_file(folder_->file("report.html"),
                      settings_.page(title, facts, job_pictures(input)));
  }

  void conclude(const JobResult& result) {
    const bool may_drill = result.may_be_drilled() && result.is_committed;
    if (result.is_executed) n_holes_ = result.tally.n_holes();
    const JobState state = may_drill ? JobState::Done : JobState::Held;
    finish(state, ScreenVerdict{may_drill, verdict_}, [&](ScreenJob& job) {
      job.has_facts = true;
      job.has_report = settings_.page != nullptr;
    });
  }

  void fail(const Diagnostic& problem) {
    const bool is_stopped = desk_.is_stopped_by_person();
    if (!log_.has_errors()) log_.add(problem);
    // A signal ends this process: the job goes on with the next one.
    const JobState state = is_stopped                          ? JobState::Stopped
                           : problem.code == Code::Interrupted ? JobState::Resumable
                                                               : JobState::Failed;
    finish(state,
           ScreenVerdict{false, is_stopped ? "The job was stopped." : problem.text()},
           [](ScreenJob&) {});
  }

  template <class Change>
  void finish(JobState state, ScreenVerdict verdict, Change&& change) {
    if (folder_) {
      const Expected<void> kept = folder_->conclude(state, verdict.words, n_holes_);
      if (!kept) log_.add(kept.error());
    }
    desk_.change([&](Screen& screen) {
      ScreenJob& job = *screen.job;
      job.state = state;
      job.question.reset();
      job.verdict = std::move(verdict);
      job.n_holes = n_holes_;
      const bool is_told = log_.has_errors() || !log_.kept().empty();
      if (is_told) job.findings.assign(log_.kept().begin(), log_.kept().end());
      for (ScreenTarget& target : job.targets) {
        if (target.status == "looking") target.status = "waiting";
      }
      change(job);
    });
  }

  const StationSettings& settings_;
  const JobOrder& order_;
  Desk& desk_;
  OpenedProgram opened_;
  Survey nominal_;
  std::optional<JobFolder> folder_;
  std::optional<PictureFeed> feed_;
  SeenPictures pictures_;
  PictureObserver keep_ = pictures_.observer();
  CommonScale scale_;
  std::unique_ptr<JobOutput> output_;
  DiagnosticLog log_;
  Rows provenance_;
  std::string verdict_;
  std::optional<std::int64_t> n_holes_;
  int n_asked_ = 0;      ///< questions so far
  bool counts_ = false;  ///< what was measured before the interruption
};

bool is_cut_off(const JobRecord& record) {
  return is_running(record.state) || record.state == JobState::Resumable;
}

/// The job with what it had measured, and with its verdict if it has ended.
ScreenJob shown_of(const StationSettings& settings, const JobFolder& folder) {
  const JobRecord& record = folder.record();
  ScreenJob job;
  const auto opened = open_program(
      settings.machine_file, settings.jobs_folder / "programs" / record.program, settings.clock());
  if (opened) job = checked_job(*opened, record.id, record.program);
  if (!opened) job.findings = {opened.error()};
  job.id = record.id;
  job.program = record.program;
  job.state = is_cut_off(record) ? JobState::Resumable : record.state;
  for (const Measurement& one : folder.measurements()) {
    const auto i = static_cast<std::size_t>(one.request.seq);
    if (i < job.targets.size()) show_measured(one, job.targets[i]);
  }
  if (is_cut_off(record)) return job;
  std::error_code ignored;
  job.verdict = ScreenVerdict{record.state == JobState::Done,
                              with_output_name(record.verdict, record.outputs)};
  job.has_facts = std::filesystem::exists(folder.file("facts.json"), ignored);
  job.has_report = std::filesystem::exists(folder.file("report.html"), ignored);
  job.outputs = record.outputs;
  job.n_holes = record.n_holes;
  return job;
}

}  // namespace

void run_job(const StationSettings& settings, const JobOrder& order, Desk& desk) {
  OperatedJob(settings, order, desk).run();
}

std::optional<ScreenJob> last_job(const StationSettings& settings) {
  std::optional<ScreenJob> last;
  std::vector<std::string> ids = list_jobs(settings.jobs_folder);
  std::ranges::reverse(ids);
  bool is_newest = true;
  for (const std::string& id : ids) {
    Expected<JobFolder> folder = JobFolder::open(settings.jobs_folder, id);
    if (!folder) continue;
    const JobRecord& record = folder->record();
    if (std::exchange(is_newest, false)) {
      if (!record.is_closed) last = shown_of(settings, *folder);
    } else if (is_cut_off(record)) {
      // A newer job was begun; a record that cannot be written is met again at the next start.
      static_cast<void>(folder->set_state(JobState::Stopped));
    }
  }
  return last;
}

std::string with_output_name(std::string verdict, const std::vector<std::string>& outputs) {
  const auto at = verdict.find(kUnnamedOutput);
  if (at == std::string::npos || outputs.empty()) return verdict;
  return verdict.replace(at, kUnnamedOutput.size(), outputs.back());
}

std::string machine_digest(const MachineConfig& machine) {
  std::string digests;
  std::vector<std::filesystem::path> files = {
      machine.file, machine.camera_file, machine.table_file, machine.spindle_setting.file};
  for (const auto& [level, file] : machine.zoom_files) files.push_back(file);
  for (const std::filesystem::path& file : files) {
    if (file.empty()) continue;
    const auto bytes = read_file(file);
    digests += bytes ? sha256(*bytes) : "missing";
  }
  return sha256(digests);
}

}  // namespace panelcal::internal
