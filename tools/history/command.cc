// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include "tools/history/facts.h"
#include "tools/history/job.h"
#include "tools/history/surface.h"
#include "tools/history/text.h"
#include "tools/history/verify.h"
#include "tools/page/page.h"
#include <fmt/format.h>

namespace panelcal {
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

std::string_view command_word(HistoryOptions::Action action) {
  using Action = HistoryOptions::Action;
  switch (action) {
    case Action::List:
      return "list";
    case Action::Show:
      return "show";
    case Action::Diff:
      return "diff";
    case Action::RollBack:
      return "rollback";
    case Action::FreshStart:
      return "fresh-start";
    case Action::Plot:
      return "plot";
    case Action::Verify:
      return "verify";
    case Action::Export:
      break;
  }
  return "export";
}

/// One call of `panelcal history`.
class History {
 public:
  History(const HistoryOptions& options, CommandContext& context, Ledger ledger)
      : options_(options), context_(context), ledger_(std::move(ledger)) {}

  /// Text to print.
  Expected<std::string> answer() {
    using Action = HistoryOptions::Action;
    switch (options_.action) {
      case Action::List:
      case Action::Export:
        return list();
      case Action::Show:
        return show();
      case Action::Diff:
        return diff();
      case Action::RollBack:
        return roll_back();
      case Action::FreshStart:
        return fresh_start();
      case Action::Plot:
        return plot();
      case Action::Verify:
        return verify();
    }
    return std::string();
  }

  /// The document of facts; to be called after answer().
  Json document() const {
    Json out = facts::envelope("history", kHistoryVersion);
    out["command"] = command_word(options_.action);
    out["ledger_file"] = options_.ledger;
    out.update(members_);
    Json& rows = out["provenance"] = Json::object();
    const Provenance& provenance =
        provenance_.empty() ? Provenance{command_line_row(context_.options)} : provenance_;
    for (const auto& [key, value] : provenance) rows[key] = value;
    return out;
  }

  bool wants_facts() const { return !options_.json.empty() || !options_.report.empty(); }

 private:
  Expected<bool> is_in_force(const LedgerEntry& entry) const {
    PANELCAL_TRY(const std::optional<LedgerEntry> present, ledger_.in_force(entry.record.key));
    return present && present->id == entry.id;
  }

  /// Into the document.
  Expected<bool> add_entry(const LedgerEntry& entry) {
    PANELCAL_TRY(const bool in_force, is_in_force(entry));
    if (wants_facts()) members_["entries"].push_back(history::entry_facts(entry, in_force));
    return in_force;
  }

  Expected<std::string> list() {
    PANELCAL_TRY(const LedgerFilter filter, filter_of(options_));
    const bool exports = options_.action == HistoryOptions::Action::Export;
    members_["entries"] = Json::array();
    std::string text;
    const auto add = [&](const LedgerEntry& entry) -> Expected<void> {
      PANELCAL_TRY(const bool in_force, add_entry(entry));
      if (exports) {
        PANELCAL_TRY(const std::string result, ledger_.result(entry.id));
        text += history::entry_json(entry, in_force, result);
      } else {
        text += history::entry_line(entry, in_force);
      }
      return {};
    };
    PANELCAL_CHECK(ledger_.for_each(filter, add));
    return text;
  }

  Expected<std::string> show() {
    const std::int64_t id = options_.ids.front();
    PANELCAL_TRY(const LedgerEntry entry, ledger_.entry(id));
    PANELCAL_TRY(const std::string result, ledger_.result(id));
    PANELCAL_TRY(const bool in_force, add_entry(entry));
    if (wants_facts()) {
      members_["entries"].back()["result"] = Json::parse(result, nullptr, false);
    }
    return options_.result ? result : history::entry_page(entry, in_force);
  }

  Expected<std::string> diff() {
    PANELCAL_TRY(const LedgerEntry before, ledger_.entry(options_.ids.at(0)));
    PANELCAL_TRY(const LedgerEntry after, ledger_.entry(options_.ids.at(1)));
    PANELCAL_TRY(const auto changes, history::changes_between(before, after, options_.ledger));
    PANELCAL_CHECK(add_entry(before));
    PANELCAL_CHECK(add_entry(after));
    Json& difference = members_["difference"];
    difference = {{"before", before.id},
                  {"after", after.id},
                  {"parameters", history::changes_facts(changes)}};
    const std::string text = history::changes_text(changes);
    const bool is_of_surfaces = before.record.key.kind == LedgerKind::Surface;
    if (options_.program.empty() && !is_of_surfaces) return text;
    PANELCAL_TRY(const std::string result_before, ledger_.result(before.id));
    PANELCAL_TRY(const std::string result_after, ledger_.result(after.id));
    const history::CalibrationEntry was = {before, result_before}, is = {after, result_after};
    const bool is_of_job = !options_.program.empty();
    PANELCAL_TRY(const history::Answer more,
                 is_of_job ? history::job_answer(options_, context_, was, is)
                           : history::surface_answer(was, is, options_.ledger));
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

  /// Without the star: the text says what was recorded.
  Expected<std::string> recorded(const LedgerEntry& entry) {
    PANELCAL_CHECK(add_entry(entry));
    return history::entry_line(entry, false);
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

  Expected<std::string> plot() {
    PANELCAL_TRY(const LedgerKind kind, kind_of(options_.kind));
    const LedgerKey key{options_.machine, kind, options_.subject};
    PANELCAL_TRY(const LedgerSeries series, ledger_.series(key, options_.parameter));
    PANELCAL_TRY(std::string text,
                 history::series_text(series, key, options_.parameter, options_.ledger));
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
    PANELCAL_TRY(history::Answer answer, history::verify_answer(options_, context_, ledger_));
    members_["verification"] = std::move(answer.part);
    return std::move(answer.text);
  }

  const HistoryOptions& options_;
  CommandContext& context_;
  Ledger ledger_;
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

Expected<void> history_answer(const HistoryOptions& options, CommandContext& context) {
  for (const std::string* const output : {&options.output, &options.json, &options.report}) {
    PANELCAL_CHECK(check_no_record(*output, context));
  }
  using Action = HistoryOptions::Action;
  const bool records = options.action == Action::RollBack || options.action == Action::FreshStart;
  std::error_code ignored;
  if (records && !std::filesystem::exists(options.ledger, ignored)) {
    // If there is none, one would be started.
    return failure(
        {Code::FileUnreadable, {options.ledger, 0, 0}, "there is no such file", "a ledger"});
  }
  PANELCAL_TRY(Ledger ledger,
               records ? Ledger::open(options.ledger, system_clock())
                       : Ledger::open_to_read(options.ledger));
  History history(options, context, std::move(ledger));
  PANELCAL_TRY(const std::string text, history.answer());
  if (history.wants_facts()) {
    const std::string document = facts::text(history.document());
    if (!options.json.empty()) PANELCAL_CHECK(context.output.write_to(options.json, document));
    const std::string title = "history of " + options.ledger;
    if (!options.report.empty()) {
      PANELCAL_CHECK(context.output.write_to(options.report, page_html(title, document)));
    }
  }
  if (!options.output.empty()) return context.output.write_to(options.output, text);
  // Standard output has one of them.
  return options.json == "-" || options.report == "-" ? Expected<void>()
                                                      : context.output.write(text);
}

}  // namespace

ExitCode run_command(const HistoryOptions& options, CommandContext& context) {
  const Expected<void> done = history_answer(options, context);
  if (done) return ExitCode::Done;
  context.console.print(done.error());
  return exit_code(done.error());
}

}  // namespace panelcal
