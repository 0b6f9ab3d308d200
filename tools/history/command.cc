// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/ledger/ledger.h"
#include "machine/nightly/record/night_history.h"
#include "machine/nightly/record/noted_heads.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include "tools/history/certificate/facts.h"
#include "tools/history/certificate/maker.h"
#include "tools/history/facts.h"
#include "tools/history/job.h"
#include "tools/history/surface.h"
#include "tools/history/text.h"
#include "tools/history/verify.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

using facts::Json;

constexpr int kHistoryVersion = 1;

Diagnostic history_usage(std::string what, std::string expected) {
  return {Code::Usage, {"panelcal history", 0, 0}, std::move(what), std::move(expected)};
}

/// A day, or a second of one.
Expected<std::chrono::sys_seconds> time_of(const std::string& text) {
  if (const auto time = from_iso_8601(text)) return *time;
  if (const auto time = from_iso_8601(text + "T00:00:00Z")) return *time;
  return failure(
      history_usage("--since " + quoted(text), "2026-11-21 or 2026-11-21T08:37:38Z (UTC)"));
}

Expected<LedgerKind> kind_of(const std::string& text) {
  if (const auto kind = ledger_kind(text)) return *kind;
  const std::string_view near = nearest_word(text, ledger_kind_words());
  return failure(history_usage("--kind " + quoted(text),
                               near.empty()
                                   ? fmt::format("one of {}", fmt::join(ledger_kind_words(), ", "))
                                   : "did you mean " + quoted(near) + "?"));
}

Expected<LedgerFilter> filter_of(const HistoryOptions& options) {
  LedgerFilter filter;
  if (!options.machine.empty()) filter.machine = options.machine;
  if (!options.subject.empty()) filter.subject = options.subject;
  filter.last = options.last;
  if (!options.kind.empty()) {
    PANELCAL_TRY(filter.kind, kind_of(options.kind));
  }
  if (!options.since.empty()) {
    PANELCAL_TRY(filter.since, time_of(options.since));
  }
  return filter;
}

/// One call of `panelcal history`.
class History {
 public:
  History(const HistoryOptions& options, CommandContext& context, Ledger ledger)
      : options_(options), context_(context), ledger_(std::move(ledger)) {}

  /// The document of facts; to be called after one of the commands.
  Json document() const {
    Json out = facts::envelope(facts_kind_, kHistoryVersion);
    const std::string& command = context_.options.command_name;
    out["command"] = command.substr(command.rfind(' ') + 1);
    out["ledger_file"] = options_.ledger;
    out.update(members_);
    Json& rows = out["provenance"] = Json::object();
    const Provenance& provenance =
        provenance_.empty() ? Provenance{command_line_row(context_.options)} : provenance_;
    for (const auto& [key, value] : provenance) rows[key] = value;
    return out;
  }

  // The commands: the text to print.

  Expected<std::string> list() { return entries(false); }
  Expected<std::string> export_entries() { return entries(true); }

  Expected<std::string> show() {
    const std::int64_t id = options_.ids.front();
    PANELCAL_TRY(const LedgerEntry entry, ledger_.entry(id));
    PANELCAL_TRY(const std::string result, ledger_.result(id));
    PANELCAL_TRY(const bool in_force, add_entry(entry));
    if (options_.facts.any()) {
      members_["entries"].back()["result"] = Json::parse(result, nullptr, false);
    }
    return options_.result ? result : entry_page(entry, in_force);
  }

  Expected<std::string> diff() {
    PANELCAL_TRY(const LedgerEntry before, ledger_.entry(options_.ids.at(0)));
    PANELCAL_TRY(const LedgerEntry after, ledger_.entry(options_.ids.at(1)));
    PANELCAL_TRY(const auto changes, changes_between(before, after, options_.ledger));
    PANELCAL_CHECK(add_entry(before));
    PANELCAL_CHECK(add_entry(after));
    Json& difference = members_["difference"];
    difference = {
        {"before", before.id}, {"after", after.id}, {"parameters", changes_facts(changes)}};
    const std::string text = changes_text(changes);
    const bool is_of_surfaces = before.record.key.kind == LedgerKind::Surface;
    if (options_.program.empty() && !is_of_surfaces) return text;
    PANELCAL_TRY(const std::string result_before, ledger_.result(before.id));
    PANELCAL_TRY(const std::string result_after, ledger_.result(after.id));
    const CalibrationEntry was = {before, result_before}, is = {after, result_after};
    const bool is_of_job = !options_.program.empty();
    PANELCAL_TRY(const AnswerPart more,
                 is_of_job ? job_answer(options_, context_, was, is)
                           : surface_answer(was, is, options_.ledger));
    difference[is_of_job ? "job" : "surface"] = more.part;
    provenance_ = more.provenance;
    return text + more.text;
  }

  Expected<std::string> roll_back() {
    PANELCAL_TRY(const LedgerKind kind, kind_of(options_.kind));
    PANELCAL_TRY(const LedgerEntry entry,
                 ledger_.roll_back({{options_.machine, kind, options_.subject},
                                    options_.to,
                                    options_.reason,
                                    asking_person(options_.asked_by),
                                    std::string("panelcal ") + kVersion}));
    return recorded(entry);
  }

  Expected<std::string> fresh_start() {
    PANELCAL_TRY(const LedgerKind kind, kind_of(options_.kind));
    const LedgerKey key{options_.machine, kind, options_.subject};
    PANELCAL_CHECK(check_known(key));
    PANELCAL_TRY(const LedgerEntry entry,
                 mark_fresh_start(ledger_,
                                  key,
                                  {options_.reason,
                                   asking_person(options_.asked_by),
                                   std::string("panelcal ") + kVersion}));
    return recorded(entry);
  }

  Expected<std::string> plot() {
    PANELCAL_TRY(const LedgerKind kind, kind_of(options_.kind));
    const LedgerKey key{options_.machine, kind, options_.subject};
    PANELCAL_TRY(const LedgerSeries series, ledger_.series(key, options_.parameter));
    PANELCAL_TRY(std::string text, series_text(series, key, options_.parameter, options_.ledger));
    members_["parameter"] = options_.parameter;
    // Rollbacks too: what was in force follows from them.
    const auto add = [&](const LedgerEntry& entry) -> Expected<void> {
      const bool is_rollback = entry.record.verdict == LedgerVerdict::RolledBack;
      if (!is_rollback && !entry.record.find(options_.parameter)) return {};
      PANELCAL_CHECK(add_entry(entry));
      return {};
    };
    PANELCAL_CHECK(
        ledger_.for_each({.machine = key.machine, .kind = key.kind, .subject = key.subject}, add));
    return text;
  }

  Expected<std::string> verify() {
    PANELCAL_TRY(AnswerPart answer, verify_answer(options_, context_, ledger_));
    members_["verification"] = std::move(answer.part);
    return std::move(answer.text);
  }

  Expected<std::string> certificate() {
    PANELCAL_TRY(const MachineConfig config, read_machine_config(options_.machine_file));
    CertificateInput input{config, options_.ledger, options_.plate, std::nullopt};
    if (input.plate_file.empty() && config.nightly) {
      input.plate_file = config.nightly->table.plate.string();
    }
    if (!options_.since.empty()) {
      PANELCAL_TRY(input.since, time_of(options_.since));
    }
    PANELCAL_TRY(AnswerPart verified, verify_answer(options_, context_, ledger_));
    PANELCAL_TRY(const Certificate certificate, certificate_of(ledger_, input));
    facts_kind_ = "certificate";
    members_ = certificate_facts(certificate);
    members_["verification"] = std::move(verified.part);
    provenance_ = file_digests({options_.machine_file, input.plate_file});
    provenance_.insert(provenance_.begin(), command_line_row(context_.options));
    return certificate_text(certificate, verified.text);
  }

 private:
  Expected<bool> is_in_force(const LedgerEntry& entry) const {
    PANELCAL_TRY(const std::optional<LedgerEntry> present, ledger_.in_force(entry.record.key));
    return present && present->id == entry.id;
  }

  /// Into the document.
  Expected<bool> add_entry(const LedgerEntry& entry) {
    PANELCAL_TRY(const bool in_force, is_in_force(entry));
    if (options_.facts.any()) members_["entries"].push_back(entry_facts(entry, in_force));
    return in_force;
  }

  Expected<std::string> entries(bool exports) {
    PANELCAL_TRY(const LedgerFilter filter, filter_of(options_));
    members_["entries"] = Json::array();
    std::string text;
    const auto add = [&](const LedgerEntry& entry) -> Expected<void> {
      PANELCAL_TRY(const bool in_force, add_entry(entry));
      if (exports) {
        PANELCAL_TRY(const std::string result, ledger_.result(entry.id));
        text += entry_json(entry, in_force, result);
      } else {
        text += entry_line(entry, in_force);
      }
      return {};
    };
    PANELCAL_CHECK(ledger_.for_each(filter, add));
    return text;
  }

  /// Without the star: the text says what was recorded.
  Expected<std::string> recorded(const LedgerEntry& entry) {
    PANELCAL_CHECK(add_entry(entry));
    return entry_line(entry, false);
  }

  /// A misspelt subject would be noted for something that no night ever calibrates.
  Expected<void> check_known(const LedgerKey& key) const {
    PANELCAL_TRY(const std::vector<LedgerEntry> entries, ledger_.list(key, 1));
    if (!entries.empty() || key == self_test_key(key.machine)) return {};
    return failure(
        {Code::LedgerEntryUnknown,
         {options_.ledger, 0, 0},
         fmt::format("{} {} of {}", word(key.kind), quoted(key.subject), quoted(key.machine)),
         "what `panelcal history list` shows"});
  }

  const HistoryOptions& options_;
  CommandContext& context_;
  Ledger ledger_;
  std::string_view facts_kind_ = "history";
  Json members_ = Json::object();
  Provenance provenance_;
};

/// Without machine.toml the folder of reports is not known: what a file says counts. No answer
/// notes a head, so that none of them takes such a file's place.
Expected<void> check_no_record(const std::string& output, const CommandContext& context) {
  std::error_code ignored;
  if (output.empty() || output == "-" || !std::filesystem::is_regular_file(output, ignored)) {
    return {};
  }
  constexpr std::size_t kMaxRecordBytes = std::size_t{1} << 28;
  const Expected<std::string> bytes = read_file(output, kMaxRecordBytes);
  if (!bytes || !is_record_with_head(*bytes)) return {};
  return failure({Code::OutputInUse,
                  {context.options.command_name, 0, 0},
                  quoted(output) + " is a record that notes the head of a ledger",
                  "a file of its own for each output"});
}

using Make = Expected<std::string> (History::*)();

Expected<Answer> answer(const HistoryOptions& options, CommandContext& context, Make make) {
  for (const std::string& output : {options.output, options.facts.json, options.facts.report}) {
    PANELCAL_CHECK(check_no_record(output, context));
  }
  const bool appends = make == &History::roll_back || make == &History::fresh_start;
  std::error_code ignored;
  if (appends && !std::filesystem::exists(options.ledger, ignored)) {
    // If there is none, one would be started.
    return failure(
        {Code::FileUnreadable, {options.ledger, 0, 0}, "there is no such file", "a ledger"});
  }
  PANELCAL_TRY(Ledger ledger,
               appends ? Ledger::open(options.ledger, system_clock())
                       : Ledger::open_to_read(options.ledger));
  History history(options, context, std::move(ledger));
  PANELCAL_TRY(const std::string text, (history.*make)());
  const auto document = [&] { return facts::text(history.document()); };
  Answer answer =
      state_facts(context, options.facts, "history of " + options.ledger, document, {text});
  if (options.output.empty()) return answer;
  PANELCAL_CHECK(context.output.write_to(options.output, text));
  answer.text.clear();
  return answer;
}

}  // namespace

Expected<Answer> list(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::list);
}

Expected<Answer> export_entries(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::export_entries);
}

Expected<Answer> show(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::show);
}

Expected<Answer> diff(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::diff);
}

Expected<Answer> roll_back(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::roll_back);
}

Expected<Answer> fresh_start(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::fresh_start);
}

Expected<Answer> plot(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::plot);
}

Expected<Answer> verify(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::verify);
}

Expected<Answer> certify(const HistoryOptions& options, CommandContext& context) {
  return answer(options, context, &History::certificate);
}

}  // namespace panelcal::history
