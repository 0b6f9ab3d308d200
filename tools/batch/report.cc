// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "calib/base/clock.h"
#include "machine/files/machine_files.h"
#include "tools/batch/manifest/manifest.h"
#include "tools/batch/output/facts.h"
#include "tools/batch/results.h"
#include "tools/batch/store/store.h"
#include "tools/batch/work/worker.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/output_paths.h"
#include <fmt/format.h>

namespace panelcal {
namespace batch {
namespace {

/// Looks at the worst targets' pictures once more, as far as they are still there: the facts get
/// their crops.
class WorstPictures {
 public:
  WorstPictures(Store& store, std::string clock, FileRegister& files)
      : store_(store), files_(files) {
    terms_.clock = std::move(clock);
  }

  Expected<PagePictures> look(facts::Json& facts) {
    terms_.now = system_clock()();
    for (facts::Json& one : facts["worst"]) {
      if (one["image"].get<std::string>().empty()) continue;
      PANELCAL_TRY(const DrawnJob* const drawn, drawn_job(one["job"].get<std::int64_t>()));
      if (drawn != nullptr) put(*drawn, one);
    }
    return std::move(pictures_);
  }

 private:
  /// Null for recorded measurements, and where the inputs are gone by now.
  Expected<const DrawnJob*> drawn_job(std::int64_t number) {
    if (const auto at = drawn_.find(number); at != drawn_.end()) {
      return at->second ? &*at->second : nullptr;
    }
    PANELCAL_TRY(const ManifestJob job, job_of(number));
    std::optional<DrawnJob>& drawn = drawn_[number];
    if (job.images.empty()) return nullptr;
    files_.add(job.program, "the program of job " + job.id);
    files_.add_folder(job.images, "the pictures of job " + job.id);
    add_machine_files(job.machine, files_);
    if (auto made = draw_job(job, terms_, machines_)) drawn = *std::move(made);
    return drawn ? &*drawn : nullptr;
  }

  Expected<ManifestJob> job_of(std::int64_t number) {
    PANELCAL_TRY(const auto rows,
                 store_.rows(fmt::format("SELECT id, program, machine_file, images, clock FROM job "
                                         "WHERE number = {}",
                                         number)));
    ManifestJob job;
    job.number = number;
    const auto text = [&](std::size_t i) {
      const auto* const found = std::get_if<std::string>(&rows.front()[i]);
      return found != nullptr ? *found : std::string();
    };
    job.id = text(0);
    job.program = text(1);
    job.machine = text(2);
    job.images = text(3);
    job.clock = text(4);
    return job;
  }

  void put(const DrawnJob& drawn, facts::Json& one) {
    const facts::Json document = facts::Json::parse(drawn.facts);
    for (const facts::Json& target : document["targets"]) {
      if (target["seq"] != one["seq"] || target["pictures"].empty()) continue;
      facts::Json crop = target["pictures"].front()["crop"];
      if (crop.is_null()) return;
      const auto bytes = drawn.pictures.find(crop["name"].get<std::string>());
      if (bytes == drawn.pictures.end()) return;
      const std::string name = fmt::format("{}-{}", one["job"].get<std::int64_t>(), bytes->first);
      crop["name"] = name;
      pictures_[name] = bytes->second;
      one["crop"] = std::move(crop);
    }
  }

  Store& store_;
  FileRegister& files_;  ///< gets what is read
  JobTerms terms_;
  MachineCache machines_;
  std::map<std::int64_t, std::optional<DrawnJob>> drawn_;
  PagePictures pictures_;
};

}  // namespace

Expected<Answer> report(const BatchReportOptions& options, CommandContext& context) {
  constexpr const char* kReportName = "panelcal batch report";
  PANELCAL_CHECK(check_extension(kReportName, options.facts.report, ".html"));
  PANELCAL_TRY(Store store, open_results_of(options.results));
  PANELCAL_TRY(facts::Json facts, batch_facts(store));
  PANELCAL_TRY(const PagePictures pictures,
               WorstPictures(store, facts["clock"].get<std::string>(), context.files).look(facts));
  PANELCAL_CHECK(check_outputs(context.options, context.files));
  Answer answer = state_facts(
      context,
      options.facts,
      facts["manifest"].get<std::string>() + " - panelcal",
      [&] { return facts::text(facts); },
      {},
      pictures);
  if (answer.code == ExitCode::Done && !options.facts.report.empty()) {
    context.console.say("report: " + options.facts.report);
  }
  return answer;
}

Expected<Answer> show(const BatchReportOptions& options, CommandContext& context) {
  PANELCAL_TRY(Store store, open_results_of(options.results));
  PANELCAL_TRY(const facts::Json facts, batch_facts(store));
  return state_facts(
      context, options.facts, "", [&] { return facts::text(facts); }, {batch_text(facts)});
}

}  // namespace batch
}  // namespace panelcal
