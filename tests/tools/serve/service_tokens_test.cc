// SPDX-License-Identifier: Apache-2.0
// Sessions that a token opens.
#include <chrono>
#include <string>

#include "tools/serve/service.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/serve/served_test.h"

namespace panelcal::serve {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

using ServeTokens = GuardedTest;

TEST_F(ServeTokens, AreNeededForAllButThePageItself) {
  for (const char* const target : {"/", "/app.js", "/app.css"}) {
    EXPECT_EQ(get(target).status, 200) << target;
  }
  for (const char* const target : {"/api/state",
                                   "/api/events",
                                   "/api/frame.jpg",
                                   "/api/jobs/2026-11-27-1/report.html",
                                   "/api/calibration/report.html"}) {
    EXPECT_EQ(get(target).status, 401) << target;
    EXPECT_EQ(get(target).events, nullptr) << target;
  }
  EXPECT_EQ(service->handle(post("/api/controls", R"({"name":"Eve","take":true})")).status, 401);
  EXPECT_EQ(service->handle(post("/api/command", R"({"do":"start"})")).status, 401);
  EXPECT_EQ(controls.holder(), "");
  EXPECT_EQ(machine.n_changes(), 0U);
}

TEST_F(ServeTokens, OpenASessionByACookieThatPagesCannotRead) {
  const Response answer = log_in(kToken);
  ASSERT_EQ(answer.status, 200);
  const std::string set = header_of(answer, "Set-Cookie");
  EXPECT_THAT(set, HasSubstr("; HttpOnly"));
  EXPECT_THAT(set, HasSubstr("; SameSite=Strict"));
  EXPECT_THAT(set, HasSubstr("; Path=/"));
  EXPECT_THAT(set, Not(HasSubstr("Secure")));
  EXPECT_THAT(set, Not(HasSubstr(kToken)));
  cookie = "other=1; " + set.substr(0, set.find(';')) + "; x=y";
  EXPECT_EQ(get("/api/state").status, 200);
  take_controls();
  EXPECT_EQ(service->handle(post("/api/command", R"({"do":"start"})")).status, 200);
  now += Login::kSessionLength;
  EXPECT_EQ(get("/api/state").status, 401);
}

TEST_F(ServeTokens, EndTheirSessionAndGiveTheControlsBack) {
  EXPECT_EQ(service->handle(post("/api/logout", "{}")).status, 401);
  const std::string set = header_of(log_in(kToken), "Set-Cookie");
  cookie = set.substr(0, set.find(';'));
  EXPECT_EQ(header_of(get("/api/state"), "X-Panelcal-Session"), "open");
  take_controls();
  const Response answer = service->handle(post("/api/logout", "{}"));
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(header_of(answer, "Set-Cookie"), HasSubstr("=; "));
  EXPECT_THAT(header_of(answer, "Set-Cookie"), HasSubstr("; Max-Age=0"));
  EXPECT_EQ(controls.holder(), "");
  EXPECT_EQ(get("/api/state").status, 401);
}

TEST_F(ServeTokens, ComeByTlsInASecureCookie) {
  Request made = post("/api/login", std::string(R"({"token":")") + kToken + R"("})");
  made.is_encrypted = true;
  made.headers[1].value = "https://192.0.2.7:8330";
  EXPECT_THAT(header_of(service->handle(made), "Set-Cookie"), HasSubstr("; Secure"));
}

TEST_F(ServeTokens, ComeBehindAProxyInASecureCookieToo) {
  Request made = post("/api/login", std::string(R"({"token":")") + kToken + R"("})");
  made.headers[0].value = "drill.example";
  made.headers[1].value = "https://drill.example";
  EXPECT_THAT(header_of(service->handle(made), "Set-Cookie"), HasSubstr("; Secure"));
}

TEST_F(ServeTokens, AreNotGuessed) {
  for (int i = 0; i < 5; ++i) {
    const Response refused = log_in("guess");
    EXPECT_EQ(refused.status, 401);
    EXPECT_TRUE(header_of(refused, "Set-Cookie").empty());
  }
  const Response refused = log_in("guess");
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(header_of(refused, "Retry-After"), "60");
  EXPECT_GE(refused.delay, std::chrono::seconds(1));
  // Its owner is not locked out.
  EXPECT_EQ(log_in(kToken).status, 200);
}

TEST_F(ServeTokens, AreNoWordsOfACookie) {
  for (const char* const value : {"panelcal_8330=",
                                  "panelcal_8330=guess",
                                  "panelcal_8331=x",
                                  ";;;=",
                                  "panelcal_8330",
                                  "xpanelcal_8330=guess"}) {
    cookie = value;
    EXPECT_EQ(get("/api/state").status, 401) << value;
  }
}

}  // namespace
}  // namespace panelcal::serve
