// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/reply.h"

#include <utility>

#include "calib/base/json/facts.h"
#include <fmt/format.h>

namespace panelcal::serve {
namespace {

std::string_view policy_text(Policy policy) {
  switch (policy) {
    case Policy::Nothing:
      return "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    case Policy::Screen:
      return "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
             "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; "
             "frame-ancestors 'none'";
    case Policy::Report:
      // The page's own policy has the digests of its script and style; of two policies both hold.
      // The sandbox makes its origin one of its own, so that it could not ask this server anything.
      return "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src "
             "data:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'; sandbox "
             "allow-scripts allow-downloads allow-modals";
  }
  return "default-src 'none'";
}

Response error_document(int status,
                        std::string_view what,
                        std::string_view expected,
                        std::string_view code) {
  facts::Json document;
  document["error"]["what"] = what;
  document["error"]["expected"] = expected;
  document["error"]["code"] = code;
  return reply(status, "application/json", facts::text(document));
}

}  // namespace

Response reply(int status, std::string_view content_type, std::string body, Policy policy) {
  Response response;
  response.status = status;
  response.headers = {{"Content-Type", std::string(content_type)},
                      {"Content-Security-Policy", std::string(policy_text(policy))},
                      {"X-Frame-Options", policy == Policy::Report ? "SAMEORIGIN" : "DENY"},
                      {"X-Content-Type-Options", "nosniff"},
                      {"Cache-Control", "no-store"},
                      {"Referrer-Policy", "no-referrer"},
                      {"Cross-Origin-Opener-Policy", "same-origin"},
                      {"Cross-Origin-Resource-Policy", "same-origin"}};
  response.body = std::move(body);
  return response;
}

Response error_reply(int status, std::string_view what, std::string_view expected) {
  return error_document(status, what, expected, info(Code::Usage).slug);
}

Response error_reply(const Diagnostic& diagnostic) {
  const Place& place = diagnostic.place;
  std::string what = diagnostic.message();
  if (place.line > 0) what = fmt::format("{}:{}: {}", place.file, place.line, what);
  return error_document(400, what, diagnostic.expected, info(diagnostic.code).slug);
}

}  // namespace panelcal::serve
