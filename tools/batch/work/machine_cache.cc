// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/work/machine_cache.h"

#include <utility>

namespace panelcal::batch {
namespace {

/// A machine's file and table map may take megabytes.
constexpr std::size_t kMaxMachines = 64;

}  // namespace

Expected<std::shared_ptr<const KnownMachine>> MachineCache::get(const std::string& file) {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto at = known_.find(file); at != known_.end()) return at->second;
  }
  // Outside of the lock: a machine that two threads read is the same machine.
  PANELCAL_TRY(MachineConfig config, read_machine_config(file));
  Provenance digests =
      file_digests({file, config.spindle_setting.file.string(), config.table_file.string()});
  Provenance ledger_head = ledger_head_row(config.ledger_file);
  const auto machine = std::make_shared<const KnownMachine>(
      KnownMachine{std::move(config), std::move(digests), std::move(ledger_head)});
  const std::scoped_lock lock(mutex_);
  if (known_.size() >= kMaxMachines) known_.clear();
  known_.emplace(file, machine);
  return machine;
}

}  // namespace panelcal::batch
