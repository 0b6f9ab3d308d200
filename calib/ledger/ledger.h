// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/expected.h"
#include "calib/ledger/database/head.h"
#include "calib/ledger/database/options.h"
#include "calib/ledger/entry/entry.h"
#include "calib/ledger/entry/filter.h"

namespace panelcal {

namespace internal {
class SqliteConnection;
}  // namespace internal

/// One parameter over time.
struct LedgerSeries {
  struct Point {
    std::int64_t id = 0;
    std::chrono::sys_seconds time{};
    double value = 0;
    std::optional<double> sigma;
    std::optional<double> temperature_degC;
    LedgerVerdict verdict = LedgerVerdict::Measured;
  };
  std::string unit;  ///< empty if there are no points
  std::vector<Point> points;
};

/// The history of the machines' calibrations: a file that only grows.
///
/// Nothing is changed or deleted, not even by a rollback, which is an entry of its own. Which
/// calibration is in force follows from the entries: that of the newest installed or rolled-back
/// entry of its key.
///
/// An entry that was acknowledged (`append` returned it) survives the end of the program and of the
/// power at any moment; one that was not is there whole or not at all. Any number of programs may
/// use one ledger; they must be on one computer, since locks of network disks cannot be relied on.
/// To install a calibration, append it first and write its file from the ledger then: whatever
/// happens in between, `in_force` says which file should be there (its digest is in the entry).
///
/// Each entry holds the hash of its predecessor, so whatever damages or rewrites one is found.
/// A Ledger is for one thread, and not for both sides of a fork.
///
/// Fails  ledger-corrupt, ledger-busy: all functions; device-write: all that record
/// See    docs/decisions/ledger.md; tests/calib/ledger/ledger_test.cc, ledger_file_test.cc
class Ledger {
 public:
  /// Opens a ledger, or starts one where there is no file. A damaged one is left where it is.
  ///
  /// Fails  ledger-foreign; ledger-newer; file-unreadable
  /// Cost   reads the whole file once
  static Expected<Ledger> open(const std::filesystem::path& path,
                               Clock clock,
                               const LedgerOptions& options = {});
  /// The same for reading only, as on read-only media; the file must exist. A write that was killed
  /// halfway is undone where the file may be written.
  static Expected<Ledger> open_to_read(const std::filesystem::path& path,
                                       const LedgerOptions& options = {});
  /// Moves a damaged ledger aside, to `<path>.corrupt-<UTC time>` (with -2, -3, ... if that name is
  /// taken), and returns its new name. Refuses to move anything but a damaged ledger.
  ///
  /// Fails  ledger-entry-invalid (nothing is wrong with it); ledger-foreign; ledger-newer
  static Expected<std::filesystem::path> keep_aside(const std::filesystem::path& path,
                                                    const Clock& clock,
                                                    const LedgerOptions& options = {});

  Ledger(Ledger&&) noexcept;
  Ledger& operator=(Ledger&&) noexcept;
  ~Ledger();

  /// Records one entry, or several at once: all of them or none.
  ///
  /// Fails  ledger-entry-invalid (names the field)
  Expected<LedgerEntry> append(const LedgerDraft& draft);
  Expected<std::vector<LedgerEntry>> append_all(std::span<const LedgerDraft> drafts);

  struct RollBack {
    LedgerKey key;
    /// An installed entry of that key; empty for the one that was in force before the present one.
    std::optional<std::int64_t> to;
    std::string reason;
    std::string asked_by;
    std::string software;
  };
  /// Records that an earlier calibration is in force again. Going back repeatedly goes back
  /// further each time.
  ///
  /// Fails  ledger-entry-invalid (nothing to go back to; already in force); ledger-entry-unknown
  Expected<LedgerEntry> roll_back(const RollBack& request);

  /// In the order of their ids.
  Expected<std::vector<LedgerEntry>> list(const LedgerFilter& filter) const;
  /// All of a key, or only this number of the newest.
  Expected<std::vector<LedgerEntry>> list(const LedgerKey& key,
                                          std::optional<std::size_t> last = {}) const;
  /// The same one at a time, for ledgers larger than the memory.
  Expected<void> for_each(const LedgerFilter& filter,
                          const std::function<Expected<void>(const LedgerEntry&)>& visit) const;
  /// Fails  ledger-entry-unknown
  Expected<LedgerEntry> entry(std::int64_t id) const;
  /// The calibration's own bytes, checked against their digest.
  Expected<std::string> result(std::int64_t id) const;

  /// The installed entry that is in force; empty if none ever was.
  Expected<std::optional<LedgerEntry>> in_force(const LedgerKey& key) const;
  /// All of one machine, by kind and subject.
  Expected<std::vector<LedgerEntry>> all_in_force(std::string_view machine) const;

  /// One parameter of all entries of a key that have it, refused ones too, in the order of ids.
  ///
  /// Fails  ledger-entry-invalid (its unit changes)
  Expected<LedgerSeries> series(const LedgerKey& key, std::string_view parameter) const;

  Expected<LedgerHead> head() const;
  /// Checks every byte that counts: the file's structure, every hash, every result.
  ///
  /// Cost   O(size of the file); memory of one entry
  Expected<LedgerHead> verify() const;

 private:
  Ledger(std::unique_ptr<internal::SqliteConnection> connection, Clock clock);

  std::unique_ptr<internal::SqliteConnection> connection_;
  Clock clock_;  ///< empty: opened to read
};

}  // namespace panelcal
