// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/ledger/power_cut_vfs.h"

#include <algorithm>
#include <optional>

#include <sqlite3.h>

namespace panelcal::test {
namespace {

constexpr std::int64_t kSectorBytes = 512;

std::vector<DiskOrder> noted;
sqlite3_vfs* below = nullptr;
sqlite3_vfs recorder;

/// SQLite allocates szOsFile bytes: this, and behind it the file of the system.
struct RecordedFile {
  sqlite3_file base;
  const char* name;  ///< lives as long as the file is open
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

RecordedFile* recorded(sqlite3_file* file) {
  return reinterpret_cast<RecordedFile*>(file);
}
sqlite3_file* real(sqlite3_file* file) {
  return recorded(file)->real();
}

int close_file(sqlite3_file* f) {
  return real(f)->pMethods->xClose(real(f));
}
int read_file(sqlite3_file* f, void* to, int n, sqlite3_int64 at) {
  return real(f)->pMethods->xRead(real(f), to, n, at);
}
int write_file(sqlite3_file* f, const void* from, int n, sqlite3_int64 at) {
  noted.push_back({DiskOrder::Kind::Write,
                   recorded(f)->name,
                   at,
                   std::string(static_cast<const char*>(from), static_cast<std::size_t>(n))});
  return real(f)->pMethods->xWrite(real(f), from, n, at);
}
int truncate_file(sqlite3_file* f, sqlite3_int64 size) {
  noted.push_back({DiskOrder::Kind::Truncate, recorded(f)->name, size});
  return real(f)->pMethods->xTruncate(real(f), size);
}
int sync_file(sqlite3_file* f, int flags) {
  noted.push_back({DiskOrder::Kind::Sync, recorded(f)->name});
  return real(f)->pMethods->xSync(real(f), flags);
}
int file_size(sqlite3_file* f, sqlite3_int64* size) {
  return real(f)->pMethods->xFileSize(real(f), size);
}
int lock_file(sqlite3_file* f, int level) {
  return real(f)->pMethods->xLock(real(f), level);
}
int unlock_file(sqlite3_file* f, int level) {
  return real(f)->pMethods->xUnlock(real(f), level);
}
int is_reserved(sqlite3_file* f, int* out) {
  return real(f)->pMethods->xCheckReservedLock(real(f), out);
}
int control_file(sqlite3_file* f, int op, void* argument) {
  return real(f)->pMethods->xFileControl(real(f), op, argument);
}
int sector_size(sqlite3_file* f) {
  return real(f)->pMethods->xSectorSize(real(f));
}
int characteristics(sqlite3_file* f) {
  return real(f)->pMethods->xDeviceCharacteristics(real(f));
}

constexpr sqlite3_io_methods kMethods = {
    .iVersion = 1,
    .xClose = close_file,
    .xRead = read_file,
    .xWrite = write_file,
    .xTruncate = truncate_file,
    .xSync = sync_file,
    .xFileSize = file_size,
    .xLock = lock_file,
    .xUnlock = unlock_file,
    .xCheckReservedLock = is_reserved,
    .xFileControl = control_file,
    .xSectorSize = sector_size,
    .xDeviceCharacteristics = characteristics,
};

int open_file(sqlite3_vfs*, const char* name, sqlite3_file* f, int flags, int* out_flags) {
  f->pMethods = nullptr;
  recorded(f)->name = name;
  const int status = below->xOpen(below, name, real(f), flags, out_flags);
  if (real(f)->pMethods != nullptr) f->pMethods = &kMethods;
  return status;
}

int delete_file(sqlite3_vfs*, const char* name, int sync_folder) {
  noted.push_back(
      {sync_folder != 0 ? DiskOrder::Kind::SyncedDelete : DiskOrder::Kind::Delete, name});
  return below->xDelete(below, name, sync_folder);
}

/// One file on the disk: what surely is there, and what may have come since.
struct Tracked {
  std::optional<std::string> durable;  ///< empty: no such file
  std::vector<DiskOrder> pending;
};

void carry_out(const DiskOrder& order, std::optional<std::string>& content) {
  if (order.kind == DiskOrder::Kind::Sync) return;
  if (order.kind == DiskOrder::Kind::Delete || order.kind == DiskOrder::Kind::SyncedDelete) {
    content.reset();
    return;
  }
  if (!content) content.emplace();
  const auto at = static_cast<std::size_t>(order.offset);
  if (order.kind == DiskOrder::Kind::Truncate) {
    content->resize(at);
    return;
  }
  content->resize(std::max(content->size(), at + order.bytes.size()));
  content->replace(at, order.bytes.size(), order.bytes);
}

/// Up to a random border between sectors of the disk.
DiskOrder torn(DiskOrder order, Random& random) {
  const auto end = order.offset + static_cast<std::int64_t>(order.bytes.size());
  const auto cut = static_cast<std::int64_t>(
      random.uniform(static_cast<double>(order.offset), static_cast<double>(end)));
  const std::int64_t border = std::max(order.offset, cut / kSectorBytes * kSectorBytes);
  order.bytes.resize(static_cast<std::size_t>(border - order.offset));
  return order;
}

void lose_some(Tracked& tracked, Random& random) {
  // The part that got through differs from cut to cut: nothing, everything, anything between.
  const double chance = std::clamp(random.uniform(-0.5, 1.5), 0.0, 1.0);
  for (const DiskOrder& order : tracked.pending) {
    const double draw = random.uniform();
    if (draw >= chance) continue;
    const bool tears = order.kind == DiskOrder::Kind::Write && random.uniform() < 0.2;
    carry_out(tears ? torn(order, random) : order, tracked.durable);
  }
}

}  // namespace

DiskRecorder::DiskRecorder() {
  noted.clear();
  below = sqlite3_vfs_find(nullptr);
  recorder = *below;
  recorder.zName = "panelcal-power-cut";
  recorder.pNext = nullptr;
  recorder.szOsFile = below->szOsFile + static_cast<int>(sizeof(RecordedFile));
  recorder.xOpen = open_file;
  recorder.xDelete = delete_file;
  sqlite3_vfs_register(&recorder, 1);
}

DiskRecorder::~DiskRecorder() {
  sqlite3_vfs_unregister(&recorder);
  sqlite3_vfs_register(below, 1);
}

const std::vector<DiskOrder>& DiskRecorder::orders() const {
  return noted;
}

DiskContent after_power_cut(const DiskContent& start,
                            const std::vector<DiskOrder>& orders,
                            std::size_t n,
                            Random& random) {
  std::map<std::string, Tracked> disk;
  for (const auto& [file, content] : start) disk[file].durable = content;
  for (std::size_t i = 0; i < n; ++i) {
    Tracked& tracked = disk[orders[i].file];
    tracked.pending.push_back(orders[i]);
    const DiskOrder::Kind kind = orders[i].kind;
    if (kind != DiskOrder::Kind::Sync && kind != DiskOrder::Kind::SyncedDelete) continue;
    for (const DiskOrder& order : tracked.pending) carry_out(order, tracked.durable);
    tracked.pending.clear();
  }
  DiskContent left;
  for (auto& [file, tracked] : disk) {
    lose_some(tracked, random);
    if (tracked.durable) left[file] = *tracked.durable;
  }
  return left;
}

}  // namespace panelcal::test
