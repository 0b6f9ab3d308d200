// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/digest.h"
#include "calib/ledger/ledger.h"
#include <gtest/gtest.h>

namespace panelcal::test {

/// 2026-11-21T08:37:38Z.
inline constexpr std::chrono::sys_seconds kFirstNight{std::chrono::seconds(1795250258)};

inline Clock first_night() {
  return fixed_clock(kFirstNight);
}

inline LedgerKey spindle(int number) {
  return {"drill 1", LedgerKind::SpindleCamera, "spindle " + std::to_string(number) + " station 1"};
}

/// An offset of a spindle's camera as one night measures it.
inline LedgerDraft offset_draft(double x_mm,
                                LedgerVerdict verdict = LedgerVerdict::Installed,
                                int number = 1) {
  LedgerDraft draft;
  LedgerRecord& record = draft.record;
  record.key = spindle(number);
  record.verdict = verdict;
  record.reason = "all gates passed";
  record.asked_by = "timer";
  record.software = "panelcal 0.1.0";
  record.temperature_degC = 21.25;
  record.inputs = {{"coupon.png", sha256("coupon"), 6}};
  record.parameters = {{"offset_x", x_mm, "mm"}, {"offset_y", -0.1, "mm"}};
  Eigen::MatrixXd cov(2, 2);
  cov << 4e-6, 1e-6, 1e-6, 9e-6;
  record.covariance = cov;
  draft.result = R"({"kind": "spindle-camera", "offset_mm": [)" + std::to_string(x_mm) + ", -0.1]}";
  return draft;
}

/// An empty folder of its own for every test.
class LedgerFolder : public ::testing::Test {
 protected:
  LedgerFolder() {
    std::string pattern = ::testing::TempDir() + "ledger_test_XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
  }
  ~LedgerFolder() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::filesystem::path path() const { return folder_ / "drill 1.ledger"; }

  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  /// A ledger that could be opened; the test stops otherwise.
  Ledger opened(Clock clock = first_night()) const {
    Expected<Ledger> ledger = Ledger::open(path(), std::move(clock));
    if (!ledger) ADD_FAILURE() << ledger.error().text();
    return std::move(ledger).value();
  }

  std::filesystem::path folder_;
};

}  // namespace panelcal::test
