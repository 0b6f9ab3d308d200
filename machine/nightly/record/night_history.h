// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/drift/series.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal {

/// Quality of a night's measurements.
struct QualityNight {
  std::chrono::sys_seconds time{};
  std::vector<NightSpread> spreads;
  std::vector<NightLevel> levels;
  bool is_left_out = false;     ///< refused that night: not what is usual
  bool is_fresh_start = false;  ///< cleaned, or a new drill: nights before say nothing
};

/// The ledger's record of one calibration, oldest first.
struct NightHistory {
  /// The nights and installations by hand that found something; the refused ones, and what was
  /// rolled back since, are left out of models. Times ascend: where a clock was set back, a second
  /// after the one before; or if a fresh start was marked since, those before it are moved back.
  DriftSeries series;
  std::vector<std::int64_t> ids;      ///< of those points' entries
  std::vector<bool> is_by_hand;       ///< of those points: installed by a person
  std::vector<std::string> asked_by;  ///< of those points' entries
  /// After each of those points; absent where nothing was, or what an older entry has.
  std::vector<std::optional<Eigen::VectorXd>> in_force_values;
  std::vector<QualityNight> qualities;
  std::optional<LedgerEntry> in_force;
  std::optional<LedgerValues> in_force_value;
  /// In force seven days ago; absent if nothing was.
  std::optional<LedgerValues> week_ago;
  bool is_fresh_start = false;        ///< the next result is one: a person has said so
  bool is_fresh_for_quality = false;  ///< the same for `qualities`
  /// The ledger had to be begun anew, and no person has yet said that this is a fresh start.
  bool is_unconfirmed = false;
  /// By how much the newest entry is of the future, if by more than kMostAhead: the clock was wrong
  /// then, or is now, and the age of every entry is unknown.
  std::optional<std::chrono::seconds> ahead;
  /// The entry that is, by its own time; 0 without.
  std::int64_t ahead_id = 0;

  /// The entries that this night has already recorded.
  struct Tonight {
    LedgerEntry entry;
    NightState state = NightState::Held;
    std::string summary;
  };
  std::optional<Tonight> tonight;
  std::optional<int> used_up;  ///< by the newest recorded night, see Calibration::used_up
};

/// At most this number of the newest entries is looked at: two years, and a filter forgets sooner.
inline constexpr std::size_t kMostNights = 730;
/// The difference that clocks of computers that share a ledger may have.
inline constexpr std::chrono::seconds kMostAhead = std::chrono::hours(1);

/// Reads what the ledger has of a calibration.
///
/// In     night: which of its entries are tonight's; now: for a week ago, and what is ahead of it
/// Fails  what the ledger reports
/// See    tests/machine/nightly/record/night_history_test.cc
Expected<NightHistory> read_night_history(const Ledger& ledger,
                                          const Calibration& calibration,
                                          const std::string& night,
                                          std::chrono::sys_seconds now);

/// Takes installations by hand for fresh starts that are farther than `limit`, in the series' unit,
/// from what was in force before them: the person knew what the nights before do not tell.
void accept_moves_by_hand(NightHistory& history, double limit);

/// The key of the entry that a night records beside a calibration's, with the next number.
LedgerKey companion_key(const LedgerKey& key);
/// Scatters and levels of such an entry.
QualityNight qualities_of(const LedgerEntry& companion);
/// The key of the entries of mark_fresh_start().
LedgerKey fresh_start_key(const LedgerKey& key);

/// Beside every calibration that a night records there is a second entry, of kind self-test: how
/// well it could measure, and what became of it.
LedgerDraft companion_draft(const LedgerRecord& calibration,
                            const std::string& night,
                            const CalibrationResult* measurement,
                            int used_up,
                            NightState state,
                            const std::string& summary);

/// The self-test as an entry of its own; left out of the statistics if it did not pass.
LedgerDraft self_test_draft(const std::string& machine,
                            const QualityNight& quality,
                            const RecordWords& words,
                            const std::string& problem);

struct SelfTestHistory {
  std::vector<QualityNight> nights;
  bool is_fresh_start = false;  ///< the next one is
};
/// In     now: no night is after it
Expected<SelfTestHistory> read_self_tests(const Ledger& ledger,
                                          const std::string& machine,
                                          std::chrono::sys_seconds now);
/// The subject of mark_fresh_start for the self-test.
LedgerKey self_test_key(const std::string& machine);

struct FreshStart {
  std::string reason;
  std::string asked_by;
  std::string software;
};

/// Notes that a person has changed or looked at something: the next result of this calibration is
/// held against no night before, and in a ledger that had to be begun anew it may be installed.
///
/// Fails  what the ledger reports
Expected<LedgerEntry> mark_fresh_start(Ledger& ledger,
                                       const LedgerKey& key,
                                       const FreshStart& words);

/// Notes that the ledger before was damaged and lies at `kept`.
///
/// In     given_up: hashes of that ledger's entries that files of the machine note
LedgerDraft begun_anew_draft(const std::string& machine,
                             const std::filesystem::path& kept,
                             const RecordWords& words,
                             const std::vector<std::string>& given_up = {});
/// True if any machine has begun this ledger in place of a damaged one.
///
/// Fails  what the ledger reports
Expected<bool> was_begun_anew(const Ledger& ledger);
/// Those of all machines of a ledger.
///
/// Fails  what the ledger reports
Expected<std::set<std::string>> given_up_hashes(const Ledger& ledger);

}  // namespace panelcal
