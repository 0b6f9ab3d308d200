// SPDX-License-Identifier: Apache-2.0
// kill -9 at 100 random moments: nothing that was recorded is lost, and after the next run the
// calibration file is the one in force.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/machine/nightly/fake_night.h"

namespace panelcal {
namespace {

using std::chrono::steady_clock;

class NightlyKill : public test::NightTest {
 protected:
  /// All that the ledger has, as it stands there.
  std::vector<std::string> entries() const {
    const Ledger ledger = this->ledger();
    const auto list = ledger.list({});
    if (!list) ADD_FAILURE() << list.error().text();
    std::vector<std::string> out;
    for (const LedgerEntry& entry : *list) out.push_back(ledger_entry_json(entry) + entry.hash);
    return out;
  }

  /// Runs a night in a process that is killed after a while; true if it was killed at work.
  bool run_and_kill(std::chrono::microseconds after) {
    const pid_t child = ::fork();
    if (child == 0) {
      const bool is_done = run(job()).has_value();
      ::_exit(is_done ? 0 : 1);
    }
    EXPECT_GT(child, 0);
    std::this_thread::sleep_for(after);
    ::kill(child, SIGKILL);
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
    return WIFSIGNALED(status);
  }
};

TEST_F(NightlyKill, LosesNoCommittedNightAt100RandomMoments) {
  constexpr int kKills = 100;
  // How long a night takes here, so that kills fall all over it.
  run();
  next_night();
  const auto begin = steady_clock::now();
  run();
  const auto whole =
      std::chrono::duration_cast<std::chrono::microseconds>(steady_clock::now() - begin);
  Random random(11);
  int n_killed = 0;
  int n_nights = 2;
  for (int i = 0; n_killed < kKills && i < 3 * kKills; ++i) {
    SCOPED_TRACE("kill " + std::to_string(i));
    next_night();
    ++n_nights;
    const std::vector<std::string> before = entries();
    n_killed += run_and_kill(std::chrono::microseconds(
        static_cast<std::int64_t>(random.uniform(0, 1.1) * static_cast<double>(whole.count()))));
    // What was recorded before is all there, and what came is whole.
    const std::vector<std::string> after = entries();
    ASSERT_GE(after.size(), before.size());
    ASSERT_TRUE(std::equal(before.begin(), before.end(), after.begin()));
    ASSERT_TRUE(ledger().verify());
    // The same night again, to its end.
    const NightRecord record = run();
    // A healthy night in some hundreds is refused.
    ASSERT_NE(exit_code(record), 3) << record.verdict;
    ASSERT_EQ(file(), in_force());
    const Ledger ledger = this->ledger();
    const auto tonight =
        read_night_history(ledger, calibration_, night_of(now_, nightly_.noon_utc_h), now_);
    ASSERT_TRUE(tonight);
    ASSERT_TRUE(tonight->tonight);
    // No night was calibrated twice into the ledger.
    ASSERT_EQ(tonight->series.points.size(), static_cast<std::size_t>(n_nights));
  }
  EXPECT_EQ(n_killed, kKills);
}

}  // namespace
}  // namespace panelcal
