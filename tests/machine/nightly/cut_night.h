// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "calib/ledger/ledger.h"
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace panelcal::test {

/// All that a ledger has, as it stands there.
inline std::vector<std::string> ledger_lines(const Ledger& ledger) {
  const auto list = ledger.list({});
  if (!list) ADD_FAILURE() << list.error().text();
  std::vector<std::string> out;
  if (!list) return out;
  for (const LedgerEntry& entry : *list) out.push_back(ledger_entry_json(entry) + entry.hash);
  return out;
}

/// Runs something in a process of its own and gives its exit code; -1 if a signal ended it.
inline int exit_code_of_child(const std::function<int()>& run,
                              const std::function<void(pid_t)>& meanwhile = {}) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(run());
  EXPECT_GT(child, 0);
  if (meanwhile) meanwhile(child);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Runs a night in a process that is killed after a while; true if it was killed at work.
///
/// In     run: whether it came to its end
inline bool is_killed(std::chrono::microseconds after, const std::function<bool()>& run) {
  const int code = exit_code_of_child([&] { return run() ? 0 : 1; },
                                      [after](pid_t child) {
                                        std::this_thread::sleep_for(after);
                                        ::kill(child, SIGKILL);
                                      });
  EXPECT_NE(code, 1);
  return code < 0;
}

}  // namespace panelcal::test
