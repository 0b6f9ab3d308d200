// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/session.h"

#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include <fmt/format.h>

namespace panelcal::calibrate {

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
  // A name that only a ledger asks for: of the calibration, or of the rows of a coupon.
  if (options.install || options.what == CalibrateOptions::What::SpindleCamera) {
    session.words_.asked_by = asking_person(options.asked_by);
  }
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
  if (!options_.force) refusal_ = refusal;
  if (!options_.install) {
    if (options_.output.empty() || !refusal_.empty()) return {};
    PANELCAL_TRY(const std::string text, text_with_head(*config_, std::move(draft.result)));
    PANELCAL_CHECK(kind.date_of(text, options_.output));
    return write_file(options_.output, text);
  }
  const bool installs = refusal_.empty();
  draft.record.verdict = installs ? LedgerVerdict::Installed : LedgerVerdict::Refused;
  if (!installs) draft.record.reason = refusal_;
  if (kind.has_file()) PANELCAL_CHECK(note_head(*ledger_, draft));
  // The ledger first: whatever happens then, it says which file should be there.
  PANELCAL_TRY(const LedgerEntry entry, ledger_->append(draft));
  entry_ = entry.id;
  if (installs) PANELCAL_CHECK(kind.write_in_force(*ledger_));
  return {};
}

std::string Session::verdict_line() const {
  const std::string recorded = entry_ ? fmt::format(", ledger entry {}", *entry_) : "";
  if (!refusal_.empty()) return fmt::format("  refused{}: {} (--force)\n", recorded, refusal_);
  return entry_ ? fmt::format("  installed{}\n", recorded) : "";
}

void Session::put_verdict(nlohmann::ordered_json& json) const {
  if (!refusal_.empty()) json["refusal"] = refusal_;
  if (entry_) json["ledger"] = *entry_;
}

Answer Session::answer(std::string text) const {
  return {std::move(text), refusal_.empty() ? ExitCode::Done : ExitCode::GateFailed};
}

Answer Session::answer(const nlohmann::ordered_json& json) const {
  return answer(json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace panelcal::calibrate
