// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "tools/cli/provenance.h"

namespace panelcal::batch {

/// A machine as its files have it, and what they say of the origin of an output.
struct KnownMachine {
  MachineConfig config;
  Provenance digests;      ///< of machine.toml and its calibrations
  Provenance ledger_head;  ///< as ledger_head_row() has it
};

/// Machines by the names of their files: the jobs of a batch share a few. May be asked by several
/// threads at once.
class MachineCache {
 public:
  /// Fails  as read_machine_config()
  Expected<std::shared_ptr<const KnownMachine>> get(const std::string& file);

 private:
  std::mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<const KnownMachine>> known_;
};

}  // namespace panelcal::batch
