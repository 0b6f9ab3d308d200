// SPDX-License-Identifier: Apache-2.0
// cpp-httplib reads requests and writes responses here; sockets, times and sizes are ours.
#include "tools/serve/protocol/protocol.h"

#include <charconv>
#include <string>
#include <utility>
#include <variant>

#include "tools/serve/protocol/bounded_stream.h"
#include <httplib.h>

namespace panelcal::serve {
namespace {

/// One connection's requests, one after the other. The library routes nothing: each request goes to
/// the service before its body is read.
class Exchange final : private httplib::Server {
 public:
  Exchange(BoundedStream& stream, HttpService& service, bool is_encrypted)
      : stream_(stream), service_(service), is_encrypted_(is_encrypted) {
    // The library takes a server without a socket for one that ends, and would end all streams.
    svr_sock_ = stream.socket();
    set_pre_routing_handler([this](const httplib::Request& /*head*/, httplib::Response& out) {
      answer(out);
      return HandlerResponse::Handled;
    });
    set_post_routing_handler([this](const httplib::Request& /*head*/, httplib::Response& out) {
      if (!is_answered_) replace(out);
    });
  }

  /// False: the connection is of no use any more.
  bool serve_one() {
    is_answered_ = false;
    closes_ = false;
    bool is_closing = false;
    const bool is_served = process_request(
        stream_, false, is_closing, [this](httplib::Request& head) { begin(head); });
    if (closes_) stream_.drain();
    return is_served && !is_closing && !closes_;
  }

 private:
  void begin(httplib::Request& head) {
    head_ = &head;
    // Pieces of a response and compressed ones: what the library makes of them costs more than it
    // saves, Brotli at its slowest.
    head.ranges.clear();
    head.headers.erase("Range");
    head.headers.erase("Accept-Encoding");
    request_ = Request{};
    request_.method = head.method;
    request_.target = head.target;
    for (const auto& [name, value] : head.headers) request_.headers.push_back({name, value});
    request_.peer = head.remote_addr;
    request_.local_address = head.local_addr;
    request_.local_port = head.local_port;
    request_.is_encrypted = is_encrypted_;
  }

  void answer(httplib::Response& out) {
    auto admitted = service_.admit(request_);
    if (auto* const refusal = std::get_if<Response>(&admitted)) {
      // A body that is not read would be taken for the next request.
      if (request_.n_headers("content-length") + request_.n_headers("transfer-encoding") > 0) {
        close_after_this();
      }
      return put(std::move(*refusal), out);
    }
    if (std::get<std::size_t>(admitted) > 0 && !read_body()) {
      close_after_this();
      return put(service_.refuse(408), out);
    }
    put(service_.handle(request_), out);
  }

  /// The service has seen that the length is a number within its limit.
  bool read_body() {
    const std::string_view text = request_.header("content-length");
    std::size_t n_bytes = 0;
    std::from_chars(text.data(), text.data() + text.size(), n_bytes);
    return stream_.read_body(request_.body, n_bytes);
  }

  void close_after_this() {
    closes_ = true;
    if (head_ == nullptr) return;
    head_->headers.erase("Connection");
    head_->set_header("Connection", "close");
  }

  void put(Response response, httplib::Response& out) {
    is_answered_ = true;
    out.status = response.status;
    for (const Header& header : response.headers) out.set_header(header.name, header.value);
    if (response.events == nullptr) {
      out.body = std::move(response.body);
      return;
    }
    close_after_this();
    const auto send = [this, events = std::move(response.events)](std::size_t /*offset*/,
                                                                  httplib::DataSink& sink) {
      constexpr std::chrono::milliseconds kLook{1000};
      const std::optional<std::string> text = events->next(kLook);
      if (!text || !stream_.is_open()) return false;
      return text->empty() || sink.write(text->data(), text->size());
    };
    out.set_chunked_content_provider("text/event-stream", send);
  }

  /// In place of what the library says to what is no request.
  void replace(httplib::Response& out) {
    constexpr int kHeadTooLarge = 431;
    Response own = service_.refuse(stream_.is_over_limit() ? kHeadTooLarge : out.status);
    closes_ = true;
    out.headers.clear();
    out.set_header("Connection", "close");
    out.set_header("Content-Length", std::to_string(own.body.size()));
    put(std::move(own), out);
  }

  BoundedStream& stream_;
  HttpService& service_;
  bool is_encrypted_;
  Request request_;
  httplib::Request* head_ = nullptr;  ///< while this request is answered
  bool is_answered_ = false;
  bool closes_ = false;
};

}  // namespace

void serve_connection(int socket,
                      TlsIdentity* identity,
                      HttpService& service,
                      const ConnectionLimits& limits) {
  try {
    const auto deadline = std::chrono::steady_clock::now() + limits.head_time;
    const std::unique_ptr<Channel> channel = open_channel(socket, identity, deadline);
    if (channel == nullptr) return;
    BoundedStream stream(socket, *channel, limits);
    Exchange exchange(stream, service, identity != nullptr);
    while (stream.begin_request() && exchange.serve_one()) {
    }
  } catch (const std::exception&) {
    // Of this connection alone: without memory, or a request that the library cannot take.
  }
}

}  // namespace panelcal::serve
