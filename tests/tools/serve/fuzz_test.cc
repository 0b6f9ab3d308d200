// SPDX-License-Identifier: Apache-2.0
// Random and malformed requests, straight to the handlers: no crash, and the machine is asked
// nothing without login and controls.
#include <array>
#include <random>
#include <set>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/tools/serve/served_test.h"

namespace panelcal::serve {
namespace {

constexpr std::uint32_t kSeed = 20261127;
constexpr int kRequests = 10'000;

/// Draws requests: well-formed ones, such with one part changed, and noise.
class RequestSource {
 public:
  explicit RequestSource(std::string key) : key_(std::move(key)) {}

  Request draw() {
    Request request;
    is_well_formed_ = chance(0.5);
    request.method = pick({"GET", "POST", "POST", "HEAD", "PUT", "OPTIONS", "", "get", noise(6)});
    request.target = target();
    request.peer = pick({"192.0.2.1", "2001:db8::1", "", noise(10)});
    request.local_address = "192.0.2.7";
    request.local_port = 8330;
    request.is_encrypted = chance(0.1);
    add(request, "Host", {"192.0.2.7:8330", "192.0.2.7:8330", "evil.example", noise(20)}, 0.95);
    add(request,
        "Origin",
        {"http://192.0.2.7:8330", "null", "http://evil.example", noise(20)},
        0.5);
    add(request, "Sec-Fetch-Site", {"same-origin", "none", "cross-site", noise(8)}, 0.5);
    add(request,
        "Content-Type",
        {"application/json",
         "application/json; charset=utf-8",
         "application/octet-stream",
         "text/plain",
         noise(12)},
        0.8);
    add(request, "Cookie", {"panelcal_8330=guess", "panelcal_8330=", "a=b;;", noise(40)}, 0.5);
    add(request, "X-Panelcal-Controls", {"guess", "", noise(25), changed(key_)}, 0.5);
    add(request, "Transfer-Encoding", {"chunked", "identity"}, 0.05);
    request.body = body();
    add(request,
        "Content-Length",
        {std::to_string(request.body.size()),
         std::to_string(request.body.size()),
         "-1",
         "",
         "99999999999999999999",
         noise(4)},
        0.9);
    return request;
  }

  bool chance(double p) { return std::bernoulli_distribution(p)(random_); }

 private:
  std::size_t below(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_);
  }
  std::string pick(const std::vector<std::string>& of) { return of[below(of.size())]; }
  std::string noise(std::size_t max) {
    std::string bytes(below(max + 1), ' ');
    for (char& c : bytes) c = static_cast<char>(below(256));
    return bytes;
  }
  std::string changed(std::string text) {
    // Never the same again: a changed key must not be the key.
    if (!text.empty()) text[below(text.size())] += static_cast<char>(1 + below(255));
    return text;
  }
  /// The first of the values is the one that a browser would send.
  void add(Request& request, const char* name, const std::vector<std::string>& of, double p) {
    if (is_well_formed_) {
      if (p > 0.1 && chance(0.98)) request.headers.push_back({name, of.front()});
      return;
    }
    for (; chance(p); p = 0.03) request.headers.push_back({name, pick(of)});
  }

  std::string target() {
    std::string text = pick({"/",
                             "/app.js",
                             "/api/state",
                             "/api/events",
                             "/api/frame.jpg?n=1",
                             "/api/login",
                             "/api/logout",
                             "/api/controls",
                             "/api/command",
                             "/api/command",
                             "/api/programs?name=a.exc",
                             "/api/jobs/2026-11-27-1/output",
                             "/api/jobs/../../etc/passwd",
                             "/api/events?stream=" + key_,
                             noise(60)});
    if (chance(0.2)) text = changed(text);
    if (chance(0.1)) text += pick({"?", "&", "%", "%2e%2e/", "/..", "=&=", "?a=%00", noise(10)});
    return text;
  }
  std::string body() {
    std::string text = pick({R"({"do":"start"})",
                             R"({"do":"jog","by_mm":[1e308,-1e308]})",
                             R"({"token":"guess"})",
                             R"({"name":"Eve","take":true})",
                             R"({"name":"Eve","take":true,"from":""})",
                             R"({"take":false})",
                             "",
                             "{",
                             R"({"do":{}})",
                             std::string(3000, '['),
                             noise(200)});
    if (chance(0.2)) text = changed(text);
    return text;
  }

  std::mt19937 random_{kSeed};
  std::string key_;
  bool is_well_formed_ = false;  ///< this request, but for method, target and body
};

using ServeFuzz = GuardedTest;

TEST_F(ServeFuzz, ChangesNothingWithoutTheToken) {
  // Another person is logged in and holds the controls.
  cookie = header_of(log_in(kToken), "Set-Cookie");
  cookie = cookie.substr(0, cookie.find(';'));
  take_controls("Anna");
  const std::uint64_t number = controls.number();
  RequestSource source(key);
  std::set<int> statuses;
  for (int i = 0; i < kRequests; ++i) {
    const Request request = source.draw();
    const auto admitted = service->admit(request);
    const Response response = service->handle(request);
    statuses.insert(response.status);
    ASSERT_TRUE(response.status == 200 || (response.status >= 400 && response.status < 500))
        << "request " << i << ": " << response.status << " " << response.body;
    ASSERT_EQ(response.events, nullptr) << "request " << i;
    if (response.status != 200) {
      ASSERT_FALSE(what_of(response).starts_with("no JSON")) << i << ": " << response.body;
    }
    now += std::chrono::milliseconds(10);
  }
  EXPECT_EQ(machine.n_changes(), 0U);
  EXPECT_EQ(controls.holder(), "Anna");
  EXPECT_EQ(controls.number(), number);
  // Each refusal was reached, so that the requests came far enough.
  for (const int status : {200, 400, 401, 403, 404, 405, 411, 413, 415, 429}) {
    EXPECT_TRUE(statuses.contains(status)) << status;
  }
}

using OpenServeFuzz = ServedTest;

TEST_F(OpenServeFuzz, ChangesNothingWithoutTheControls) {
  address = "192.0.2.7";
  take_controls("Anna");
  RequestSource source(key);
  for (int i = 0; i < kRequests; ++i) {
    const Request request = source.draw();
    const Response response = service->handle(request);
    ASSERT_NE(response.status, 500) << "request " << i << ": " << response.body;
    ASSERT_EQ(machine.n_changes(), 0U) << "request " << i << ": " << request.target;
    ASSERT_EQ(controls.holder(), "Anna") << "request " << i << ": " << request.body;
  }
}

}  // namespace
}  // namespace panelcal::serve
