// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include <fmt/format.h>

namespace panelcal::calibrate {
namespace {

using facts::Json;

constexpr int kCalibrationVersion = 1;

/// [[xx, xy], [xy, yy]], of any size; null if there is none.
Json square_rows(const std::optional<Eigen::MatrixXd>& values) {
  if (!values) return {};
  Json out = Json::array();
  for (const auto& row : values->rowwise()) {
    Json& line = out.emplace_back(Json::array());
    for (const double value : row) line.push_back(facts::number(value));
  }
  return out;
}

}  // namespace

Diagnostic usage(std::string what, std::string expected, std::string_view command) {
  return {Code::Usage, {std::string(command), 0, 0}, std::move(what), std::move(expected)};
}

Expected<Session> Session::begin(const CalibrateOptions& options) {
  Session session(options);
  const auto date = options.clock.empty() ? system_clock()() : from_iso_8601(options.clock);
  if (!date) {
    return failure(usage("--clock " + quoted(options.clock),
                         "a date and a time in UTC, such as 2026-11-21T02:00:00Z"));
  }
  session.words_.date = *date;
  session.words_.reason = options.reason;
  session.words_.software = std::string("panelcal ") + kVersion;
  // A name that only a ledger asks for.
  if (options.install) session.words_.asked_by = asking_person(options.asked_by);
  PANELCAL_TRY(MachineConfig config, read_machine_config(options.machine));
  session.config_ = std::make_shared<MachineConfig>(std::move(config));
  return session;
}

Expected<void> Session::check_install(std::string_view section,
                                      const std::filesystem::path& file) const {
  if (!options_.install) return {};
  if (!options_.output.empty()) {
    return failure(usage(
        "--install and --output together",
        fmt::format("one of them: --install writes the file that [{}] names", section),
        fmt::format("panelcal calibrate {}", section == "spindle" ? "spindle-camera" : section)));
  }
  if (!file.empty()) return {};
  return failure({Code::ConfigValue,
                  {config_->file.string(), 0, 0},
                  fmt::format("[{}] names no calibration that could be installed", section),
                  fmt::format("[{}] calibration = \"NAME.cal.json\"", section)});
}

Expected<void> Session::lock(bool drives) {
  const std::filesystem::path& file = config_->ledger_file;
  if (options_.install && file.empty()) {
    return failure({Code::ConfigValue,
                    {config_->file.string(), 0, 0},
                    "there is no ledger to record what is installed",
                    "[ledger] file = \"NAME.ledger\""});
  }
  if (file.empty() || !(options_.install || drives)) return {};
  PANELCAL_TRY(NightLock taken, NightLock::take(file, words_.date));
  lock_.emplace(std::move(taken));
  return {};
}

Expected<void> Session::open_ledger() {
  if (!options_.install) return {};
  PANELCAL_TRY(ledger_, Ledger::open(config_->ledger_file, fixed_clock(words_.date)));
  return {};
}

Expected<void> Session::finish(LedgerDraft draft,
                               const Calibration& kind,
                               const std::string& refusal) {
  objection_ = refusal;
  if (!options_.force) refusal_ = refusal;
  record_ = draft.record;
  if (!options_.install) {
    if (options_.output.empty() || !refusal_.empty()) return {};
    PANELCAL_TRY(const std::string text, text_with_head(*config_, std::move(draft.result)));
    PANELCAL_CHECK(kind.date_of(text, options_.output));
    return write_file(options_.output, text);
  }
  // A trial that found nothing has no value to put in force, whatever speaks against it or not.
  const bool has_value = draft.record.verdict != LedgerVerdict::Refused;
  const bool installs = refusal_.empty() && has_value;
  draft.record.verdict = installs ? LedgerVerdict::Installed : LedgerVerdict::Refused;
  if (!refusal_.empty()) draft.record.reason = refusal_;
  if (kind.has_file()) PANELCAL_CHECK(note_head(*ledger_, draft));
  // The ledger first: whatever happens then, it says which file should be there.
  PANELCAL_TRY(const LedgerEntry entry, ledger_->append(draft));
  entry_ = entry.id;
  is_in_ledger_alone_ = installs && kind.has_file() && kind.file().empty();
  if (installs) PANELCAL_CHECK(kind.write_in_force(*ledger_));
  return {};
}

std::string Session::verdict_line() const {
  const std::string recorded = entry_ ? fmt::format(", ledger entry {}", *entry_) : "";
  if (!refusal_.empty()) return fmt::format("  refused{}: {} (--force)\n", recorded, refusal_);
  if (!entry_) return {};
  return fmt::format(
      "  installed{}{}\n",
      recorded,
      is_in_ledger_alone_ ? ", into the ledger alone: no file is named for it (-o)" : "");
}

Answer Session::answer(std::string text, Json part, CommandContext& context) const {
  const auto document = [&] {
    return facts::text(this->document(std::move(part), context.options));
  };
  return state_facts(context,
                     options_.facts,
                     "Calibration: " + record_.key.subject,
                     document,
                     {std::move(text), refusal_.empty() ? ExitCode::Done : ExitCode::GateFailed});
}

Json Session::document(Json part, const Options& options) const {
  const bool is_written = !options_.install && !options_.output.empty();
  Json out = facts::envelope("calibration", kCalibrationVersion);
  out.update({{"kind", word(record_.key.kind)},
              {"machine", record_.key.machine},
              {"subject", record_.key.subject},
              {"time", iso_8601(words_.date)},
              {"verdict",
               !refusal_.empty() ? "refused"
               : entry_          ? "installed"
               : is_written      ? "written"
                                 : "measured"},
              {"objection", objection_},
              {"ledger_entry", entry_ ? Json(*entry_) : Json()}});
  Json& parameters = out["parameters"] = Json::array();
  for (const LedgerParameter& one : record_.parameters) {
    parameters.push_back(
        {{"name", one.name}, {"value", facts::number(one.value)}, {"unit", one.unit}});
  }
  out["covariance"] = square_rows(record_.covariance);
  Json& inputs = out["inputs"] = Json::array();
  for (const LedgerInput& input : record_.inputs) {
    inputs.push_back({{"name", input.name}, {"sha256", input.sha256}, {"bytes", input.bytes}});
  }
  std::string key(word(record_.key.kind));
  std::ranges::replace(key, '-', '_');
  out[key] = std::move(part);
  const auto& [row, value] = command_line_row(options);
  out["provenance"] = {{row, value}};
  return out;
}

}  // namespace panelcal::calibrate
