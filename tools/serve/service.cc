// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/service.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "tools/serve/access/origin.h"
#include "tools/serve/cookie.h"
#include "tools/serve/reply.h"
#include <fmt/format.h>

namespace panelcal::serve {

struct Service::Route {
  std::string_view method;
  std::string_view path;  ///< of job files: the part before ID/NAME
  enum class Needs : unsigned char { Nothing, Login, Controls } needs;
  std::string_view body_type;  ///< empty: no body
  std::size_t max_body_bytes;
  Response (Service::*answer)(const Request& request, const Target& target);

  bool is_prefix() const { return path.ends_with('/') && path.size() > 1; }
};

const Service::Route* Service::find_route(const Target& target) {
  using enum Route::Needs;
  constexpr std::string_view kJson = "application/json";
  constexpr std::string_view kBytes = "application/octet-stream";
  static constexpr std::array<Route, 13> kRoutes = {{
      {"GET", "/", Nothing, "", 0, &Service::page},
      {"GET", "/app.js", Nothing, "", 0, &Service::script},
      {"GET", "/app.css", Nothing, "", 0, &Service::style},
      {"GET", "/api/state", Login, "", 0, &Service::state},
      {"GET", "/api/events", Login, "", 0, &Service::events},
      {"GET", "/api/frame.jpg", Login, "", 0, &Service::picture},
      {"GET", "/api/calibration/report.html", Login, "", 0, &Service::calibration_page},
      {"GET", "/api/jobs/", Login, "", 0, &Service::job_file},
      {"POST", "/api/login", Nothing, kJson, kMaxCommand_bytes, &Service::log_in},
      {"POST", "/api/logout", Login, kJson, kMaxCommand_bytes, &Service::log_out},
      {"POST", "/api/controls", Login, kJson, kMaxCommand_bytes, &Service::change_controls},
      {"POST", "/api/command", Controls, kJson, kMaxCommand_bytes, &Service::command},
      {"POST", "/api/programs", Controls, kBytes, kMaxProgram_bytes, &Service::add_program},
  }};
  const auto* const found = std::ranges::find_if(kRoutes, [&](const Route& route) {
    return route.is_prefix() ? target.path.starts_with(route.path) : target.path == route.path;
  });
  return found == kRoutes.end() ? nullptr : found;
}

Response Service::refuse(int status) {
  switch (status) {
    case 408:
      return error_reply(408, "body incomplete", "the bytes that Content-Length states, in time");
    case 431:
      return error_reply(431, "headers too large", "at most 8192 bytes together");
    default:
      return error_reply(status < 400 ? 400 : status, "no request of HTTP/1.1", "");
  }
}

/// What only a page of this very server sends. A browser states Sec-Fetch-Site of each request, and
/// no page can change it; Origin it states of each POST.
std::optional<Response> Service::check_site(const Request& head, const Target& target) const {
  const Arrival arrival{head.local_address, head.local_port, head.is_encrypted};
  const std::string_view host = head.header("host");
  if (!is_own_host(host, arrival, parts_.host_names)) {
    return error_reply(403,
                       fmt::format("Host {} is not a name of this server", quoted(host)),
                       "its address, or a name that --host-name lists");
  }
  if (head.n_headers("origin") > 0 &&
      !is_own_origin(head.header("origin"), host, arrival, parts_.host_names)) {
    return error_reply(
        403, fmt::format("request from another site: {}", quoted(head.header("origin"))), "");
  }
  const std::string_view site = head.header("sec-fetch-site");
  const bool is_page = target.path == "/";  // anyone may link to it
  if (!site.empty() && site != "same-origin" && site != "none" && !is_page) {
    return error_reply(403, "request from another site", "");
  }
  return std::nullopt;
}

std::optional<Response> Service::check_login(const Request& head) const {
  if (parts_.login == nullptr) return std::nullopt;
  const std::string_view session = cookie_of(head.header("cookie"), session_cookie(head));
  if (parts_.login->is_session(session, parts_.now())) return std::nullopt;
  return error_reply(401, "not logged in", "the token that panelcal serve printed");
}

std::optional<Response> Service::check_body(const Request& head, const Route& route) {
  if (head.n_headers("transfer-encoding") > 0) {
    return error_reply(411, "Transfer-Encoding not supported", "Content-Length");
  }
  const std::string_view length = head.header("content-length");
  if (route.max_body_bytes == 0) {
    if (length.empty() || length == "0") return std::nullopt;
    return error_reply(413, "GET with a body", "no body");
  }
  const std::string_view type = head.header("content-type");
  if (type.substr(0, type.find(';')) != route.body_type) {
    return error_reply(415,
                       fmt::format("Content-Type {}", quoted(type)),
                       fmt::format("Content-Type {}", route.body_type));
  }
  std::size_t n_bytes = 0;
  const char* const end = length.data() + length.size();
  const auto read = std::from_chars(length.data(), end, n_bytes);
  if (length.empty() || read.ptr != end || read.ec == std::errc::invalid_argument) {
    return error_reply(411, fmt::format("Content-Length {}", quoted(length)), "a number");
  }
  if (read.ec != std::errc() || n_bytes > route.max_body_bytes) {
    return error_reply(413,
                       fmt::format("body of {} bytes", quoted(length)),
                       fmt::format("at most {} bytes", route.max_body_bytes));
  }
  return std::nullopt;
}

std::variant<Response, Service::Admitted> Service::examine(const Request& head) {
  for (const char* const name : {"host",
                                 "origin",
                                 "cookie",
                                 "content-length",
                                 "content-type",
                                 "sec-fetch-site",
                                 "x-panelcal-controls"}) {
    if (head.n_headers(name) > 1) {
      return error_reply(400, fmt::format("header {} appears twice", name), "once");
    }
  }
  std::optional<Target> target = parse_target(head.target);
  if (!target) {
    return error_reply(400,
                       fmt::format("address not readable: {}", quoted(head.target)),
                       "see docs/howto/serve.md");
  }
  if (auto refusal = check_site(head, *target)) return *std::move(refusal);
  const Route* const route = find_route(*target);
  if (route == nullptr) {
    return error_reply(404, fmt::format("nothing at {}", quoted(target->path)), "");
  }
  // HEAD is a GET without its body; a stream has no end that it could wait for.
  const bool is_head = head.method == "HEAD" && route->answer != &Service::events;
  if (head.method != route->method && !(is_head && route->method == "GET")) {
    Response refusal =
        error_reply(405, fmt::format("method {}", quoted(head.method)), std::string(route->method));
    refusal.headers.push_back({"Allow", std::string(route->method)});
    return refusal;
  }
  if (route->needs != Route::Needs::Nothing) {
    if (auto refusal = check_login(head)) return *std::move(refusal);
  }
  if (auto refusal = check_body(head, *route)) return *std::move(refusal);
  if (route->needs == Route::Needs::Controls &&
      !parts_.controls.is_held_by(head.header("x-panelcal-controls"))) {
    const std::string holder = parts_.controls.holder();
    return error_reply(403,
                       holder.empty() ? std::string("controls not taken")
                                      : fmt::format("controls held by \"{}\"", holder),
                       "take the controls first");
  }
  return Admitted{route, *std::move(target)};
}

std::variant<Response, std::size_t> Service::admit(const Request& head) {
  auto examined = examine(head);
  if (auto* const refusal = std::get_if<Response>(&examined)) return std::move(*refusal);
  return std::get<Admitted>(examined).route->max_body_bytes;
}

Response Service::handle(const Request& request) {
  try {
    auto examined = examine(request);
    if (auto* const refusal = std::get_if<Response>(&examined)) return std::move(*refusal);
    const Admitted& admitted = std::get<Admitted>(examined);
    Response response = (this->*admitted.route->answer)(request, admitted.target);
    const bool has_session =
        parts_.login != nullptr && admitted.route->needs != Route::Needs::Nothing;
    response.is_trusted = has_session || response.events != nullptr;
    return response;
  } catch (const std::bad_alloc&) {
    return error_reply(503, "memory does not suffice", "fewer screens, or a smaller request");
  } catch (const std::exception& error) {
    return error_reply(500, fmt::format("internal error: {}", error.what()), "please report it");
  }
}

}  // namespace panelcal::serve
