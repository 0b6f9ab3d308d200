// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/ledger/ledger.h"
#include "tools/gather/database.h"

namespace panelcal::gather {

/// Numbers of a push.
struct PushedLedger {
  std::int64_t n_entries = 0;  ///< that the database lacked
  std::int64_t n_nights = 0;   ///< likewise
};

/// Brings a ledger, and the nights that its reports tell of, into a database. A second time changes
/// nothing but the time of the push.
///
/// In     file: of the ledger, as the database is to name it; reports: the folder of a machine's
///        nights (NIGHT.json); empty: none
/// Fails  ledger-corrupt (a hash is wrong); ledger-cut-off (the database has entries that the
/// ledger
///        lacks or has otherwise: the ledger was replaced, and nothing is put in); facts of a night
///        that cannot be read; as Database
Expected<PushedLedger> push_ledger(const Ledger& ledger,
                                   const std::string& file,
                                   const std::filesystem::path& reports,
                                   std::chrono::sys_seconds now,
                                   Database& database);

/// May a machine drill now?
enum class FleetState : std::uint8_t {
  Drill,
  Hold,     ///< its last night says so
  Unknown,  ///< the last night is too old, or something has changed since
};

/// "drill", "hold", "unknown".
std::string_view name(FleetState state);

/// A machine, as its newest night and ledger that were pushed tell of it.
struct FleetMachine {
  std::string machine;
  FleetState state = FleetState::Unknown;
  std::string why;    ///< of the state, in words
  std::string until;  ///< of Drill: ISO 8601, UTC
  std::string night, finished, verdict, outcome, asked_by;
  std::int64_t n_entries_since = 0;  ///< of the ledger, behind that night
  std::string newest_entry;          ///< of those, in words; empty: there is none
  std::string pushed;
};

struct FleetTerms {
  std::chrono::sys_seconds now{};
  /// A night that ended earlier says nothing any more: a later one may have held, and not have been
  /// pushed.
  std::chrono::hours max_age{36};
};

/// All machines that a database has nights or entries of, by their names.
///
/// "drill" wants a night that says so and is young enough, a forecast that has not ended, no entry
/// behind it that changes what is in force, as no night has judged that, and one machine of this
/// name.
Expected<std::vector<FleetMachine>> fleet(Database& database, const FleetTerms& terms);

}  // namespace panelcal::gather
