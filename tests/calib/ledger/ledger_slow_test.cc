// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include "calib/ledger/ledger.h"
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/calib/ledger/drafts.h"
#include "tests/calib/ledger/power_cut_vfs.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::first_night;
using test::offset_draft;
using test::spindle;

/// On a loaded machine the others take their time.
LedgerOptions patient() {
  LedgerOptions options;
  options.busy_timeout = std::chrono::milliseconds(120000);
  return options;
}

class LedgerSlowTest : public test::LedgerFolder {
 protected:
  /// Appends for ever, and says through the pipe which entries were acknowledged.
  [[noreturn]] static void keep_appending(const std::filesystem::path& path, int pipe) {
    Expected<Ledger> ledger = Ledger::open(path, first_night(), patient());
    if (!ledger) ::_exit(1);
    for (double x_mm = 0;; x_mm += 1) {
      LedgerDraft draft = offset_draft(x_mm);
      draft.result = '"' + std::string(20000, 'r') + '"';  // more pages, more moments
      const Expected<LedgerEntry> entry = ledger->append(draft);
      if (!entry) ::_exit(1);
      if (::write(pipe, &entry->id, sizeof entry->id) != sizeof entry->id) ::_exit(1);
    }
  }

  /// Kills such a child after a while; returns the last entry it had acknowledged, 0 if none.
  static std::int64_t last_before_kill(const std::filesystem::path& path,
                                       std::chrono::microseconds after) {
    int ends[2] = {-1, -1};
    EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    const pid_t child = ::fork();
    if (child == 0) keep_appending(path, ends[1]);
    ::close(ends[1]);
    std::this_thread::sleep_for(after);
    ::kill(child, SIGKILL);
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status)) << "the child ended by itself: " << status;
    std::int64_t last = 0;
    std::int64_t id = 0;
    while (::read(ends[0], &id, sizeof id) == sizeof id) last = id;
    ::close(ends[0]);
    return last;
  }

  /// The exit code of `work` in a process of its own.
  template <class Work>
  static int in_child(const Work& work) {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(work());
    int status = 0;
    if (::waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
    return WEXITSTATUS(status);
  }
};

/// 100 moments, seed 1; every tenth ledger is new, so that its making is hit too.
TEST_F(LedgerSlowTest, SurvivesKillAtRandomMoments) {
  constexpr int kTrials = 100;
  Random random(1);
  std::int64_t n_acknowledged = 0;
  int n_with_entries = 0;
  LedgerHead before;
  std::filesystem::path path;
  for (int i = 0; i < kTrials; ++i) {
    if (i % 10 == 0) {
      path = folder_ / ("ledger " + std::to_string(i));
      before = {};
    }
    const std::chrono::microseconds after(static_cast<int>(random.uniform(0, 150000)));
    const std::int64_t last = last_before_kill(path, after);
    const std::int64_t acknowledged = std::max(last, before.id);
    n_acknowledged += acknowledged - before.id;
    n_with_entries += acknowledged > before.id ? 1 : 0;
    const Expected<Ledger> ledger = Ledger::open(path, first_night());
    ASSERT_TRUE(ledger) << "trial " << i << ": " << ledger.error().text();
    const Expected<LedgerHead> head = ledger->verify();
    ASSERT_TRUE(head) << "trial " << i << ": " << head.error().text();
    EXPECT_GE(head->id, acknowledged) << "trial " << i;
    // The one that was under way may be there too.
    EXPECT_LE(head->id, acknowledged + 1) << "trial " << i;
    if (before.id > 0) {
      EXPECT_EQ(ledger->entry(before.id)->hash, before.hash) << "trial " << i;
    }
    before = *head;
  }
  RecordProperty("acknowledged", std::to_string(n_acknowledged));
  EXPECT_GT(n_with_entries, kTrials / 4) << "kills came too early to mean anything";
}

/// Every moment between two orders to the disk, three draws each, seed 2.
TEST_F(LedgerSlowTest, SurvivesPowerCutsAtEveryMoment) {
  constexpr int kDraws = 3;
  ASSERT_TRUE(opened().append(offset_draft(0)));
  const std::string file = std::filesystem::absolute(path()).string();
  const test::DiskContent start = {{file, read_file(path()).value()}};
  struct Acknowledged {
    std::size_t n_orders;
    std::string hash;
  };
  std::vector<Acknowledged> acknowledged = {{0, opened().head()->hash}};
  std::vector<test::DiskOrder> orders;
  {
    const test::DiskRecorder recorder;
    Ledger ledger = opened();
    for (int i = 1; i <= 6; ++i) {
      LedgerDraft draft = offset_draft(i);
      if (i == 3) draft.result = '"' + std::string(50000, 'r') + '"';
      const Expected<LedgerEntry> entry = ledger.append(draft);
      ASSERT_TRUE(entry) << entry.error().text();
      acknowledged.push_back({recorder.orders().size(), entry->hash});
    }
    orders = recorder.orders();
  }
  ASSERT_GT(orders.size(), 60u);
  const std::filesystem::path disk = folder_ / "disk";
  Random random(2);
  int n_rolled_back = 0;
  for (std::size_t n = 0; n <= orders.size(); ++n) {
    for (int draw = 0; draw < kDraws; ++draw) {
      std::filesystem::remove_all(disk);
      std::filesystem::create_directory(disk);
      const test::DiskContent left = test::after_power_cut(start, orders, n, random);
      for (const auto& [name, content] : left) {
        std::ofstream(disk / std::filesystem::path(name).filename(), std::ios::binary) << content;
      }
      n_rolled_back += left.size() > 1 ? 1 : 0;
      std::int64_t n_sure = 0;
      while (n_sure < std::ssize(acknowledged) && acknowledged[n_sure].n_orders <= n) ++n_sure;
      const Expected<Ledger> ledger =
          Ledger::open(disk / path().filename(), first_night(), {.n_checked = 0});
      ASSERT_TRUE(ledger) << n << " orders: " << ledger.error().text();
      const Expected<LedgerHead> head = ledger->verify();
      ASSERT_TRUE(head) << n << " orders: " << head.error().text();
      ASSERT_GE(head->id, n_sure) << n << " orders";
      ASSERT_LE(head->id, std::min<std::int64_t>(n_sure + 1, std::ssize(acknowledged)));
      EXPECT_EQ(head->hash, acknowledged[static_cast<std::size_t>(head->id) - 1].hash);
    }
  }
  EXPECT_GT(n_rolled_back, 50) << "no journal was ever left: nothing was tested";
}

TEST_F(LedgerSlowTest, SharesOneLedgerAmongProcesses) {
  constexpr int kProcesses = 4;
  constexpr int kEntries = 25;
  std::vector<pid_t> children;
  for (int i = 1; i <= kProcesses; ++i) {
    const pid_t child = ::fork();
    if (child == 0) {
      // All of them start the ledger at once, too.
      Expected<Ledger> ledger = Ledger::open(path(), first_night(), patient());
      if (!ledger) ::_exit(1);
      for (int k = 0; k < kEntries; ++k) {
        if (!ledger->append(offset_draft(k, LedgerVerdict::Installed, i))) ::_exit(2);
      }
      ::_exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  }
  const Ledger ledger = opened();
  EXPECT_EQ(ledger.verify()->id, kProcesses * kEntries);
  for (int i = 1; i <= kProcesses; ++i) {
    const auto own = ledger.list({.subject = spindle(i).subject}).value();
    ASSERT_EQ(own.size(), static_cast<std::size_t>(kEntries));
    for (int k = 0; k < kEntries; ++k) {
      EXPECT_EQ(own[k].record.parameters[0].value, k);
      if (k > 0) {
        EXPECT_EQ(own[k].record.replaces, own[k - 1].id);
      }
    }
  }
}

bool write_text(const char* file, const std::string& text) {
  std::ofstream out(file);
  out << text << std::flush;
  return out.good();
}

/// Mounts a disk of 160 KiB for this process alone: as root, else as root of a name space.
bool mount_small_disk(const std::filesystem::path& folder) {
  if (::unshare(CLONE_NEWNS) != 0) {
    const std::string user = std::to_string(::geteuid());
    const std::string group = std::to_string(::getegid());
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
    // Files on the disk need an owner that the name space knows.
    if (!write_text("/proc/self/setgroups", "deny") ||
        !write_text("/proc/self/uid_map", "0 " + user + " 1") ||
        !write_text("/proc/self/gid_map", "0 " + group + " 1")) {
      return false;
    }
  }
  ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
  return ::mount("tmpfs", folder.c_str(), "tmpfs", 0, "size=160k") == 0;
}

/// The largest file that this process may write; nothing lifts it above the hard limit.
void limit_files(rlim_t n_bytes) {
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  limit.rlim_cur = std::min(n_bytes, limit.rlim_max);
  ::setrlimit(RLIMIT_FSIZE, &limit);
}

/// A disk of 160 KiB; where none can be mounted, files of at most that size.
TEST_F(LedgerSlowTest, RecordsNothingOnAFullDisk) {
  const std::filesystem::path disk = folder_ / "disk";
  std::filesystem::create_directory(disk);
  const int code = in_child([&] {
    const bool is_mounted = mount_small_disk(disk);
    if (!is_mounted) {
      ::signal(SIGXFSZ, SIG_IGN);
      limit_files(160 * 1024);
    }
    Expected<Ledger> ledger = Ledger::open(disk / "ledger", first_night());
    if (!ledger) return 1;
    const std::string filler = (disk / "filler").string();
    if (is_mounted && !write_file(filler, std::string(32768, 'f'))) return 2;
    LedgerHead last;
    for (int i = 0;; ++i) {
      if (i == 1000) return 3;
      const Expected<LedgerEntry> entry = ledger->append(offset_draft(i));
      if (entry) {
        last = {entry->id, entry->hash};
        continue;
      }
      if (entry.error().code != Code::DeviceWrite) return 4;
      const bool says_full = entry.error().text().find("disk is full") != std::string::npos;
      if (is_mounted && !says_full) return 5;
      break;
    }
    if (last.id == 0 || !(ledger->verify() == last)) return 6;
    if (is_mounted) {
      std::ofstream(disk / "rest") << std::string(200000, 'f');
    } else {
      limit_files(0);
    }
    // Neither can a ledger be started, and nothing is left of the attempt.
    const Expected<Ledger> other = Ledger::open(disk / "other", first_night());
    if (other || other.error().code != Code::DeviceWrite) return 7;
    std::filesystem::remove(filler);
    std::filesystem::remove(disk / "rest");
    limit_files(RLIM_INFINITY);
    const Expected<LedgerEntry> next = ledger->append(offset_draft(0));
    if (!next || next->id != last.id + 1) return 8;
    int n_files = 0;
    for (const auto& ignored : std::filesystem::directory_iterator(disk)) {
      static_cast<void>(ignored);
      ++n_files;
    }
    return n_files == 1 ? 0 : 9;
  });
  EXPECT_EQ(code, 0);
}

}  // namespace
}  // namespace panelcal
