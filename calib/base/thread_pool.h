// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "calib/base/executor.h"

namespace panelcal {

/// A fixed number of threads that take tasks in the order in which they were posted; fewer than
/// asked for where the system gives no more, for want of memory or by a limit.
///
/// Fails  throws std::system_error where it gives none
/// See    tests/calib/base/thread_pool_test.cc
class ThreadPool final : public Executor {
 public:
  explicit ThreadPool(std::size_t n_threads);

  void post(std::function<void()> task) override;
  std::size_t n_threads() const override { return threads_.size(); }

 private:
  void work(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any has_task_;
  std::deque<std::function<void()>> tasks_;
  std::vector<std::jthread> threads_;  ///< last: they end before what they use
};

/// A pool for `n_tasks` of a command.
///
/// In     n_threads: as a person asks for them; 0: one for each processor
/// Out    null where one thread is enough, or where the system gives none
std::unique_ptr<ThreadPool> make_thread_pool(std::size_t n_threads, std::size_t n_tasks);

}  // namespace panelcal
