// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_lock.h"

#include <csignal>

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using testing::HasSubstr;

/// 2026-11-21T23:00:00Z.
constexpr std::chrono::sys_seconds kNow{std::chrono::seconds(1795302000)};

TEST(NightLock, IsHeldByOneAndSaysByWhom) {
  const test::TemporaryFolder folder;
  const std::filesystem::path ledger = folder.path() / "drill.ledger";
  EXPECT_EQ(NightLock::holder(ledger), "");
  {
    const auto lock = NightLock::take(ledger, kNow);
    ASSERT_TRUE(lock) << lock.error().text();
    EXPECT_EQ(lock->cut_off(), "");
    const std::string who = "process " + std::to_string(::getpid()) + " since 2026-11-21T23:00:00Z";
    EXPECT_THAT(NightLock::take(ledger, kNow), test::FailsWith(Code::LedgerBusy, who));
    EXPECT_THAT(NightLock::holder(ledger), HasSubstr(who));
  }
  EXPECT_EQ(NightLock::holder(ledger), "");
  const auto again = NightLock::take(ledger, kNow);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->cut_off(), "");
}

TEST(NightLock, IsFreedByKillAndTheNextRunIsTold) {
  const test::TemporaryFolder folder;
  const std::filesystem::path ledger = folder.path() / "drill.ledger";
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const auto lock = NightLock::take(ledger, kNow);
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const auto lock = NightLock::take(ledger, kNow);
  ASSERT_TRUE(lock) << lock.error().text();
  EXPECT_EQ(lock->cut_off(), "process " + std::to_string(child) + " since 2026-11-21T23:00:00Z");
}

TEST(NightLock, SaysWhereItCannotBeWritten) {
  EXPECT_THAT(NightLock::take("/nowhere/drill.ledger", kNow),
              test::FailsWith(Code::DeviceWrite, "lock"));
}

}  // namespace
}  // namespace panelcal
