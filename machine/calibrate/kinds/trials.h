// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration.h"
#include "machine/config/machine_config.h"
#include "machine/look/place_trials.h"

// Entries of focus, light and settle trials in the ledger. They have no file of their own: the
// ledger's entry is in force, and a person writes its number into machine.toml (decision:
// docs/decisions/ledger.md).
namespace panelcal {

/// A mark that something was tried at.
struct TrialPlace {
  Position<frame::Machine> mark;
  int tool = 1;  ///< vision tool
};

/// A trial finds one number: the height of the focus axis (mm), the lamp's level, or the wait after
/// a move (s).
struct TrialValue {
  LedgerKind kind = LedgerKind::Focus;  ///< Focus, Light or Settle
  std::optional<double> value;
  double sigma = 0;
  std::string reason;   ///< of a missing value
  std::string details;  ///< an object of JSON: all that was seen
};

/// The peak of the sharpness curve with its sigma.
TrialValue trial_value(const FocusResult& result);
/// The best level. Only a few are tried: a level between two is as good as either, so sigma is
/// that of an even chance over the wider of the steps to its neighbours, step / sqrt(12).
TrialValue trial_value(const LightRun& run);
/// The wait with half of the way to the safe one as its sigma: what is written into machine.toml is
/// two sigmas more.
TrialValue trial_value(const SettleRun& run);

/// "focus" and "light" of "camera", "settle" of "stage".
LedgerKey trial_key(const MachineConfig& config, LedgerKind kind);

/// For the ledger: parameter "height", "level" or "wait" with its variance, machine.toml and the
/// camera's calibration as inputs, the details and the place as the result. One that has found
/// nothing is refused, for its reason.
///
/// Fails  file-unreadable (an input is gone)
Expected<LedgerDraft> trial_draft(const MachineConfig& config,
                                  const TrialPlace& place,
                                  const TrialValue& found,
                                  const RecordWords& words);

namespace internal {

/// Names of a trial in messages, in the ledger and in machine.toml.
struct TrialRow {
  LedgerKind kind;
  std::string_view words;
  std::string_view subject;
  std::string_view parameter;
  std::string_view unit;
  std::string_view table;
  std::string_view key;
};

/// In     kind: Focus, Light or Settle
const TrialRow& trial_of(LedgerKind kind);
/// Change of a number that does not matter, in its own unit.
double trial_tolerance(const NightTrials& trials, LedgerKind kind);

}  // namespace internal

struct TrialNumber {
  double value = 0;
  double sigma = 0;
};
/// The number of an entry; empty if it has none.
std::optional<TrialNumber> trial_number(const LedgerEntry& entry);

/// The line that says a number: "[camera] focus_mm = 0.137".
std::string stated_line(LedgerKind kind, const TrialNumber& number);

/// Says so if machine.toml does not keep to what is in force: a height that is farther off than
/// [nightly.focus] tolerates, a level by more than a step of [nightly.light], or a shorter wait.
/// Empty if it does, and where nothing is in force.
///
/// Fails  what the ledger reports
/// See    tests/machine/calibrate/kinds/trials_test.cc
Expected<std::string> stated_otherwise(const MachineConfig& config,
                                       const Ledger& ledger,
                                       LedgerKind kind);

/// Focus, lamp level or settle time, at the mark of [nightly]. No file has it: to install it is to
/// record it; machine.toml stays what a person writes, and the night says where the two disagree.
std::unique_ptr<Calibration> trial_kind(LedgerKind kind,
                                        std::shared_ptr<MachineConfig> config,
                                        const NightlyConfig& nightly);

}  // namespace panelcal
