// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/drift/night_gates.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/devices/calibration_devices.h"
#include "surface/map/file.h"
#include <Eigen/Core>

namespace panelcal {

/// One thing that was looked at before the machine was calibrated, or while it was.
struct SelfTestCheck {
  std::string name;  ///< "disk", "coupon", "mark contrast", "camera noise", ...
  bool passed = true;
  std::string text;             ///< with the number and its limit
  std::optional<double> value;  ///< in `unit`
  std::optional<double> limit;
  std::string unit;  ///< "mm" is shown in um; "MB", "rows", "px", "1"
};

/// For the picture of the coupon: a hole and where the drill went astray.
struct NightHole {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  ///< machine
  Eigen::Vector2d residual_mm = Eigen::Vector2d::Zero();
  bool is_outlier = false;
};

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

/// The result of a calibration. Nothing is recorded or installed.
struct CalibrationResult {
  NightResult result;  ///< its time and temperature are the night's business
  std::vector<NightSpread> spreads;
  std::vector<NightLevel> levels;
  std::vector<NightHole> holes;
  std::optional<StoredMap> surface;
  std::vector<std::string> report;  ///< lines
  /// For the ledger, without a verdict: key, inputs, parameters, covariance and the file's bytes.
  LedgerDraft draft;
};

/// One kind of calibration: what it is called, how it is measured, how a file is made of it. What
/// it is used for is decided by others, who know no kind by name.
class Calibration {
 public:
  virtual ~Calibration() = default;

  virtual LedgerKey key() const = 0;
  /// 1 to 12 axes, all lengths at a hole or at an edge, or all of another unit.
  virtual std::vector<std::string> axes() const = 0;
  virtual std::string unit() const { return "mm"; }
  /// The calibration file; empty for one that has none: to install it is to record it.
  virtual std::filesystem::path file() const { return {}; }
  /// The value in machine.toml or that file now; absent if it was never calibrated.
  virtual std::optional<Eigen::VectorXd> present() const { return std::nullopt; }

  /// Checks that everything is there; of a coupon, also how much of it. Nothing moves.
  ///
  /// Fails  what is wrong with machine.toml
  virtual Expected<std::vector<SelfTestCheck>> check() const {
    return std::vector<SelfTestCheck>();
  }
  /// Something that is used up by measuring, counted up: rows of a coupon. 0 where nothing is.
  virtual Expected<int> used_up() const { return 0; }
  /// At most this number of spreads and levels a measurement has.
  virtual int n_qualities() const { return 0; }

  /// True if bad pictures may come of what it measures: then it is measured when the self-test
  /// found bad ones, for a person to see, and not installed.
  virtual bool may_explain_pictures() const { return false; }

  /// The limits of its results: [nightly]'s, which are of lengths at a hole, or others.
  virtual NightlyConfig held_to(const NightlyConfig& nightly) const { return nightly; }

  /// Empty for an entry that found nothing.
  virtual std::optional<LedgerValues> value_of(const LedgerEntry& entry) const = 0;

  /// Fails  device errors; calibration-data and the like where nothing could be found
  virtual Expected<CalibrationResult> measure(const CalibrationDevices& devices,
                                              const RecordWords& words) = 0;

  /// The line for a person to write into machine.toml, which has not the value in force.
  /// Empty if it does, and where that comes from a file.
  virtual Expected<std::string> stated_otherwise(const Ledger& /*ledger*/) const {
    return std::string();
  }

  /// True if the calibration is kept in a file, which notes the ledger's head.
  bool has_file() const { return !thing().empty(); }
  /// The date of a file's bytes.
  ///
  /// In     name: of the file, as messages have it
  /// Fails  what reading a calibration of this kind reports
  virtual Expected<std::chrono::sys_seconds> date_of(const std::string& bytes,
                                                     const std::string& name) const;
  /// The bytes that the file should have; empty where nothing is in force. They are the entry's
  /// result unless a file has more than one calibration.
  ///
  /// Fails  as date_of, naming the ledger's entry (its result is not valid); what the ledger
  /// reports
  virtual Expected<std::optional<std::string>> text_in_force(const Ledger& ledger) const;

  /// True if the file has the calibration in force.
  Expected<bool> is_installed(const Ledger& ledger) const;
  /// Name of the calibration that the file has if a person has put one there past the ledger, in
  /// words: to write the file again would lose it. Empty if that has not happened.
  virtual Expected<std::string> by_hand(const Ledger& ledger) const;
  /// Makes the file say what is in force. One that already does is left alone, so this also mends
  /// an installation that was interrupted between the ledger and the file.
  ///
  /// Out    whether a file was written
  /// Fails  as text_in_force; device-write
  Expected<bool> write_in_force(const Ledger& ledger) const;
  /// The same, and measurements to come begin there.
  Expected<bool> install(const Ledger& ledger);

 protected:
  /// The calibration that a person may have put into the file by hand: "a table". Empty where there
  /// is no file.
  virtual std::string_view thing() const { return {}; }
  /// Measurements to come begin at what is in force.
  virtual Expected<void> begin_there(const Ledger& /*ledger*/) { return {}; }

 private:
  /// The text in force, where the file has another one or cannot be read; read once, so that what
  /// is compared is what is written.
  Expected<std::optional<std::string>> missing_text(const Ledger& ledger) const;
};

}  // namespace panelcal
