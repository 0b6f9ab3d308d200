// SPDX-License-Identifier: Apache-2.0
// A disk that is full in the middle of a night: no file may grow beyond a limit of the system's.

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <sys/resource.h>

#include "tests/machine/nightly/cut_night.h"
#include "tests/machine/nightly/fake_night.h"

namespace panelcal {
namespace {

using testing::HasSubstr;

class NightlyFullDisk : public test::NightTest {
 protected:
  /// A night during which no file grows beyond so many bytes; its exit code. What it says is in the
  /// file "said".
  int run_with_limit(std::uintmax_t limit) {
    return test::exit_code_of_child([&] {
      // A write that does not fit fails then, as on a full disk, and does not end the process.
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit most = {limit, limit};
      if (::setrlimit(RLIMIT_FSIZE, &most) != 0) return 100;
      const Expected<NightRecord> record = run(job());
      const std::string said = record ? record->verdict : record.error().text();
      if (!write_file(folder_.path() / "said", said.substr(0, limit))) return 101;
      return record ? exit_code(*record) : 3;
    });
  }
  std::string said() const { return read_file(folder_.path() / "said").value_or(""); }
};

TEST_F(NightlyFullDisk, IsSaidAndLeavesTheLedgerInOrderWhereverItHits) {
  constexpr std::uintmax_t kStep = 4096;
  constexpr int kSteps = 12;
  ASSERT_NO_FATAL_FAILURE(learn(6));
  int n_failed = 0;
  for (int i = 0; i < kSteps; ++i) {
    SCOPED_TRACE(std::to_string(i) + " steps of room");
    const std::vector<std::string> before = test::ledger_lines(ledger());
    const std::string file_before = file();
    const auto size = std::filesystem::file_size(config_.ledger_file);
    const int code = run_with_limit(size + static_cast<std::uintmax_t>(i) * kStep);
    const bool is_done = code == 0 || code == 1;
    ASSERT_TRUE(is_done || code == 3) << code << ": " << said();
    ASSERT_TRUE(ledger().verify());
    const std::vector<std::string> after = test::ledger_lines(ledger());
    ASSERT_GE(after.size(), before.size());
    EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin()));
    if (!is_done) {
      ++n_failed;
      EXPECT_THAT(said(), testing::AnyOf(HasSubstr("full"), HasSubstr("disk"), HasSubstr("large")));
      EXPECT_THAT(file(), testing::AnyOf(file_before, in_force()));
    }
    // There is room again: the same night, and the one after it.
    ASSERT_NE(exit_code(run()), 3);
    EXPECT_EQ(file(), in_force());
    next_night();
    ASSERT_NE(exit_code(run()), 3);
    next_night();
  }
  // Without any room nothing can be recorded.
  EXPECT_GE(n_failed, 1);
  EXPECT_LT(n_failed, kSteps);
}

}  // namespace
}  // namespace panelcal
