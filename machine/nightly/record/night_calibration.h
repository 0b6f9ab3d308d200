// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/drift/night_gates.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/nightly/record/night_record.h"
#include <Eigen/Core>

namespace panelcal {

/// A scatter that a calibration saw, as SpreadMonitor takes it.
struct NightSpread {
  std::string name;  ///< "holes about the fit"
  std::string unit;  ///< of its square root
  double variance = 0;
  double degrees_of_freedom = 0;
};

/// A level that a calibration saw (contrast, blur): what matters is by which factor it changes.
struct NightLevel {
  std::string name;
  std::string unit;
  double value = 0;  ///< above 0
  bool low_is_bad = true;
};

/// The result of a night's calibration. Nothing is recorded or installed.
struct NightMeasurement {
  NightResult result;  ///< its time and temperature are the night's business
  std::vector<NightSpread> spreads;
  std::vector<NightLevel> levels;
  std::vector<NightHole> holes;
  std::optional<StoredMap> surface;
  std::vector<std::string> report;  ///< lines
  /// For the ledger, without a verdict: key, inputs, parameters, covariance and the file's bytes.
  LedgerDraft draft;
};

/// One kind of calibration that a night can make: what it is called, how it is measured, how a
/// file is made of it. What it is used for is decided by others.
class NightCalibration {
 public:
  virtual ~NightCalibration() = default;

  virtual LedgerKey key() const = 0;
  /// 1 to 12 axes, all lengths at a hole or at an edge, or all of another unit.
  virtual std::vector<std::string> axes() const = 0;
  virtual std::string unit() const { return "mm"; }
  /// The calibration file; empty for one that has none: to install it is to record it.
  virtual std::filesystem::path file() const = 0;
  /// The value in machine.toml or that file now; absent if it was never calibrated.
  virtual std::optional<Eigen::VectorXd> present() const = 0;

  /// Checks that everything is there; of a coupon, also how much of it. Nothing moves.
  ///
  /// Fails  what is wrong with machine.toml
  virtual Expected<std::vector<SelfTestCheck>> check() const {
    return std::vector<SelfTestCheck>();
  }
  /// Something that is used up by measuring, counted up: rows of a coupon. 0 where nothing is.
  virtual Expected<int> used_up() const { return 0; }
  /// At most this number of spreads and levels a measurement has.
  virtual int n_qualities() const = 0;

  /// True if bad pictures may come of what it measures: then it is measured when the self-test
  /// found bad ones, for a person to see, and not installed.
  virtual bool may_explain_pictures() const { return false; }

  /// The limits of its results: [nightly]'s, which are of lengths at a hole, or others.
  virtual NightlyConfig held_to(const NightlyConfig& nightly) const { return nightly; }

  /// Empty for an entry that found nothing.
  virtual std::optional<LedgerValues> value_of(const LedgerEntry& entry) const = 0;

  /// Fails  device errors; calibration-data and the like where nothing could be found
  virtual Expected<NightMeasurement> measure(const CalibrationDevices& devices,
                                             const RecordWords& words) = 0;

  /// The line for a person to write into machine.toml, which has not the value in force.
  /// Empty if it does, and where that comes from a file.
  virtual Expected<std::string> stated_otherwise(const Ledger& /*ledger*/) const {
    return std::string();
  }

  /// True if the file has the calibration in force.
  virtual Expected<bool> is_installed(const Ledger& ledger) const = 0;
  /// Name of the calibration that the file has if a person has put one there past the ledger, in
  /// words: to write the file again would lose it. Empty if that has not happened.
  virtual Expected<std::string> by_hand(const Ledger& ledger) const = 0;
  /// Makes the file say what is in force, and measurements to come begin there.
  ///
  /// Out    whether a file was written
  virtual Expected<bool> install(const Ledger& ledger) = 0;
};

}  // namespace panelcal
