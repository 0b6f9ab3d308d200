// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tools/serve/access/secret.h"
#include "tools/serve/service.h"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/serve/fake_machine.h"

namespace panelcal::serve {

/// The value of a response's header; empty if it is not there.
inline std::string header_of(const Response& response, std::string_view name) {
  for (const Header& header : response.headers) {
    if (header.name == name) return header.value;
  }
  return {};
}

inline nlohmann::json json_of(const Response& response) {
  return nlohmann::json::parse(response.body);
}

/// "what" of an error.
inline std::string what_of(const Response& response) {
  const nlohmann::json document = nlohmann::json::parse(response.body, nullptr, false);
  return document.is_discarded() ? "no JSON: " + response.body
                                 : document.value("/error/what"_json_pointer, std::string());
}

/// A service with a fake machine, as it listens on 127.0.0.1:8330, or with a token on 192.0.2.7.
class ServedTest : public ::testing::Test {
 protected:
  static constexpr const char* kToken = "correct-horse-battery";

  explicit ServedTest(bool needs_token = false) {
    if (needs_token) {
      login = std::make_unique<Login>(Token("salt", salted_hash("salt", kToken)));
      address = "192.0.2.7";
    }
    service = std::make_unique<Service>(Service::Parts{.machine = machine,
                                                       .controls = controls,
                                                       .announcer = announcer,
                                                       .login = login.get(),
                                                       .host_names = {"drill.example"},
                                                       .front_end = {"<page>", "script", "style"},
                                                       .now = [this] { return now; }});
  }

  /// As a browser sends it from a page of this server.
  Request request(const std::string& method, const std::string& target) const {
    Request made;
    made.method = method;
    made.target = target;
    made.headers = {{"Host", address + ":8330"}};
    if (method == "POST") {
      made.headers.push_back({"Origin", "http://" + address + ":8330"});
      made.headers.push_back({"Sec-Fetch-Site", "same-origin"});
    }
    if (!cookie.empty()) made.headers.push_back({"Cookie", cookie});
    if (!key.empty()) made.headers.push_back({"X-Panelcal-Controls", key});
    made.peer = "192.0.2.99";
    made.local_address = address;
    made.local_port = 8330;
    return made;
  }
  Request post(const std::string& target,
               const std::string& body,
               const std::string& type = "application/json") const {
    Request made = request("POST", target);
    made.headers.push_back({"Content-Type", type});
    made.headers.push_back({"Content-Length", std::to_string(body.size())});
    made.body = body;
    return made;
  }
  Response get(const std::string& target) { return service->handle(request("GET", target)); }

  /// Takes the controls for the requests that follow.
  void take_controls(const std::string& name = "Anna") {
    const Response taken = service->handle(
        post("/api/controls", nlohmann::json{{"name", name}, {"take", true}}.dump()));
    ASSERT_EQ(taken.status, 200) << taken.body;
    key = json_of(taken)["key"];
  }

  FakeMachine machine;
  Controls controls;
  Announcer announcer{machine, controls};
  std::unique_ptr<Login> login;
  std::unique_ptr<Service> service;
  Now now = std::chrono::steady_clock::now();
  std::string address = "127.0.0.1";
  std::string cookie;
  std::string key;
};

/// Where a token is needed.
class GuardedTest : public ServedTest {
 protected:
  GuardedTest() : ServedTest(true) {}

  Response log_in(const std::string& token) {
    return service->handle(post("/api/login", nlohmann::json{{"token", token}}.dump()));
  }
};

}  // namespace panelcal::serve
