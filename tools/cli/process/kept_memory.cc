// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/process/kept_memory.h"

#include <cstddef>
#include <cstdlib>

namespace panelcal {

void keep_freed_memory() {
  // The threshold follows blocks below 32 MB.
  constexpr std::size_t kLargeBlock = std::size_t{31} << 20;
  void* volatile block = std::malloc(kLargeBlock);  // volatile: or the pair would be left out
  std::free(block);
}

}  // namespace panelcal
