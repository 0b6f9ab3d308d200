// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration_record.h"
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
enum class TrialKind : std::uint8_t { Focus, Light, Settle };

struct TrialValue {
  TrialKind kind = TrialKind::Focus;
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
LedgerKey trial_key(const MachineConfig& config, TrialKind kind);
/// The number's name: "height", "level" or "wait".
std::string trial_parameter(TrialKind kind);
/// "mm", "level" or "s".
std::string trial_unit(TrialKind kind);

/// For the ledger: parameter "height", "level" or "wait" with its variance, machine.toml and the
/// camera's calibration as inputs, the details and the place as the result. One that has found
/// nothing is refused, for its reason.
///
/// Fails  file-unreadable (an input is gone)
Expected<LedgerDraft> trial_draft(const MachineConfig& config,
                                  const TrialPlace& place,
                                  const TrialValue& found,
                                  const RecordWords& words);

struct TrialNumber {
  double value = 0;
  double sigma = 0;
};
/// The number of an entry; empty if it has none.
std::optional<TrialNumber> trial_number(const LedgerEntry& entry);

/// Change of a number that does not matter, in its own unit.
double trial_tolerance(const NightTrials& trials, TrialKind kind);

/// The value in machine.toml now: [camera] focus_mm or lamp, [machine] settle_s.
std::optional<double> stated_number(const MachineConfig& config, TrialKind kind);
/// The line that says a number: "[camera] focus_mm = 0.137".
std::string stated_line(TrialKind kind, const TrialNumber& number);

/// Says so if machine.toml does not keep to what is in force: a height that is farther off than
/// [nightly.focus] tolerates, a level by more than a step of [nightly.light], or a shorter wait.
/// Empty if it does, and where nothing is in force.
///
/// Fails  what the ledger reports
/// See    tests/machine/calibrate/place_record_test.cc
Expected<std::string> stated_otherwise(const MachineConfig& config,
                                       const Ledger& ledger,
                                       TrialKind kind);

}  // namespace panelcal
