// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/process/memory_limit.h"

#include <cstdint>

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

namespace panelcal {

std::string memory_limit() {
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    return fmt::format("{} MiB by ulimit -v", limit.rlim_cur / kMiB);
  }
  if (::getrlimit(RLIMIT_DATA, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    return fmt::format("{} MiB by ulimit -d", limit.rlim_cur / kMiB);
  }
  const auto n_pages = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES));
  const auto page_bytes = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return fmt::format("{} MiB of this computer", n_pages * page_bytes / kMiB);
}

}  // namespace panelcal
