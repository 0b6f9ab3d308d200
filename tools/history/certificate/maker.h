// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "machine/config/machine_config.h"
#include "tools/history/certificate/certificate.h"

namespace panelcal::history {

struct CertificateInput {
  const MachineConfig& config;
  std::string ledger_file;  ///< as messages name it
  /// --plate, or [nightly.table] plate; empty without.
  std::string plate_file;
  std::optional<std::chrono::sys_seconds> since;
};

/// Evaluates what a ledger has of a machine. What it lacks is named in `not_measured`; no figure is
/// made up in its place.
///
/// Fails  ledger-entry-unknown (fewer than two installed spindle-camera calibrations); what the
///        ledger and the files report
/// See    tests/tools/certificate_test.py
Expected<Certificate> certificate_of(const Ledger& ledger, const CertificateInput& input);

}  // namespace panelcal::history
