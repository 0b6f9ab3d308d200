// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/login.h"

#include "tools/serve/access/secret.h"
#include <gtest/gtest.h>

namespace panelcal::serve {
namespace {

using std::chrono::seconds;

TEST(Attempts, AreLimitedForEachAddress) {
  Attempts attempts({seconds(60), 3, 100});
  Now now{};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(attempts.wait_of("192.0.2.1", now), seconds(0));
    attempts.note_wrong("192.0.2.1", now);
    now += seconds(10);
  }
  // The first one is forgotten 60 s after it.
  EXPECT_EQ(attempts.wait_of("192.0.2.1", now), seconds(30));
  EXPECT_EQ(attempts.wait_of("192.0.2.2", now), seconds(0));
  now += seconds(30);
  EXPECT_EQ(attempts.wait_of("192.0.2.1", now), seconds(0));
}

TEST(Attempts, AreLimitedForAllAddressesTogether) {
  Attempts attempts({seconds(60), 3, 10});
  const Now now{};
  for (int i = 0; i < 10; ++i) attempts.note_wrong("192.0.2." + std::to_string(i), now);
  EXPECT_EQ(attempts.wait_of("192.0.2.200", now), seconds(60));
}

TEST(Attempts, TakeANetworkOfIpv6ForOneAddress) {
  EXPECT_EQ(network_of("2001:db8::1"), network_of("2001:db8::ffff:1"));
  EXPECT_NE(network_of("2001:db8::1"), network_of("2001:db8:1::1"));
  EXPECT_NE(network_of("::ffff:192.0.2.1"), network_of("::ffff:192.0.2.2"));
  EXPECT_EQ(network_of("192.0.2.1"), "192.0.2.1");
}

TEST(Login, KnowsTheSessionsThatItOpened) {
  Login login(Token("salt", salted_hash("salt", "token")));
  const Now now{};
  const Login::Answer answer = login.log_in("token", "192.0.2.1", now);
  ASSERT_FALSE(answer.session.empty());
  EXPECT_TRUE(login.is_session(answer.session, now));
  EXPECT_FALSE(login.is_session(answer.session + "x", now));
  EXPECT_FALSE(login.is_session("", now));
  EXPECT_TRUE(login.log_in("tokem", "192.0.2.1", now).session.empty());
  EXPECT_TRUE(login.log_in("", "192.0.2.1", now).session.empty());
  EXPECT_FALSE(login.is_session(answer.session, now + Login::kSessionLength));
}

TEST(Login, LetsTheRightTokenPassHoweverManyAreWrong) {
  Login login(Token("salt", salted_hash("salt", "token")));
  const Now now{};
  for (int i = 0; i < 100; ++i) {
    const std::string address = "192.0.2." + std::to_string(i % 10);
    const Login::Answer answer = login.log_in("guess", address, now);
    EXPECT_TRUE(answer.session.empty());
    EXPECT_EQ(answer.wait.count() > 0, i >= 50) << i;
  }
  EXPECT_FALSE(login.log_in("token", "192.0.2.1", now).session.empty());
}

TEST(Secret, IsLongAndNeverTheSame) {
  const std::string one = random_secret();
  EXPECT_EQ(one.size(), 25U);
  EXPECT_NE(one, random_secret());
}

TEST(Secret, IsComparedWhole) {
  EXPECT_TRUE(is_equal_in_constant_time("abc", "abc"));
  EXPECT_TRUE(is_equal_in_constant_time("", ""));
  for (const char* const other : {"abd", "bbc", "ab", "abcd", ""}) {
    EXPECT_FALSE(is_equal_in_constant_time("abc", other)) << other;
  }
}

}  // namespace
}  // namespace panelcal::serve
