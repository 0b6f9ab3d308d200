// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/controls.h"

#include <atomic>
#include <string>
#include <string_view>
#include <thread>

#include <gtest/gtest.h>

namespace panelcal::serve {
namespace {

/// The name of who may act with this key; empty: none.
std::string user(Controls& controls, std::string_view key, Now now) {
  std::string name;
  const auto done = controls.while_held(key, now, [&](const std::string& who) {
    name = who;
    return Expected<void>();
  });
  EXPECT_EQ(done.has_value(), !name.empty());
  return name;
}

std::string stream_of(const std::string& key) {
  return key.substr(key.find('.') + 1);
}

TEST(Controls, AreFreeAgainWithoutASignOfLife) {
  Controls controls;
  Now now{};
  const auto key = controls.take({"Anna", "", ""}, now);
  ASSERT_TRUE(key);
  now += Controls::kGrace - std::chrono::seconds(1);
  EXPECT_FALSE(controls.expire(now));
  EXPECT_EQ(user(controls, *key, now), "Anna");
  now += Controls::kGrace - std::chrono::seconds(1);
  EXPECT_FALSE(controls.expire(now));
  now += std::chrono::seconds(1);
  EXPECT_TRUE(controls.expire(now));
  EXPECT_EQ(controls.holder(), "");
  EXPECT_EQ(user(controls, *key, now), "");
}

TEST(Controls, StayWithAScreenThatLooks) {
  Controls controls;
  Now now{};
  const auto key = controls.take({"Anna", "", ""}, now);
  const auto stream = controls.open_stream(stream_of(*key), now);
  now += std::chrono::hours(5);
  EXPECT_FALSE(controls.expire(now));
  // A reload: the stream ends, and another one begins.
  controls.close_stream(stream, now);
  now += std::chrono::seconds(5);
  EXPECT_FALSE(controls.expire(now));
  controls.open_stream(stream_of(*key), now);
  now += std::chrono::hours(5);
  EXPECT_FALSE(controls.expire(now));
}

TEST(Controls, OfAnEarlierHolderCountNoMore) {
  Controls controls;
  Now now{};
  const auto early = controls.take({"Anna", "", ""}, now);
  const auto stream = controls.open_stream(stream_of(*early), now);
  const auto late = controls.take({"Ben", "", "Anna"}, now);
  ASSERT_TRUE(late);
  EXPECT_NE(*early, *late);
  // Anna's stream is still open; Ben has none.
  controls.close_stream(stream, now);
  now += Controls::kGrace;
  EXPECT_TRUE(controls.expire(now));
}

TEST(Controls, AreNotTakenByAnEmptyKey) {
  Controls controls;
  EXPECT_FALSE(controls.is_held_by(""));
  EXPECT_FALSE(controls.give_back(""));
  EXPECT_EQ(user(controls, "", Now{}), "");
  ASSERT_TRUE(controls.take({"Anna", "", ""}, Now{}));
  EXPECT_FALSE(controls.is_held_by(""));
  EXPECT_FALSE(controls.take({"Ben", "", ""}, Now{}));
}

TEST(Controls, OfADuplicatedScreenBelongToTheNewestStream) {
  Controls controls;
  const auto key = controls.take({"Anna", "", ""}, Now{});
  const auto first = controls.open_stream(stream_of(*key), Now{});
  EXPECT_TRUE(controls.is_mine(first));
  const auto second = controls.open_stream(stream_of(*key), Now{});
  EXPECT_FALSE(controls.is_mine(first));
  EXPECT_TRUE(controls.is_mine(second));
  controls.close_stream(second, Now{});
  EXPECT_TRUE(controls.is_mine(first));
  EXPECT_FALSE(controls.is_mine(0));
}

TEST(Controls, AreNotGivenByTheNameOfAStream) {
  Controls controls;
  const auto key = controls.take({"Anna", "", ""}, Now{});
  EXPECT_FALSE(controls.is_held_by(stream_of(*key)));
  EXPECT_EQ(user(controls, stream_of(*key), Now{}), "");
  EXPECT_EQ(controls.open_stream(key->substr(0, key->find('.')), Now{}), 0U);
  EXPECT_EQ(controls.open_stream("", Now{}), 0U);
}

TEST(Controls, ChangeHandsAfterTheCommandThatActs) {
  Controls controls;
  const auto key = controls.take({"Anna", "", ""}, Now{});
  std::thread taker;
  std::atomic<bool> is_taken = false;
  const auto done = controls.while_held(*key, Now{}, [&](const std::string& /*name*/) {
    taker = std::thread([&] {
      controls.take({"Ben", "", "Anna"}, Now{});
      is_taken = true;
    });
    // Long enough for the other thread to take them, if it could.
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(is_taken);
    EXPECT_EQ(controls.holder(), "Anna");
    EXPECT_FALSE(controls.expire(Now{} + std::chrono::hours(1)));
    return Expected<void>();
  });
  EXPECT_TRUE(done);
  taker.join();
  EXPECT_EQ(controls.holder(), "Ben");
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
