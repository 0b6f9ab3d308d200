// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "tests/machine/devices/controls/linuxcnc/fault_series.h"

namespace panelcal::test {
namespace {

constexpr int kFaultsPerKind = 15;

/// A mode that changes between two moves is set again, the right to control is taken at the
/// beginning, some settings are as they should be without an order, and behind the touch no probe
/// is needed: the job may come to its end.
bool may_do_no_harm(CncFault fault) {
  return fault == CncFault::Nak || fault == CncFault::Mode || fault == CncFault::Steal ||
         fault == CncFault::ProbeStuck;
}

/// Feed hold between two moves looks like another's line that runs.
bool names_cause(CncFault fault, const std::string& text) {
  if (text.empty()) return may_do_no_harm(fault);
  return text.find(cause_of(fault)) != std::string::npos ||
         (fault == CncFault::Hold && text.find("executes something else") != std::string::npos);
}

/// 14 kinds at 15 places each over a job of two moves and a touch.
TEST(LinuxCncFaults, EndWithTheirCauseAndTheMachineStanding) {
  const int n_requests = run_with_fault(CncFault::None, -1).n_requests;
  std::map<std::string, int> ends;
  for (int kind = 1; kind <= static_cast<int>(CncFault::ProbeStuck); ++kind) {
    const auto fault = static_cast<CncFault>(kind);
    for (int i = 0; i < kFaultsPerKind; ++i) {
      // How many requests a job has depends on the time: none of the last ones.
      const int at = n_requests * 17 / 20 * i / kFaultsPerKind;
      SCOPED_TRACE(::testing::Message() << "fault " << kind << " at request " << at);
      const FaultedJob job = run_with_fault(fault, at);
      EXPECT_FALSE(job.was_low);
      const bool is_stopped = job.text.find("could not be stopped") == std::string::npos;
      EXPECT_FALSE(job.moves_on && is_stopped) << job.text;
      EXPECT_TRUE(names_cause(fault, job.text)) << job.text;
      ++ends[job.text.empty() ? "job whole"
             : is_stopped     ? job.text.find("machine stands") == std::string::npos
                                    ? "refused before a move"
                                    : "stopped"
                              : "said that it could not be stopped"];
    }
  }
  for (const auto& [end, n] : ends) RecordProperty(end, n);
  for (const auto& [end, n] : ends) std::cout << end << ": " << n << "\n";
}

}  // namespace
}  // namespace panelcal::test
