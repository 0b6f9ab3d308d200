// SPDX-License-Identifier: Apache-2.0
// kill -9 at 100 random moments: nothing that was recorded is lost, and after the next run the
// calibration file is the one in force.

#include <algorithm>
#include <chrono>

#include <gmock/gmock.h>

#include "tests/machine/nightly/cut_night.h"
#include "tests/machine/nightly/fake_night.h"

namespace panelcal {
namespace {

using std::chrono::steady_clock;

class NightlyKill : public test::NightTest {
 protected:
  std::vector<std::string> entries() const { return test::ledger_lines(this->ledger()); }
  bool run_and_kill(std::chrono::microseconds after) {
    return test::is_killed(after, [this] { return run(job()).has_value(); });
  }
};

TEST_F(NightlyKill, LosesNoCommittedNightAt100RandomMoments) {
  constexpr int kKills = 100;
  // Duration of a night here, so that kills fall all over it.
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
    // All entries recorded before are there, and a new one is whole.
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
