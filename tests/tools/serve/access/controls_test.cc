// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/controls.h"

#include <gtest/gtest.h>

namespace panelcal::serve {
namespace {

TEST(Controls, AreFreeAgainWithoutASignOfLife) {
  Controls controls;
  Now now{};
  const auto key = controls.take({"Anna", "", ""}, now);
  ASSERT_TRUE(key);
  now += Controls::kGrace - std::chrono::seconds(1);
  EXPECT_FALSE(controls.expire(now));
  EXPECT_EQ(controls.use(*key, now), "Anna");
  now += Controls::kGrace - std::chrono::seconds(1);
  EXPECT_FALSE(controls.expire(now));
  now += std::chrono::seconds(1);
  EXPECT_TRUE(controls.expire(now));
  EXPECT_EQ(controls.holder(), "");
  EXPECT_FALSE(controls.use(*key, now));
}

TEST(Controls, StayWithAScreenThatLooks) {
  Controls controls;
  Now now{};
  const auto key = controls.take({"Anna", "", ""}, now);
  controls.open_stream(*key, now);
  now += std::chrono::hours(5);
  EXPECT_FALSE(controls.expire(now));
  // A reload: the stream ends, and another one begins.
  controls.close_stream(*key, now);
  now += std::chrono::seconds(5);
  EXPECT_FALSE(controls.expire(now));
  controls.open_stream(*key, now);
  now += std::chrono::hours(5);
  EXPECT_FALSE(controls.expire(now));
}

TEST(Controls, OfAnEarlierHolderCountNoMore) {
  Controls controls;
  Now now{};
  const auto early = controls.take({"Anna", "", ""}, now);
  controls.open_stream(*early, now);
  const auto late = controls.take({"Ben", "", "Anna"}, now);
  ASSERT_TRUE(late);
  EXPECT_NE(*early, *late);
  // Anna's stream is still open; Ben has none.
  controls.close_stream(*early, now);
  now += Controls::kGrace;
  EXPECT_TRUE(controls.expire(now));
}

TEST(Controls, AreNotTakenByAnEmptyKey) {
  Controls controls;
  EXPECT_FALSE(controls.is_held_by(""));
  EXPECT_FALSE(controls.give_back(""));
  EXPECT_FALSE(controls.use("", Now{}));
  ASSERT_TRUE(controls.take({"Anna", "", ""}, Now{}));
  EXPECT_FALSE(controls.is_held_by(""));
  EXPECT_FALSE(controls.take({"Ben", "", ""}, Now{}));
}

TEST(Controls, HaveANumberThatGrowsWithEachChange) {
  Controls controls;
  const auto before = controls.number();
  const auto key = controls.take({"Anna", "", ""}, Now{});
  const auto taken = controls.number();
  EXPECT_GT(taken, before);
  controls.give_back(*key);
  EXPECT_GT(controls.number(), taken);
}

}  // namespace
}  // namespace panelcal::serve
