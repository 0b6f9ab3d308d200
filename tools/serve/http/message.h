// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

// Requests and responses as plain values: handlers, tests and the fuzzer know no socket and no
// library of HTTP.
namespace panelcal::serve {

struct Header {
  std::string name;  ///< case does not count
  std::string value;
};

struct Request {
  std::string method;
  std::string target;  ///< as sent: "/api/frame.jpg?n=3", nothing decoded
  std::vector<Header> headers;
  std::string body;
  std::string peer;           ///< address of the other side, "192.168.1.7"
  std::string local_address;  ///< at which this request arrived
  int local_port = 0;
  bool is_encrypted = false;

  /// The value of the first header of this name; empty if there is none.
  std::string_view header(std::string_view name) const;
  std::size_t n_headers(std::string_view name) const;
};

/// A response without an end: text for one screen whenever there is news.
class EventSource {
 public:
  virtual ~EventSource() = default;
  /// Waits for news. Empty: there was none in this time; nothing: the stream ends here.
  virtual std::optional<std::string> next(std::chrono::milliseconds at_most) = 0;
};

struct Response {
  int status = 200;
  std::vector<Header> headers;
  std::string body;
  std::shared_ptr<EventSource> events;  ///< in place of the body, if not null
  std::chrono::milliseconds delay{0};   ///< before it is sent
  /// The request came from a person who may look: the connection is not the first to be closed
  /// where there are too many.
  bool is_trusted = false;
  std::shared_ptr<void> permit;  ///< kept until it is sent; may be null
};

/// The answers of a server, called from many threads at once.
class HttpService {
 public:
  virtual ~HttpService() = default;
  /// Looks at a request before its body is read: a refusal, or the largest body in bytes.
  virtual std::variant<Response, std::size_t> admit(const Request& head) = 0;
  /// Admits and answers.
  virtual Response handle(const Request& request) = 0;
  /// The response to what is no request of HTTP, and the headers of such ones.
  virtual Response refuse(int status) = 0;
};

}  // namespace panelcal::serve
