// SPDX-License-Identifier: Apache-2.0
#include "machine/job/output/output.h"

namespace panelcal {

Expected<void> FileOutput::begin() {
  file_.reset();
  PANELCAL_TRY(AtomicFile file, AtomicFile::create(target_));
  file_.emplace(std::move(file));
  return {};
}

}  // namespace panelcal
