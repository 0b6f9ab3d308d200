// SPDX-License-Identifier: Apache-2.0
// cpp-httplib writes responses here, in pieces where they have no end. Requests, sockets, times and
// sizes are ours (docs/decisions/http.md).
#include "tools/serve/protocol/protocol.h"

#include <charconv>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "tools/serve/http/head.h"
#include "tools/serve/protocol/bounded_stream.h"
#include <httplib.h>

namespace panelcal::serve {
namespace {

/// One connection's requests, one after the other.
class Exchange final : private httplib::Server {
 public:
  Exchange(BoundedStream& stream,
           HttpService& service,
           ConnectionNote& note,
           bool is_encrypted,
           std::chrono::milliseconds idle_time)
      : stream_(stream), service_(service), note_(note), is_encrypted_(is_encrypted) {
    // For the header Keep-Alive alone: how long and how often a connection is used.
    set_keep_alive_timeout(std::chrono::floor<std::chrono::seconds>(idle_time).count());
    set_keep_alive_max_count(100'000);
    // The library takes a server without a socket for one that ends, and would end all streams.
    svr_sock_ = stream.socket();
    set_pre_routing_handler([this](const httplib::Request& /*head*/, httplib::Response& out) {
      put(std::move(response_), out);
      return HandlerResponse::Handled;
    });
  }

  /// False: the connection is of no use any more.
  bool serve_one() {
    const std::optional<std::string> text = stream_.read_head();
    if (!text) return false;
    note_.begin_request();
    closes_ = false;
    response_ = respond(*text);
    if (response_.is_trusted) note_.is_trusted = true;
    if (response_.events != nullptr) closes_ = true;
    if (response_.delay.count() > 0) stream_.pause(response_.delay);
    const std::shared_ptr<void> permit = response_.permit;
    // All that the library sees of the request.
    stream_.give((is_head_ ? "HEAD" : "GET") + std::string(" / HTTP/1.1\r\n") +
                 (closes_ ? "Connection: close\r\n\r\n" : "\r\n"));
    bool is_closing = false;
    const bool is_served = process_request(stream_, closes_, is_closing, nullptr);
    response_ = {};
    if (closes_) stream_.drain();
    note_.end_request();
    return is_served && !closes_;
  }

 private:
  Response respond(const std::string& text) {
    is_head_ = false;
    std::optional<Head> head = parse_head(text);
    if (!head) {
      closes_ = true;
      constexpr int kHeadTooLarge = 431;
      constexpr int kMalformed = 400;
      return service_.refuse(text.empty() ? kHeadTooLarge : kMalformed);
    }
    Request request = std::move(head->request);
    is_head_ = request.method == "HEAD";
    closes_ = head->closes;
    int peer_port = 0;
    stream_.get_remote_ip_and_port(request.peer, peer_port);
    stream_.get_local_ip_and_port(request.local_address, request.local_port);
    request.is_encrypted = is_encrypted_;
    auto admitted = service_.admit(request);
    if (auto* const refusal = std::get_if<Response>(&admitted)) {
      // A body that is not read would be taken for the next request.
      if (request.n_headers("content-length") + request.n_headers("transfer-encoding") > 0) {
        closes_ = true;
      }
      return std::move(*refusal);
    }
    if (std::get<std::size_t>(admitted) > 0 && !read_body(request)) {
      closes_ = true;
      constexpr int kTooSlow = 408;
      return service_.refuse(kTooSlow);
    }
    return service_.handle(request);
  }

  /// The service has seen that the length is a number within its limit.
  bool read_body(Request& request) {
    const std::string_view length = request.header("content-length");
    std::size_t n_bytes = 0;
    std::from_chars(length.data(), length.data() + length.size(), n_bytes);
    constexpr std::string_view kGoOn = "HTTP/1.1 100 Continue\r\n\r\n";
    if (request.header("expect") == "100-continue") stream_.write(kGoOn.data(), kGoOn.size());
    return stream_.read_body(request.body, n_bytes);
  }

  void put(Response response, httplib::Response& out) {
    out.status = response.status;
    for (const Header& header : response.headers) {
      // The library states the type of a stream itself.
      const bool is_stated = response.events != nullptr && header.name == "Content-Type";
      if (!is_stated) out.set_header(header.name, header.value);
    }
    if (response.events == nullptr) {
      out.body = std::move(response.body);
      return;
    }
    const auto send = [this, events = std::move(response.events)](std::size_t /*offset*/,
                                                                  httplib::DataSink& sink) {
      constexpr std::chrono::milliseconds kLook{1000};
      const std::optional<std::string> text = events->next(kLook);
      if (!text || !stream_.is_open()) return false;
      return text->empty() || sink.write(text->data(), text->size());
    };
    out.set_chunked_content_provider("text/event-stream", send);
  }

  BoundedStream& stream_;
  HttpService& service_;
  ConnectionNote& note_;
  bool is_encrypted_;
  Response response_;
  bool is_head_ = false;
  bool closes_ = false;
};

}  // namespace

void load_protocol() {
}

void serve_connection(int socket,
                      ConnectionNote& note,
                      TlsIdentity* identity,
                      HttpService& service,
                      const ConnectionLimits& limits) {
  const auto deadline = std::chrono::steady_clock::now() + limits.head_time;
  const std::unique_ptr<Channel> channel = open_channel(socket, identity, deadline);
  if (channel == nullptr) return;
  BoundedStream stream(socket, *channel, limits);
  Exchange exchange(stream, service, note, identity != nullptr, limits.idle_time);
  while (exchange.serve_one()) {
  }
}

}  // namespace panelcal::serve
