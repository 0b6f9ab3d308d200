// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_ledger.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "machine/nightly/record/night_history.h"
#include "machine/nightly/record/noted_heads.h"
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

Expected<Ledger> open_night_ledger(const NightFiles& files,
                                   const Clock& clock,
                                   const std::string& machine,
                                   const RecordWords& words,
                                   std::vector<std::string>& notes) {
  const std::filesystem::path& file = files.ledger;
  std::error_code ignored;
  // Before a new one is begun beside files that note entries of another.
  if (!std::filesystem::exists(file, ignored)) PANELCAL_CHECK(check_noted_heads(files, nullptr));
  Expected<Ledger> ledger = open_and_verify(file, clock);
  bool is_begun_anew = false;
  if (!ledger && ledger.error().code == Code::LedgerCorrupt) {
    const std::string why = ledger.error().what;
    PANELCAL_TRY(const std::filesystem::path kept, Ledger::keep_aside(file, clock));
    notes.push_back(
        fmt::format("the ledger is damaged ({}) and kept as {}", why, quoted(kept.string(), 200)));
    ledger = open_and_verify(file, clock);
    is_begun_anew = true;
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
    // Only of a ledger that was damaged, as this run or another machine's has seen: one that was
    // taken away may come back.
    PANELCAL_TRY(const bool is_by_another, was_begun_anew(*ledger));
    std::vector<std::string> given_up;
    if (is_begun_anew || is_by_another) {
      PANELCAL_TRY(given_up, noted_hashes(files));
    }
    PANELCAL_CHECK(ledger->append(begun_anew_draft(machine, kept, words, given_up)));
  }
  PANELCAL_CHECK(check_noted_heads(files, &*ledger));
  return ledger;
}

}  // namespace panelcal
