// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/event_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/serve/served_test.h"

namespace panelcal::serve {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr milliseconds kLong{2000};

class ServeEvents : public ServedTest {
 protected:
  std::shared_ptr<EventSource> open(const std::string& of_key = "") {
    const std::string name = of_key.substr(of_key.find('.') + 1);
    return get("/api/events" + (name.empty() ? "" : "?stream=" + name)).events;
  }
};

TEST_F(ServeEvents, BeginWithAllThatAScreenShows) {
  machine.show("picture");
  const auto stream = open();
  std::string text;
  // The picture may be noticed a moment later.
  while (text.find("event: frame") == text.npos) text += *stream->next(kLong);
  EXPECT_THAT(text, HasSubstr("event: state\ndata: {\"facts\":\"screen\",\"version\":1}\n\n"));
  EXPECT_THAT(text, HasSubstr("event: frame\ndata: {\"number\":1}\n\n"));
  EXPECT_THAT(text,
              HasSubstr("event: controls\ndata: "
                        "{\"controls\":{\"held_by\":null,\"mine\":false}}\n\n"));
}

TEST_F(ServeEvents, TellWhatChangesAndNothingElse) {
  const auto stream = open();
  stream->next(kLong);
  EXPECT_EQ(stream->next(milliseconds(20)), "");
  machine.change("{\n\"two\": \"lines\"\n}");
  EXPECT_EQ(stream->next(kLong), "event: state\ndata: {\ndata: \"two\": \"lines\"\ndata: }\n\n");
}

TEST_F(ServeEvents, TellEachScreenWhetherTheControlsAreItsOwn) {
  take_controls("Anna");
  const auto own = open(key);
  const auto other = open();
  EXPECT_THAT(*own->next(kLong), HasSubstr(R"({"held_by":"Anna","mine":true})"));
  EXPECT_THAT(*other->next(kLong), HasSubstr(R"({"held_by":"Anna","mine":false})"));
  ASSERT_EQ(service->handle(post("/api/controls", R"({"take":false})")).status, 200);
  EXPECT_THAT(*own->next(kLong), HasSubstr(R"({"held_by":null,"mine":false})"));
}

TEST_F(ServeEvents, TellADuplicatedScreenThatTheControlsAreElsewhere) {
  take_controls("Anna");
  const auto first = open(key);
  EXPECT_THAT(*first->next(kLong), HasSubstr("\"mine\":true"));
  auto second = open(key);
  EXPECT_THAT(*second->next(kLong), HasSubstr("\"mine\":true"));
  EXPECT_THAT(*first->next(kLong), HasSubstr("\"mine\":false"));
}

class GuardedServeEvents : public GuardedTest {};

TEST_F(GuardedServeEvents, EndWithTheSession) {
  cookie = header_of(log_in(kToken), "Set-Cookie");
  cookie = cookie.substr(0, cookie.find(';'));
  const auto stream = get("/api/events").events;
  ASSERT_NE(stream, nullptr);
  EXPECT_TRUE(stream->next(kLong));
  now += Login::kSessionLength;
  EXPECT_FALSE(stream->next(milliseconds(20)));
}

TEST_F(ServeEvents, SendTheNewestDocumentOnlyTenTimesASecond) {
  const auto stream = open();
  stream->next(kLong);
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) machine.change("{\"i\":" + std::to_string(i) + "}");
  std::string last;
  int n_states = 0;
  while (last.find("{\"i\":19}") == last.npos) {
    last = *stream->next(kLong);
    if (last.find("event: state") != last.npos) ++n_states;
  }
  EXPECT_LE(n_states, 2);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kLong);
}

TEST_F(ServeEvents, HaveTheMachineWatchedAsLongAsAScreenLooks) {
  EXPECT_FALSE(machine.is_watched);
  auto one = open();
  auto other = open();
  one.reset();
  EXPECT_TRUE(machine.is_watched);
  other.reset();
  EXPECT_FALSE(machine.is_watched);
}

TEST_F(ServeEvents, EndWithTheServer) {
  const auto stream = open();
  stream->next(kLong);
  announcer.end();
  EXPECT_FALSE(stream->next(kLong));
}

TEST_F(ServeEvents, AreLimitedInNumber) {
  std::vector<std::shared_ptr<EventSource>> streams;
  for (std::size_t i = 0; i < Announcer::kMaxScreens; ++i) streams.push_back(open());
  EXPECT_NE(streams.back(), nullptr);
  EXPECT_EQ(get("/api/events").status, 503);
  streams.pop_back();
  EXPECT_EQ(get("/api/events").status, 200);
}

}  // namespace
}  // namespace panelcal::serve
