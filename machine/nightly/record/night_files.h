// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "calib/base/expected.h"

namespace panelcal {

struct MachineConfig;
struct NightlyConfig;

/// Paths of a night's files, as far as machine.toml states them; a path that it does not state is
/// empty. The rest of machine.toml may be wrong: this is for a night that has to say so.
struct NightFiles {
  std::string machine;
  std::filesystem::path ledger;
  std::filesystem::path reports;
  std::filesystem::path camera;
  std::map<double, std::filesystem::path> zooms;  ///< [[camera.zoom]], by level
  std::filesystem::path spindle;
  std::filesystem::path table;
  std::filesystem::path night_table;  ///< [nightly.table] file
  std::filesystem::path surface;      ///< [nightly.surface] file
  int noon_utc_h = 12;

  /// True if a file is one of the calibrations.
  bool has_calibration(const std::filesystem::path& file) const;
  /// Those that note the ledger's head: calibrations, and the folder of reports. Each once.
  std::vector<std::filesystem::path> that_note_the_head() const;
};

/// The same of a machine.toml that is valid.
NightFiles night_files_of(const MachineConfig& config, const NightlyConfig& nightly);

/// Fails  file-unreadable; toml-syntax
Expected<NightFiles> find_night_files(const std::filesystem::path& machine_toml);

/// Writes calibration files again that are not there or are damaged while the ledger has one in
/// force: machine.toml cannot be read without them. Files that can be read stay as they are,
/// whatever they say.
///
/// The caller holds the night's lock.
/// Out    what was done, in words, a line each
/// Fails  what the ledger reports; device-write
/// See    tests/machine/nightly/record/night_files_test.cc
Expected<std::vector<std::string>> restore_damaged_files(const NightFiles& files);

}  // namespace panelcal
