// SPDX-License-Identifier: Apache-2.0
#include "calib/base/thread_pool.h"

#include <atomic>
#include <memory>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

std::vector<std::size_t> squares(Executor* executor, std::size_t n, std::size_t n_taken) {
  std::vector<std::size_t> taken;
  make_in_order(
      executor,
      n,
      [](std::size_t i) { return i * i; },
      [&](std::size_t i, std::size_t square) {
        EXPECT_EQ(i, taken.size());
        taken.push_back(square);
        return taken.size() < n_taken;
      });
  return taken;
}

TEST(ThreadPool, GivesTheSameResultsInTheSameOrderWithAnyNumberOfThreads) {
  const auto alone = squares(nullptr, 500, 500);
  ASSERT_EQ(alone.size(), 500U);
  for (const std::size_t n_threads : {1U, 2U, 7U}) {
    ThreadPool pool(n_threads);
    EXPECT_EQ(squares(&pool, 500, 500), alone);
    EXPECT_EQ(squares(&pool, 500, 3), squares(nullptr, 500, 3));
    EXPECT_EQ(squares(&pool, 0, 1), squares(nullptr, 0, 1));
  }
}

TEST(ThreadPool, PassesOnWhatATaskThrows) {
  ThreadPool pool(2);
  std::atomic<int> n_made = 0;
  const auto make = [&](std::size_t i) {
    ++n_made;
    if (i == 3) throw std::runtime_error("three");
    return i;
  };
  EXPECT_THROW(make_in_order(&pool, 100, make, [](std::size_t, std::size_t) { return true; }),
               std::runtime_error);
  EXPECT_LE(n_made, 3 + static_cast<int>(pool.lead()) + 1);
}

TEST(ThreadPool, DropsWhatHasNotBegunWhenItEnds) {
  std::vector<std::future<int>> results;
  {
    ThreadPool pool(1);
    std::promise<void> is_over;
    const auto wait = is_over.get_future().share();
    results.push_back(submit(pool, [wait] { return wait.wait(), 1; }));
    for (int i = 0; i < 100; ++i) results.push_back(submit(pool, [] { return 2; }));
    is_over.set_value();
    EXPECT_EQ(results.front().get(), 1);
  }
  for (std::size_t i = 1; i < results.size(); ++i) results[i].wait();  // given or broken
}

TEST(ThreadPool, IsNotMadeWhereOneThreadIsEnough) {
  EXPECT_EQ(make_thread_pool(1, 100), nullptr);
  EXPECT_EQ(make_thread_pool(0, 1), nullptr);
  EXPECT_EQ(make_thread_pool(8, 3)->n_threads(), 3U);
}

}  // namespace
}  // namespace panelcal
