// SPDX-License-Identifier: Apache-2.0
#include "calib/base/thread_pool.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace panelcal {

ThreadPool::ThreadPool(std::size_t n_threads) {
  threads_.reserve(n_threads);
  try {
    for (std::size_t i = 0; i < n_threads; ++i) {
      threads_.emplace_back([this](const std::stop_token& stop) { work(stop); });
    }
  } catch (const std::system_error&) {
    if (threads_.empty()) throw;
  }
}

void ThreadPool::post(std::function<void()> task) {
  {
    const std::scoped_lock lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  has_task_.notify_one();
}

void ThreadPool::work(const std::stop_token& stop) {
  while (true) {
    std::function<void()> task;
    {
      std::unique_lock lock(mutex_);
      has_task_.wait(lock, stop, [this] { return !tasks_.empty(); });
      if (stop.stop_requested()) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
  }
}

std::unique_ptr<ThreadPool> make_thread_pool(std::size_t n_threads, std::size_t n_tasks) {
  const std::size_t n_wanted = n_threads > 0 ? n_threads : std::thread::hardware_concurrency();
  const std::size_t n = std::min(n_wanted, n_tasks);
  if (n < 2) return nullptr;
  try {
    return std::make_unique<ThreadPool>(n);
  } catch (const std::system_error&) {
    return nullptr;
  }
}

}  // namespace panelcal
