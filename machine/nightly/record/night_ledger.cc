// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_ledger.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "machine/nightly/record/night_history.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Newest file that Ledger::keep_aside has put beside a ledger; empty if there is none.
std::filesystem::path newest_kept_aside(const std::filesystem::path& ledger) {
  const std::filesystem::path folder = ledger.has_parent_path() ? ledger.parent_path() : ".";
  const std::string begin = ledger.filename().string() + ".corrupt-";
  std::filesystem::path newest;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().filename().string().starts_with(begin)) newest = std::max(newest, it->path());
  }
  return newest;
}

Expected<Ledger> open_and_verify(const std::filesystem::path& file, const Clock& clock) {
  PANELCAL_TRY(Ledger ledger, Ledger::open(file, clock));
  PANELCAL_CHECK(ledger.verify());
  return ledger;
}

}  // namespace

Expected<Ledger> open_night_ledger(const std::filesystem::path& file,
                                   const Clock& clock,
                                   const std::string& machine,
                                   const NightWords& words,
                                   std::vector<std::string>& notes) {
  Expected<Ledger> ledger = open_and_verify(file, clock);
  if (!ledger && ledger.error().code == Code::LedgerCorrupt) {
    const std::string why = ledger.error().what;
    PANELCAL_TRY(const std::filesystem::path kept, Ledger::keep_aside(file, clock));
    notes.push_back(
        fmt::format("the ledger is damaged ({}) and kept as {}", why, quoted(kept.string(), 200)));
    ledger = open_and_verify(file, clock);
  }
  if (!ledger) return ledger;
  // A run that was cut off between keeping one aside and beginning another has left no ledger; or
  // it was that of another machine, which has noted it for itself.
  const std::filesystem::path kept = newest_kept_aside(file);
  LedgerFilter filter;
  filter.machine = machine;
  filter.last = 1;
  PANELCAL_TRY(const std::vector<LedgerEntry> own, ledger->list(filter));
  if (own.empty() && !kept.empty()) {
    PANELCAL_CHECK(ledger->append(begun_anew_draft(machine, kept, words)));
  }
  return ledger;
}

}  // namespace panelcal
