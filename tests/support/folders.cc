// SPDX-License-Identifier: Apache-2.0
#include "tests/support/folders.h"

namespace panelcal::test {

std::filesystem::path source_folder() {
  return PANELCAL_SOURCE_DIR;
}

}  // namespace panelcal::test
