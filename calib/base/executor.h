// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <type_traits>
#include <utility>

namespace panelcal {

/// Runs tasks on threads of its own. Libraries are handed one, or none, and start no thread.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Begins the task on one of its threads, after those that were posted before. A task that has
  /// not begun when the executor ends is dropped.
  virtual void post(std::function<void()> task) = 0;
  virtual std::size_t n_threads() const = 0;

  /// Number of tasks to keep under way, so that no thread waits for the one that takes the results.
  std::size_t lead() const { return 2 * n_threads() + 1; }
};

/// Begins a task; its result, or what it throws, comes through the future.
template <class Task>
std::future<std::invoke_result_t<Task>> submit(Executor& executor, Task task) {
  // Shared, since std::function wants tasks that can be copied.
  auto shared = std::make_shared<std::packaged_task<std::invoke_result_t<Task>()>>(std::move(task));
  auto result = shared->get_future();
  executor.post([shared] { (*shared)(); });
  return result;
}

/// Makes n results on an executor's threads, a few ahead, and takes them in order on this one; what
/// is taken does not depend on the number of threads.
///
/// In     executor: null makes each result on this thread when its turn comes
///        make(i): called on any thread, several at once
///        take(i, result): false ends it
template <class Make, class Take>
void make_in_order(Executor* executor, std::size_t n, const Make& make, const Take& take) {
  using Result = std::invoke_result_t<const Make&, std::size_t>;
  if (executor == nullptr) {
    for (std::size_t i = 0; i < n && take(i, make(i)); ++i) {
    }
    return;
  }
  // Tasks refer to `make`, so that none may be left when this returns or throws.
  struct Pending : std::deque<std::future<Result>> {
    ~Pending() { std::ranges::for_each(*this, &std::future<Result>::wait); }
  } pending;
  std::size_t n_begun = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (; n_begun < std::min(n, i + executor->lead()); ++n_begun) {
      pending.push_back(submit(*executor, [&make, k = n_begun] { return make(k); }));
    }
    // Out of the queue first: get() may throw, and what it leaves cannot be waited for.
    std::future<Result> next = std::move(pending.front());
    pending.pop_front();
    if (!take(i, next.get())) return;
  }
}

}  // namespace panelcal
