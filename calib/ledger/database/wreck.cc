// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/database/wreck.h"

#include <algorithm>
#include <cerrno>
#include <string>
#include <string_view>
#include <vector>

#include "calib/ledger/database/schema.h"
#include "calib/ledger/entry/entry_text.h"
#include <fcntl.h>
#include <unistd.h>

namespace panelcal::internal {
namespace {

/// A sound start of another program's database. That, and a text of JSON lines, may hold exported
/// entries and yet be no ledger.
constexpr std::string_view kMagic("SQLite format 3\0", 16);
constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
/// A mark may lie across two chunks.
constexpr std::size_t kOverlapBytes = 64;

}  // namespace

bool is_wrecked_ledger(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  std::vector<char> chunk(kChunkBytes);
  std::string seen;
  bool first = true;
  bool may_hold_exports = false;
  bool found = false;
  while (!found) {
    const ssize_t n = ::read(fd, chunk.data(), chunk.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      found = n == 0 && first;
      break;
    }
    const std::size_t kept = std::min(seen.size(), kOverlapBytes);
    seen.erase(0, seen.size() - kept);
    seen.append(chunk.data(), static_cast<std::size_t>(n));
    if (first) may_hold_exports = seen.starts_with(kMagic) || seen.starts_with('{');
    first = false;
    found = seen.find(kSchemaMark) != std::string::npos ||
            (!may_hold_exports && seen.find(kEntryMark) != std::string::npos);
  }
  ::close(fd);
  return found;
}

}  // namespace panelcal::internal
