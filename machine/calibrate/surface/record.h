// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/calibrate/surface/change.h"
#include "machine/calibrate/surface/figures.h"
#include "machine/config/machine_config.h"
#include "surface/map/file.h"

namespace panelcal {

/// The table's own surface.
LedgerKey surface_key(const MachineConfig& config);

/// For the ledger: the figures with their covariance, the area and, against the map before, if
/// there was one, the change's rms, its greatest and where (places have no variance); the map's
/// file as the result; machine.toml and what else the map was made of as inputs.
///
/// Fails  file-unreadable (machine.toml is gone); ledger-entry-invalid (more than a ledger takes)
Expected<LedgerDraft> surface_draft(const MachineConfig& config,
                                    const StoredMap& map,
                                    const SurfaceFigures& figures,
                                    const std::optional<SurfaceChange>& change,
                                    const RecordWords& words);

/// The figures of an entry; empty for one that has none.
///
/// See    tests/machine/calibrate/surface/change_test.cc
std::optional<SurfaceFigures> figures_of(const LedgerEntry& entry);

}  // namespace panelcal
