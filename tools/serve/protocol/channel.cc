// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/protocol/channel.h"

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdint>
#include <string>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>

namespace panelcal::serve {

bool wait_for(int socket, short events, Deadline deadline) {
  while (true) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd waiting{.fd = socket, .events = events, .revents = 0};
    const int n =
        ::poll(&waiting, 1, static_cast<int>(std::min<std::int64_t>(left.count(), 60'000)));
    if (n > 0) return (waiting.revents & (events | POLLHUP)) != 0;
    if (n < 0 && errno != EINTR) return false;
  }
}

namespace {

class PlainChannel final : public Channel {
 public:
  explicit PlainChannel(int socket) : socket_(socket) {}

  std::size_t read_some(char* bytes, std::size_t n, Deadline deadline) override {
    while (true) {
      const ssize_t n_read = ::recv(socket_, bytes, n, 0);
      if (n_read > 0) return static_cast<std::size_t>(n_read);
      if (n_read == 0 || !may_repeat(POLLIN, deadline)) return 0;
    }
  }

  bool write_all(std::string_view bytes, Deadline deadline) override {
    while (!bytes.empty()) {
      const ssize_t n_sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n_sent > 0) {
        bytes.remove_prefix(static_cast<std::size_t>(n_sent));
      } else if (!may_repeat(POLLOUT, deadline)) {
        return false;
      }
    }
    return true;
  }

 private:
  /// After a call that failed.
  bool may_repeat(short events, Deadline deadline) const {
    if (errno == EINTR) return true;
    return (errno == EAGAIN || errno == EWOULDBLOCK) && wait_for(socket_, events, deadline);
  }

  int socket_;
};

struct FreeSsl {
  void operator()(SSL* ssl) const { SSL_free(ssl); }
};
struct FreeContext {
  void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
};

class Identity final : public TlsIdentity {
 public:
  explicit Identity(std::unique_ptr<SSL_CTX, FreeContext> context) : context_(std::move(context)) {}
  SSL_CTX* context() const { return context_.get(); }

 private:
  std::unique_ptr<SSL_CTX, FreeContext> context_;
};

class TlsChannel final : public Channel {
 public:
  TlsChannel(int socket, const Identity& identity)
      : socket_(socket), ssl_(SSL_new(identity.context())) {}
  TlsChannel(const TlsChannel&) = delete;
  TlsChannel& operator=(const TlsChannel&) = delete;

  ~TlsChannel() override {
    // Says goodbye if that needs no waiting.
    if (is_usable_) SSL_shutdown(ssl_.get());
    ERR_clear_error();
  }

  bool accept(Deadline deadline) {
    if (ssl_ == nullptr || SSL_set_fd(ssl_.get(), socket_) != 1) return false;
    is_usable_ = repeat(deadline, [&] { return SSL_accept(ssl_.get()); }) > 0;
    return is_usable_;
  }

  std::size_t read_some(char* bytes, std::size_t n, Deadline deadline) override {
    const int size = static_cast<int>(std::min<std::size_t>(n, INT_MAX));
    return static_cast<std::size_t>(
        std::max(0, repeat(deadline, [&] { return SSL_read(ssl_.get(), bytes, size); })));
  }

  bool write_all(std::string_view bytes, Deadline deadline) override {
    while (!bytes.empty()) {
      const int size = static_cast<int>(std::min<std::size_t>(bytes.size(), INT_MAX));
      const int n = repeat(deadline, [&] { return SSL_write(ssl_.get(), bytes.data(), size); });
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }

 private:
  /// Calls what answers above zero when it is done; else waits for what it waits for.
  template <class Call>
  int repeat(Deadline deadline, Call call) {
    while (true) {
      ERR_clear_error();
      const int n = call();
      if (n > 0) return n;
      const int error = SSL_get_error(ssl_.get(), n);
      const bool is_waiting = error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE;
      const short events = error == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT;
      if (!is_waiting || !wait_for(socket_, events, deadline)) {
        is_usable_ = false;
        return 0;
      }
    }
  }

  int socket_;
  std::unique_ptr<SSL, FreeSsl> ssl_;
  bool is_usable_ = false;
};

std::string tls_words() {
  const unsigned long error = ERR_get_error();
  ERR_clear_error();
  const char* const words = error != 0 ? ERR_reason_error_string(error) : nullptr;
  return words != nullptr ? words : "not readable";
}

tl::unexpected<Diagnostic> tls_problem(const std::filesystem::path& file, const char* expected) {
  return failure({Code::FileUnreadable, {file.string(), 0, 0}, tls_words(), expected});
}

}  // namespace

Expected<std::shared_ptr<TlsIdentity>> open_tls_identity(const std::filesystem::path& certificate,
                                                         const std::filesystem::path& key) {
  ERR_clear_error();
  std::unique_ptr<SSL_CTX, FreeContext> context(SSL_CTX_new(TLS_server_method()));
  if (context == nullptr || SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION) != 1) {
    return tls_problem(certificate, "a working OpenSSL");
  }
  SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  SSL_CTX_set_mode(context.get(),
                   SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  if (SSL_CTX_use_certificate_chain_file(context.get(), certificate.c_str()) != 1) {
    return tls_problem(certificate, "a PEM file with the certificate, and those that sign it");
  }
  if (SSL_CTX_use_PrivateKey_file(context.get(), key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      SSL_CTX_check_private_key(context.get()) != 1) {
    return tls_problem(key, "a PEM file with the key of the certificate, without a password");
  }
  return std::make_shared<Identity>(std::move(context));
}

std::unique_ptr<Channel> open_channel(int socket, TlsIdentity* identity, Deadline deadline) {
  if (identity == nullptr) return std::make_unique<PlainChannel>(socket);
  auto channel = std::make_unique<TlsChannel>(socket, static_cast<const Identity&>(*identity));
  if (!channel->accept(deadline)) return nullptr;
  return channel;
}

}  // namespace panelcal::serve
