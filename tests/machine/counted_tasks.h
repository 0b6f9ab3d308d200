// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "calib/base/executor.h"

namespace panelcal::test {

/// Runs tasks at once, and counts them.
class CountedTasks final : public Executor {
 public:
  void post(std::function<void()> task) override {
    ++n_posted;
    task();
  }
  std::size_t n_threads() const override { return 2; }

  std::size_t n_posted = 0;
};

}  // namespace panelcal::test
