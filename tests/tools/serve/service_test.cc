// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/serve/served_test.h"

namespace panelcal::serve {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pair;

using ServeRoutes = ServedTest;

TEST_F(ServeRoutes, GiveTheFrontEnd) {
  EXPECT_EQ(get("/").body, "<page>");
  EXPECT_EQ(header_of(get("/"), "Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(get("/app.js").body, "script");
  EXPECT_EQ(header_of(get("/app.js"), "Content-Type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(get("/app.css").body, "style");
  EXPECT_EQ(header_of(get("/app.css"), "Content-Type"), "text/css; charset=utf-8");
}

TEST_F(ServeRoutes, GiveTheStateOfTheMachine) {
  const Response state = get("/api/state");
  EXPECT_EQ(state.status, 200);
  EXPECT_EQ(json_of(state)["facts"], "screen");
}

TEST_F(ServeRoutes, GiveThePictureOnceThereIsOne) {
  EXPECT_EQ(get("/api/frame.jpg").status, 404);
  machine.show("\xff\xd8picture");
  const Response picture = get("/api/frame.jpg?n=1");
  EXPECT_EQ(picture.body, "\xff\xd8picture");
  EXPECT_EQ(header_of(picture, "Content-Type"), "image/jpeg");
  EXPECT_EQ(header_of(picture, "X-Panelcal-Frame"), "1");
}

TEST_F(ServeRoutes, GiveFilesOfJobsByTheirList) {
  for (const char* const name :
       {"report.html", "facts.json", "measurements.jsonl", "output", "picture-12.jpg"}) {
    const Response file = get(std::string("/api/jobs/2026-11-27-1/") + name);
    EXPECT_EQ(file.status, 200) << name;
    EXPECT_EQ(file.body, std::string("bytes of ") + name);
  }
  EXPECT_EQ(header_of(get("/api/jobs/2026-11-27-1/output"), "Content-Disposition"), "attachment");
  EXPECT_EQ(get("/api/jobs/2026-11-27-2/output").status, 404);
}

TEST_F(ServeRoutes, GiveThePageOfTheNight) {
  const Response page = get("/api/calibration/report.html");
  EXPECT_EQ(page.body, "bytes of report.html");
  EXPECT_THAT(header_of(page, "Content-Security-Policy"), HasSubstr("sandbox"));
}

TEST_F(ServeRoutes, SendFourFilesAtATime) {
  std::vector<Response> responses;
  for (int i = 0; i < 4; ++i) responses.push_back(get("/api/jobs/2026-11-27-1/output"));
  EXPECT_EQ(responses.back().status, 200);
  EXPECT_EQ(get("/api/jobs/2026-11-27-1/output").status, 503);
  responses.pop_back();
  EXPECT_EQ(get("/api/jobs/2026-11-27-1/output").status, 200);
}

TEST_F(ServeRoutes, RefuseEveryOtherFile) {
  for (const char* const target : {"/api/jobs/2026-11-27-1/..",
                                   "/api/jobs/../report.html",
                                   "/api/jobs/.hidden/report.html",
                                   "/api/jobs/2026-11-27-1/picture-.jpg",
                                   "/api/jobs/2026-11-27-1/picture-1a.jpg",
                                   "/api/jobs/2026-11-27-1/picture-1.jpg.png",
                                   "/api/jobs/2026-11-27-1/machine.toml",
                                   "/api/jobs/2026-11-27-1/sub/output",
                                   "/api/jobs//output",
                                   "/api/jobs/output",
                                   "/api/jobs/",
                                   "/api/jobs/2026-11-27-1/",
                                   "/app.js/",
                                   "//",
                                   "/index.html",
                                   "/api",
                                   "/etc/passwd",
                                   "/../etc/passwd",
                                   "/app.css/../../etc/passwd"}) {
    EXPECT_EQ(get(target).status, 404) << target;
  }
  for (const char* const target : {"/api/jobs/2026-11-27-1/%2e%2e",
                                   "/%2e%2e/etc/passwd",
                                   "/..%2fetc",
                                   "/api\\jobs",
                                   "",
                                   "api/state",
                                   "http://127.0.0.1:8330/api/state",
                                   "*",
                                   "/api/state?n=%zz",
                                   "/api/state?n=%00",
                                   "/api/state?n=%4",
                                   "/api/state?n=1&n=2",
                                   "/api/state\r\nX: y"}) {
    EXPECT_EQ(get(target).status, 400) << target;
  }
}

TEST_F(ServeRoutes, RefuseOtherMethods) {
  for (const char* const method : {"PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "POST", "get"}) {
    const Response refused = service->handle(request(method, "/api/state"));
    EXPECT_EQ(refused.status, 405) << method;
    EXPECT_EQ(header_of(refused, "Allow"), "GET");
  }
  EXPECT_EQ(get("/api/command").status, 405);
  EXPECT_EQ(service->handle(request("HEAD", "/api/state")).status, 200);
  EXPECT_EQ(service->handle(request("HEAD", "/api/events")).status, 405);
}

TEST_F(ServeRoutes, HaveTheHeadersOfSafety) {
  machine.show("picture");
  for (const char* const target : {"/",
                                   "/app.js",
                                   "/app.css",
                                   "/api/state",
                                   "/api/frame.jpg",
                                   "/api/events",
                                   "/nothing",
                                   "/api/jobs/2026-11-27-1/facts.json",
                                   "/api/jobs/2026-11-27-1/output",
                                   "/%"}) {
    const Response response = get(target);
    EXPECT_EQ(header_of(response, "X-Content-Type-Options"), "nosniff") << target;
    EXPECT_EQ(header_of(response, "Cache-Control"), "no-store") << target;
    EXPECT_EQ(header_of(response, "Referrer-Policy"), "no-referrer") << target;
    EXPECT_EQ(header_of(response, "X-Frame-Options"), "DENY") << target;
    EXPECT_EQ(header_of(response, "Cross-Origin-Resource-Policy"), "same-origin") << target;
    const std::string policy = header_of(response, "Content-Security-Policy");
    EXPECT_THAT(policy, HasSubstr("default-src 'none'")) << target;
    EXPECT_THAT(policy, HasSubstr("frame-ancestors 'none'")) << target;
    EXPECT_THAT(policy, Not(HasSubstr("unsafe"))) << target;
    EXPECT_FALSE(header_of(response, "Content-Type").empty()) << target;
    EXPECT_TRUE(header_of(response, "Access-Control-Allow-Origin").empty()) << target;
  }
  EXPECT_THAT(header_of(get("/"), "Content-Security-Policy"),
              HasSubstr("script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
                        "connect-src 'self'; frame-src 'self'"));
}

TEST_F(ServeRoutes, KeepReportsApartFromTheServer) {
  const std::string policy =
      header_of(get("/api/jobs/2026-11-27-1/report.html"), "Content-Security-Policy");
  // Without allow-same-origin a page in this sandbox is of no origin of ours.
  EXPECT_THAT(policy, HasSubstr("sandbox allow-scripts"));
  EXPECT_THAT(policy, Not(HasSubstr("allow-same-origin")));
  EXPECT_THAT(policy, Not(HasSubstr("connect-src")));
  EXPECT_THAT(policy, HasSubstr("frame-ancestors 'self'"));
}

using ServeSites = ServedTest;

TEST_F(ServeSites, AreRefusedUnderAStrangersName) {
  for (const char* const host : {"evil.example:8330",
                                 "127.0.0.1",
                                 "127.0.0.1:8331",
                                 "127.0.0.2:8330",
                                 "localhost:80",
                                 "",
                                 "[::1]:8330",
                                 "127.0.0.1:8330.evil.example",
                                 "127.0.0.1:8330@evil.example",
                                 "evil.example#127.0.0.1:8330",
                                 "localhost.evil.example:8330",
                                 "127.1:8330",
                                 "0x7f000001:8330",
                                 "127.0.0.1:",
                                 "127.0.0.1:+8330",
                                 "drill.example.evil",
                                 ":8330"}) {
    Request made = request("GET", "/api/state");
    made.headers[0].value = host;
    EXPECT_EQ(service->handle(made).status, 403) << host;
  }
  for (const char* const host : {"127.0.0.1:8330",
                                 "localhost:8330",
                                 "LOCALHOST:8330",
                                 "drill.example",
                                 "Drill.Example:443"}) {
    Request made = request("GET", "/api/state");
    made.headers[0].value = host;
    EXPECT_EQ(service->handle(made).status, 200) << host;
  }
  Request without = request("GET", "/api/state");
  without.headers.clear();
  EXPECT_EQ(service->handle(without).status, 403);
}

TEST_F(ServeSites, MayNotPostFromElsewhere) {
  take_controls();
  for (const char* const origin : {"http://evil.example",
                                   "null",
                                   "https://127.0.0.1:8330",
                                   "http://127.0.0.1:8331",
                                   "http://localhost:8330",
                                   "http://127.0.0.1:8330.evil.example",
                                   "",
                                   "file://",
                                   "http://127.0.0.1:8330@evil.example"}) {
    Request made = post("/api/command", R"({"do":"start"})");
    made.headers[1].value = origin;
    EXPECT_EQ(service->handle(made).status, 403) << origin;
  }
  for (const char* const site : {"cross-site", "same-site"}) {
    Request made = post("/api/command", R"({"do":"start"})");
    made.headers[2].value = site;
    EXPECT_EQ(service->handle(made).status, 403) << site;
  }
  EXPECT_EQ(machine.n_changes(), 0U);
  EXPECT_EQ(service->handle(post("/api/command", R"({"do":"start"})")).status, 200);
}

TEST_F(ServeSites, MayNotReadFromElsewhereButMayLinkToThePage) {
  Request made = request("GET", "/api/frame.jpg");
  made.headers.push_back({"Sec-Fetch-Site", "cross-site"});
  EXPECT_EQ(service->handle(made).status, 403);
  made.target = "/";
  EXPECT_EQ(service->handle(made).status, 200);
}

TEST_F(ServeSites, AskForTheHeadersThatAFormCannotSend) {
  take_controls();
  // A form of another site sends these types without asking first.
  for (const char* const type :
       {"text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", ""}) {
    EXPECT_EQ(service->handle(post("/api/command", R"({"do":"start"})", type)).status, 415) << type;
    EXPECT_EQ(service->handle(post("/api/controls", R"({"take":true})", type)).status, 415) << type;
    EXPECT_EQ(service->handle(post("/api/programs?name=a.exc", "M48", type)).status, 415) << type;
  }
  EXPECT_EQ(machine.n_changes(), 0U);
}

TEST_F(ServeSites, MayStateAHeaderOnce) {
  Request made = request("GET", "/api/state");
  made.headers.push_back({"host", "127.0.0.1:8330"});
  EXPECT_EQ(service->handle(made).status, 400);
}

using ServeControls = ServedTest;

TEST_F(ServeControls, BelongToOneScreen) {
  take_controls("Anna");
  const std::string key_of_anna = std::exchange(key, "");
  const Response refused = service->handle(post("/api/controls", R"({"name":"Ben","take":true})"));
  EXPECT_EQ(refused.status, 409);
  EXPECT_THAT(what_of(refused), HasSubstr("Anna"));
  // Both press start.
  key = "0000000000000000000000000";
  EXPECT_EQ(service->handle(post("/api/command", R"({"do":"start"})")).status, 403);
  key = key_of_anna;
  EXPECT_EQ(service->handle(post("/api/command", R"({"do":"start"})")).status, 200);
  EXPECT_THAT(machine.commands, ElementsAre(Pair(R"({"do":"start"})", "Anna")));
}

TEST_F(ServeControls, AreGivenBack) {
  take_controls("Anna");
  EXPECT_EQ(service->handle(post("/api/controls", R"({"take":false})")).status, 200);
  EXPECT_EQ(service->handle(post("/api/command", R"({"do":"start"})")).status, 403);
  key.clear();
  take_controls("Ben");
  EXPECT_EQ(controls.holder(), "Ben");
}

TEST_F(ServeControls, AreTakenOverFromTheNamedHolderOnly) {
  take_controls("Anna");
  const std::string key_of_anna = std::exchange(key, "");
  EXPECT_EQ(
      service->handle(post("/api/controls", R"({"name":"Ben","take":true,"from":"Clara"})")).status,
      409);
  const Response taken =
      service->handle(post("/api/controls", R"({"name":"Ben","take":true,"from":"Anna"})"));
  ASSERT_EQ(taken.status, 200);
  key = key_of_anna;
  EXPECT_EQ(service->handle(post("/api/command", R"({"do":"stop"})")).status, 403);
  EXPECT_EQ(service->handle(post("/api/controls", R"({"take":false})")).status, 403);
  key = json_of(taken)["key"];
  EXPECT_EQ(service->handle(post("/api/command", R"({"do":"stop"})")).status, 200);
}

TEST_F(ServeControls, AskForTheNameOfAPerson) {
  for (const std::string& body : {std::string(R"({"name":"","take":true})"),
                                  std::string(R"({"take":true})"),
                                  std::string(R"({"name":7,"take":true})"),
                                  std::string(R"({"name":"a\u0007b","take":true})"),
                                  std::string(R"({"name":"Anna"})"),
                                  std::string(R"({"name":"Anna","take":"yes"})"),
                                  std::string(R"([])"),
                                  std::string("{"),
                                  R"({"take":true,"name":")" + std::string(61, 'a') + R"("})",
                                  std::string("{\"take\":true,\"name\":\"a\xe2\x80\xae"
                                              "b\"}"),
                                  std::string("{\"take\":true,\"name\":\"a\xe2\x80\xa8"
                                              "b\"}")}) {
    EXPECT_EQ(service->handle(post("/api/controls", body)).status, 400) << body;
  }
  EXPECT_EQ(controls.holder(), "");
}

TEST_F(ServeControls, TakeNamesInAnyLanguage) {
  // 60 characters are too many bytes only where each of them has two or more.
  take_controls("Zo\xc3\xab \xe5\xb1\xb1\xe7\x94\xb0");
  EXPECT_EQ(controls.holder(), "Zo\xc3\xab \xe5\xb1\xb1\xe7\x94\xb0");
  std::string long_name;
  for (int i = 0; i < 51; ++i) long_name += "\xc3\xab";
  const auto body = nlohmann::json{{"name", long_name}, {"take", true}}.dump();
  EXPECT_EQ(service->handle(post("/api/controls", body)).status, 400);
}

TEST_F(ServeControls, KeepNamesAsText) {
  take_controls("<script>alert(1)</script>");
  key.clear();
  const Response refused = service->handle(post("/api/controls", R"({"name":"Ben","take":true})"));
  EXPECT_EQ(header_of(refused, "Content-Type"), "application/json");
  EXPECT_THAT(what_of(refused), HasSubstr("<script>alert(1)</script>"));
}

using ServeCommands = ServedTest;

TEST_F(ServeCommands, AreRefusedAsTheMachineRefusesThem) {
  take_controls();
  machine.refusal = failure({Code::Usage, {"job", 0, 0}, "no job is open", "open a program"});
  const Response refused = service->handle(post("/api/command", R"({"do":"start"})"));
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(json_of(refused)["error"]["what"], "request not valid: no job is open");
  EXPECT_EQ(json_of(refused)["error"]["expected"], "open a program");
  EXPECT_EQ(json_of(refused)["error"]["code"], "usage");
}

TEST_F(ServeCommands, AreOneObjectOfJson) {
  take_controls();
  const std::string deep = R"({"do":)" + std::string(100'000, '[');
  for (const std::string& body : {std::string(),
                                  std::string("null"),
                                  std::string("[]"),
                                  std::string("{}"),
                                  std::string(R"({"do":3})"),
                                  std::string(R"({"do":"start","do":"stop"})"),
                                  std::string(R"({"do":"start"} x)"),
                                  std::string("\xff\xfe"),
                                  deep.substr(0, 60'000)}) {
    EXPECT_EQ(service->handle(post("/api/command", body)).status, 400) << body.substr(0, 60);
  }
  EXPECT_EQ(machine.n_changes(), 0U);
}

TEST_F(ServeCommands, AreLimitedInSizeBeforeTheyAreRead) {
  take_controls();
  Request made = post("/api/command", "");
  made.headers.back().value = "65536";
  EXPECT_EQ(std::get<std::size_t>(service->admit(made)), 65536U);
  for (const char* const length : {"65537", "18446744073709551616", "99999999999999999999999"}) {
    made.headers.back().value = length;
    EXPECT_EQ(std::get<Response>(service->admit(made)).status, 413) << length;
  }
  for (const char* const length : {"", "-1", "1 ", "0x10", "1,1", "ten"}) {
    made.headers.back().value = length;
    EXPECT_EQ(std::get<Response>(service->admit(made)).status, 411) << length;
  }
  made.headers.back() = {"Transfer-Encoding", "chunked"};
  EXPECT_EQ(std::get<Response>(service->admit(made)).status, 411);
}

using ServeUploads = ServedTest;

TEST_F(ServeUploads, GoToTheMachineByTheirName) {
  take_controls();
  const Response stored = service->handle(
      post("/api/programs?name=panel%201.exc", "M48\n", "application/octet-stream"));
  EXPECT_EQ(stored.status, 200) << stored.body;
  EXPECT_THAT(machine.programs, ElementsAre(Pair("panel 1.exc", "M48\n")));
}

TEST_F(ServeUploads, LeaveTheFolderByNoName) {
  take_controls();
  for (const char* const name : {"",
                                 "..",
                                 ".",
                                 "../a.exc",
                                 "..%2Fa.exc",
                                 "%2Fetc%2Fpasswd",
                                 "a%5Cb",
                                 "a%0Ab",
                                 ".hidden",
                                 "a%1b%5b31m",
                                 "%ff%fe",
                                 "a%7f"}) {
    const Response refused = service->handle(
        post(std::string("/api/programs?name=") + name, "M48", "application/octet-stream"));
    EXPECT_EQ(refused.status, 400) << name;
  }
  const Response missing =
      service->handle(post("/api/programs", "M48", "application/octet-stream"));
  EXPECT_EQ(missing.status, 400);
  const std::string long_name = "/api/programs?name=" + std::string(129, 'a');
  EXPECT_EQ(service->handle(post(long_name, "M48", "application/octet-stream")).status, 400);
  EXPECT_EQ(machine.n_changes(), 0U);
}

TEST_F(ServeUploads, AreLimitedInSizeAndNeedTheControls) {
  Request made = post("/api/programs?name=a.exc", "", "application/octet-stream");
  made.headers.back().value = "1000";
  EXPECT_EQ(std::get<Response>(service->admit(made)).status, 403);
  take_controls();
  made = post("/api/programs?name=a.exc", "", "application/octet-stream");
  made.headers.back().value = "67108865";
  EXPECT_EQ(std::get<Response>(service->admit(made)).status, 413);
  made.headers.back().value = "67108864";
  EXPECT_EQ(std::get<std::size_t>(service->admit(made)), 67108864U);
}

}  // namespace
}  // namespace panelcal::serve
