// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace panelcal {

/// The subject of an entry of the ledger.
enum class LedgerKind : std::uint8_t {
#define PANELCAL_KIND(enumerator, word) enumerator,
#include "calib/ledger/entry/kinds.def"
};

/// The verdict on it. Only an installed calibration comes into force; a rolled-back entry puts an
/// earlier installed one in force again.
enum class LedgerVerdict : std::uint8_t { Measured, Installed, Refused, RolledBack };

/// `spindle-camera`, `self-test`, ...: as the ledger and the command line write it.
std::string_view word(LedgerKind kind);
std::string_view word(LedgerVerdict verdict);
std::optional<LedgerKind> ledger_kind(std::string_view word);
std::optional<LedgerVerdict> ledger_verdict(std::string_view word);
/// All words of kinds, for messages.
std::span<const std::string_view> ledger_kind_words();

/// A kind of calibration that a night can make (kinds.def).
struct CalibrationWords {
  std::string_view word;
  bool is_at_mark = false;  ///< it needs a mark to look at
};
std::span<const CalibrationWords> calibration_words();

/// One calibrated thing: of one machine, one kind, and which of that kind ("spindle 2 station 1",
/// "zoom 3"). At most one calibration of it is in force.
struct LedgerKey {
  std::string machine;
  LedgerKind kind = LedgerKind::SpindleCamera;
  std::string subject;

  friend bool operator==(const LedgerKey&, const LedgerKey&) = default;
};

/// A file or set of bytes that a calibration was made from.
struct LedgerInput {
  std::string name;
  std::string sha256;       ///< 64 hexadecimal digits
  std::uint64_t bytes = 0;  ///< at most 2^53

  friend bool operator==(const LedgerInput&, const LedgerInput&) = default;
};

struct LedgerParameter {
  std::string name;
  double value = 0;
  std::string unit;  ///< "mm", "rad", "1", ...

  friend bool operator==(const LedgerParameter&, const LedgerParameter&) = default;
};

/// The record of one calibration or test, in the words of its maker.
struct LedgerRecord {
  LedgerKey key;
  LedgerVerdict verdict = LedgerVerdict::Measured;
  std::string reason;    ///< of the verdict; must be there for Refused and RolledBack
  std::string asked_by;  ///< a user or a timer
  std::string software;  ///< the program that computed it, with its version
  std::optional<double> temperature_degC;
  std::vector<LedgerInput> inputs;
  std::vector<LedgerParameter> parameters;
  /// Of the parameters, in their order and units: n x n, symmetric, positive semidefinite.
  std::optional<Eigen::MatrixXd> covariance;
  /// The entry that this one takes out of force. Given to `append` it is a condition: nothing is
  /// recorded if another one is in force by then. Left empty, the ledger fills it in.
  std::optional<std::int64_t> replaces;

  /// The index of the parameter of that name.
  std::optional<std::size_t> find(std::string_view name) const;
};

/// Several parameters of a record together.
struct LedgerValues {
  Eigen::VectorXd value;
  Eigen::MatrixXd cov;
};

/// The parameters of these names, in their order and in the record's units. Empty if the record
/// lacks one of them, or states no covariance.
std::optional<LedgerValues> values_of(const LedgerRecord& record,
                                      std::span<const std::string_view> names);

/// The input of `append`: a record, and the calibration itself.
struct LedgerDraft {
  LedgerRecord record;
  std::string result;  ///< JSON, byte for byte as in the calibration file
};

/// One entry as it stands in the ledger.
struct LedgerEntry {
  std::int64_t id = 0;  ///< 1, 2, 3, ... without gaps; the order of the ledger
  /// As the clock said; clocks are set back at times, so the order is that of the ids.
  std::chrono::sys_seconds time{};
  LedgerRecord record;
  std::optional<std::int64_t> restores;  ///< rolled-back only: the entry in force again
  std::string result_sha256;
  std::uint64_t result_bytes = 0;
  std::string hash;  ///< SHA-256 of the previous entry's hash and this one's content
};

/// The entry's content as the ledger stores it and as its hash covers it: one line of JSON.
std::string ledger_entry_json(const LedgerEntry& entry);

inline constexpr std::size_t kMaxLedgerParameters = 500;
inline constexpr std::size_t kMaxLedgerInputs = 100000;
inline constexpr std::size_t kMaxLedgerNameBytes = 200;
inline constexpr std::size_t kMaxLedgerTextBytes = 10000;
inline constexpr std::size_t kMaxLedgerResultBytes = std::size_t{1} << 24;

}  // namespace panelcal
