// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <system_error>

#include "calib/base/clock.h"
#include "calib/base/number_text.h"
#include "calib/ledger/ledger.h"
#include "tools/cli/commands.h"
#include "tools/gather/nights.h"
#include <fmt/format.h>

namespace panelcal::history {

Expected<Answer> push(const HistoryOptions& options, CommandContext& /*context*/) {
  PANELCAL_TRY(const Ledger ledger, Ledger::open_to_read(options.ledger));
  PANELCAL_TRY(const auto database, gather::open_database(options.store));
  // Two folders have a drill1.ledger each.
  std::error_code error;
  const std::filesystem::path file = std::filesystem::absolute(options.ledger, error);
  PANELCAL_TRY(
      const gather::PushedLedger pushed,
      gather::push_ledger(ledger, file.string(), options.reports, system_clock()(), *database));
  std::string text =
      fmt::format("{} new {}", pushed.n_entries, pushed.n_entries == 1 ? "entry" : "entries");
  if (!options.reports.empty()) text += ", " + internal::counted(pushed.n_nights, "new night");
  return Answer{fmt::format("{} put into {}\n", text, database->name())};
}

}  // namespace panelcal::history
