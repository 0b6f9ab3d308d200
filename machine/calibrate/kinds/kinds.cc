// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/kinds/kinds.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "machine/calibrate/kinds/parts.h"

namespace panelcal {
namespace internal {

#define PANELCAL_CALIBRATION(enumerator, word, step, at_mark, calibrations)         \
  Expected<Calibrations> calibrations(LedgerKind kind,                              \
                                      const std::shared_ptr<MachineConfig>& config, \
                                      const NightlyConfig& nightly);
#include "calib/ledger/entry/kinds.def"

}  // namespace internal

namespace {

struct KindRow {
  LedgerKind kind;
  int step;  ///< of a night
  Expected<internal::Calibrations> (*calibrations)(LedgerKind kind,
                                                   const std::shared_ptr<MachineConfig>& config,
                                                   const NightlyConfig& nightly);
};

constexpr KindRow kCalibrationKinds[] = {
#define PANELCAL_CALIBRATION(enumerator, word, step, at_mark, calibrations) \
  {LedgerKind::enumerator, step, internal::calibrations},
#include "calib/ledger/entry/kinds.def"
};

}  // namespace

Expected<NightCalibrations> NightCalibrations::make(const MachineConfig& config,
                                                    const NightlyConfig& nightly) {
  NightCalibrations out;
  out.config_ = std::make_shared<MachineConfig>(config);
  std::vector<KindRow> rows(std::begin(kCalibrationKinds), std::end(kCalibrationKinds));
  std::ranges::sort(rows, {}, &KindRow::step);
  for (const KindRow& row : rows) {
    if (std::ranges::find(nightly.calibrate, word(row.kind)) == nightly.calibrate.end()) continue;
    PANELCAL_TRY(internal::Calibrations made, row.calibrations(row.kind, out.config_, nightly));
    std::ranges::move(made, std::back_inserter(out.owned_));
  }
  for (const auto& one : out.owned_) out.all_.push_back(one.get());
  return out;
}

}  // namespace panelcal
