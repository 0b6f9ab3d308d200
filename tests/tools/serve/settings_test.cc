// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::serve {
namespace {

using ::testing::HasSubstr;

Listener listener_on(const std::string& address) {
  auto listener = Listener::open(address);
  EXPECT_TRUE(listener) << listener.error().text();
  return *std::move(listener);
}

TEST(ServeSettings, NeedNothingOnLoopback) {
  EXPECT_TRUE(check_access({}, listener_on("127.0.0.1:0")));
}

TEST(ServeSettings, NeedATokenAndTlsOnAnyOtherAddress) {
  const Listener listener = listener_on("0.0.0.0:0");
  AccessSettings settings;
  const auto without_token = check_access(settings, listener);
  ASSERT_FALSE(without_token);
  EXPECT_EQ(without_token.error().code, Code::Usage);
  EXPECT_THAT(without_token.error().expected, HasSubstr("--token-file"));
  settings.token_file = "token";
  const auto readable = check_access(settings, listener);
  ASSERT_FALSE(readable);
  EXPECT_THAT(readable.error().expected, HasSubstr("--certificate"));
  settings.allows_plain_http = true;
  EXPECT_TRUE(check_access(settings, listener));
  settings.allows_plain_http = false;
  settings.certificate = "cert.pem";
  EXPECT_FALSE(check_access(settings, listener));  // without its key
  settings.key = "key.pem";
  EXPECT_TRUE(check_access(settings, listener));
}

TEST(ServeSettings, TakeNamesWithoutAPort) {
  const Listener listener = listener_on("127.0.0.1:0");
  for (const char* const name : {"", "Drill", "drill:8330", "drill/", "*"}) {
    EXPECT_FALSE(check_access({.host_names = {name}}, listener)) << name;
  }
  EXPECT_TRUE(check_access({.host_names = {"drill-1.example.org"}}, listener));
}

TEST(Listener, TellsItsPort) {
  const Listener listener = listener_on("127.0.0.1:0");
  EXPECT_GT(listener.port(), 0);
  EXPECT_EQ(listener.text(), "127.0.0.1:" + std::to_string(listener.port()));
}

TEST(Listener, RefusesAPortInUse) {
  const Listener listener = listener_on("127.0.0.1:0");
  const auto second = Listener::open(listener.text());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Code::Usage);
  EXPECT_THAT(second.error().what, HasSubstr("Address already in use"));
  EXPECT_THAT(second.error().what, HasSubstr(listener.text()));
}

TEST(Listener, RefusesWhatIsNoAddress) {
  for (const char* const text : {"",
                                 "8330",
                                 "127.0.0.1",
                                 "127.0.0.1:",
                                 "127.0.0.1:70000",
                                 "a:1",
                                 "127.0.0.1:-1",
                                 "::1:8330",
                                 "[::1]",
                                 "127.0.0.1:80x",
                                 ":8330",
                                 "[127.0.0.1]:1",
                                 "evil.example:80"}) {
    const auto refused = Listener::open(text);
    ASSERT_FALSE(refused) << text;
    EXPECT_EQ(refused.error().code, Code::Usage) << text;
  }
}

}  // namespace
}  // namespace panelcal::serve
