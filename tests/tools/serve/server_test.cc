// SPDX-License-Identifier: Apache-2.0
// The server at a real socket, with a fake machine behind it.
#include "tools/serve/server.h"

#include <array>
#include <future>
#include <optional>
#include <random>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/tools/serve/served_test.h"

namespace panelcal::serve {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A client that sends any bytes.
class Client {
 public:
  /// In     buffer_bytes: what the socket keeps for a client that does not read; 0: as usual
  explicit Client(int port, int buffer_bytes = 0)
      : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (buffer_bytes > 0) {
      ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof buffer_bytes);
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    const auto* const any = reinterpret_cast<const sockaddr*>(&address);
    if (::connect(socket_, any, sizeof address) != 0) ADD_FAILURE() << "no connection";
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() { ::close(socket_); }

  void send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  void finish() { ::shutdown(socket_, SHUT_WR); }

  /// Until `text` was seen, the server closes, or the time is over.
  std::string read_until(std::string_view text, milliseconds at_most) {
    const auto end = steady_clock::now() + at_most;
    std::string seen;
    while (text.empty() || seen.find(text) == seen.npos) {
      const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now());
      pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
      if (left.count() <= 0 || ::poll(&waiting, 1, static_cast<int>(left.count())) <= 0) break;
      std::array<char, 65536> piece{};
      const ssize_t n = ::recv(socket_, piece.data(), piece.size(), 0);
      if (n <= 0) {
        is_closed = true;
        break;
      }
      seen.append(piece.data(), static_cast<std::size_t>(n));
    }
    return seen;
  }

  bool is_closed = false;

 private:
  int socket_;
};

class ServeSocket : public ServedTest {
 protected:
  ServeSocket() {
    limits_.head_time = milliseconds(500);
    limits_.idle_time = milliseconds(2000);
    limits_.transfer_time = milliseconds(500);
    limits_.slowest_bytes_s = 2'000'000;
    server_ = std::thread(
        [this] { run_server(listener_, nullptr, *service, announcer, stop_, limits_); });
  }
  ~ServeSocket() override { end(); }

  void end() {
    if (!server_.joinable()) return;
    const std::uint64_t one = 1;
    EXPECT_EQ(::write(stop_, &one, sizeof one), 8);
    server_.join();
  }

  std::string head(const std::string& first_line, const std::string& rest = "") const {
    return first_line + "\r\nHost: " + listener_.text() + "\r\n" + rest + "\r\n";
  }
  /// One request, and all that comes back.
  std::string ask(const std::string& bytes) {
    Client client(listener_.port());
    client.send(bytes);
    client.finish();
    return client.read_until("", milliseconds(5000));
  }

  Listener listener_ = *Listener::open("127.0.0.1:0");
  ConnectionLimits limits_;
  int stop_ = ::eventfd(0, EFD_CLOEXEC);
  std::thread server_;
};

TEST_F(ServeSocket, AnswersSeveralRequestsOfOneConnection) {
  Client client(listener_.port());
  for (int i = 0; i < 20; ++i) {
    client.send(head("GET /api/state HTTP/1.1"));
    const std::string answer = client.read_until("\"version\":1}", milliseconds(5000));
    ASSERT_THAT(answer, StartsWith("HTTP/1.1 200 ")) << i;
    EXPECT_THAT(answer, HasSubstr("X-Content-Type-Options: nosniff\r\n"));
    EXPECT_THAT(answer, HasSubstr("Keep-Alive: timeout=2,"));
  }
}

TEST_F(ServeSocket, PassesACommandOn) {
  take_controls();
  Client client(listener_.port());
  const std::string body = R"({"do":"stop"})";
  client.send(head("POST /api/command HTTP/1.1",
                   "Content-Type: application/json\r\nX-Panelcal-Controls: " + key +
                       "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n") +
              body);
  EXPECT_THAT(client.read_until("{}", milliseconds(5000)), StartsWith("HTTP/1.1 200 "));
  EXPECT_EQ(machine.n_changes(), 1U);
}

TEST_F(ServeSocket, AnswersWhatIsNoRequestWithTheHeadersOfSafety) {
  for (const std::string& bytes : {std::string("\r\n\r\n"),
                                   std::string("GET\r\n\r\n"),
                                   std::string("GET /\r\n\r\n"),
                                   std::string("GET / HTTP/9.9\r\n\r\n"),
                                   head("GET / HTTP/1.1", "no colon\r\n"),
                                   std::string("\x16\x03\x01\x02\r\n\r\n"),
                                   std::string(3, '\0') + "\r\n\r\n"}) {
    const std::string answer = ask(bytes);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 400 ")) << testing::PrintToString(bytes);
    EXPECT_THAT(answer, HasSubstr("Content-Security-Policy: default-src 'none'"));
    EXPECT_THAT(answer, HasSubstr("\"error\""));
    EXPECT_THAT(answer, HasSubstr("Connection: close\r\n"));
  }
}

TEST_F(ServeSocket, EndsEndlessHeads) {
  const std::string line = head("GET /" + std::string(20'000, 'a') + " HTTP/1.1");
  EXPECT_THAT(ask(line), StartsWith("HTTP/1.1 431 "));
  std::string many;
  for (int i = 0; i < 10'000; ++i) many += "X-" + std::to_string(i) + ": y\r\n";
  EXPECT_THAT(ask(head("GET /api/state HTTP/1.1", many)), StartsWith("HTTP/1.1 431 "));
  Client endless(listener_.port());
  for (int i = 0; i < 200; ++i) endless.send(std::string(100'000, 'a'));
  endless.read_until("", milliseconds(5000));
  EXPECT_TRUE(endless.is_closed);
}

TEST_F(ServeSocket, GivesTheLibraryNothingOfARequest) {
  // cpp-httplib reads these by std::regex, which takes the stack for each digit.
  const std::string digits = "Range: bytes=" + std::string(7900, '1') + "\r\n";
  EXPECT_THAT(ask(head("GET /app.js HTTP/1.1", digits)), HasSubstr("\r\n\r\nscript"));
  const std::string answer =
      ask(head("GET /app.js HTTP/1.1", "Range: bytes=0-1\r\nAccept-Encoding: br, gzip\r\n"));
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(answer, HasSubstr("\r\n\r\nscript"));
}

TEST_F(ServeSocket, InvitesABodyOnlyAfterItIsAdmitted) {
  const std::string expect = "Content-Type: application/json\r\nExpect: 100-continue\r\n";
  Client refused(listener_.port());
  refused.send(head("POST /api/login HTTP/1.1", expect + "Content-Length: 70000\r\n"));
  EXPECT_THAT(refused.read_until("\r\n\r\n", milliseconds(5000)), StartsWith("HTTP/1.1 413 "));
  Client admitted(listener_.port());
  admitted.send(head("POST /api/login HTTP/1.1", expect + "Content-Length: 2\r\n"));
  EXPECT_EQ(admitted.read_until("\r\n\r\n", milliseconds(5000)), "HTTP/1.1 100 Continue\r\n\r\n");
  admitted.send("{}");
  EXPECT_THAT(admitted.read_until("{}", milliseconds(5000)), StartsWith("HTTP/1.1 200 "));
}

TEST_F(ServeSocket, MakesRoomForPeopleAmongIdleConnections) {
  Client screen(listener_.port());
  screen.send(head("GET /api/events HTTP/1.1"));
  screen.read_until("event: controls", milliseconds(5000));
  std::vector<std::unique_ptr<Client>> idle;
  for (int i = 0; i < 200; ++i) idle.push_back(std::make_unique<Client>(listener_.port()));
  EXPECT_THAT(ask(head("GET /app.js HTTP/1.1")), HasSubstr("script"));
  // The screen has stayed.
  machine.change("{\"still\":\"here\"}");
  EXPECT_THAT(screen.read_until("still", milliseconds(5000)), HasSubstr("still"));
}

TEST_F(ServeSocket, ClosesConnectionsThatSendTooSlowly) {
  Client client(listener_.port());
  client.send("GET /api/state HTT");
  client.read_until("", milliseconds(5000));
  EXPECT_TRUE(client.is_closed);
  take_controls();
  Client body(listener_.port());
  body.send(head("POST /api/command HTTP/1.1",
                 "Content-Type: application/json\r\nX-Panelcal-Controls: " + key +
                     "\r\nContent-Length: 100\r\n") +
            "{");
  EXPECT_THAT(body.read_until("", milliseconds(5000)), StartsWith("HTTP/1.1 408 "));
  EXPECT_EQ(machine.n_changes(), 0U);
}

TEST_F(ServeSocket, RefusesLargeBodiesUnread) {
  Client client(listener_.port());
  client.send(head("POST /api/login HTTP/1.1",
                   "Content-Type: application/json\r\nContent-Length: 100000000\r\n"));
  EXPECT_THAT(client.read_until("\r\n\r\n", milliseconds(5000)), StartsWith("HTTP/1.1 413 "));
  client.read_until("", milliseconds(5000));
  EXPECT_TRUE(client.is_closed);
}

TEST_F(ServeSocket, ServesTwentyScreensBesideASlowOne) {
  // It asks for all events and reads none; what it misses is more than a socket holds.
  Client slow(listener_.port(), 65536);
  slow.send(head("GET /api/events HTTP/1.1"));
  std::vector<std::unique_ptr<Client>> screens;
  for (int i = 0; i < 20; ++i) {
    screens.push_back(std::make_unique<Client>(listener_.port()));
    screens.back()->send(head("GET /api/events HTTP/1.1"));
    ASSERT_THAT(screens.back()->read_until("event: controls", milliseconds(5000)),
                HasSubstr("event: controls"));
  }
  EXPECT_TRUE(machine.is_watched);
  for (int i = 0; i < 6; ++i) {
    const std::string mark = "change " + std::to_string(i) + " seen";
    machine.change("{\"" + std::string(1'500'000, 'x') + mark + "\"}");
    for (const auto& screen : screens) {
      ASSERT_THAT(screen->read_until(mark, milliseconds(20'000)), HasSubstr(mark));
    }
  }
  EXPECT_THAT(ask(head("GET /app.js HTTP/1.1")), HasSubstr("script"));
  // The slow one is dropped, though it never closed: what it reads later is what was on its way.
  std::this_thread::sleep_for(milliseconds(3000));
  slow.read_until("", milliseconds(10'000));
  EXPECT_TRUE(slow.is_closed);
}

TEST_F(ServeSocket, NoticesAScreenThatCloses) {
  {
    Client screen(listener_.port());
    screen.send(head("GET /api/events HTTP/1.1"));
    screen.read_until("event: controls", milliseconds(5000));
    EXPECT_TRUE(machine.is_watched);
  }
  const auto end = steady_clock::now() + milliseconds(5000);
  while (machine.is_watched && steady_clock::now() < end) {
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_FALSE(machine.is_watched);
}

TEST_F(ServeSocket, EndsWithOpenStreams) {
  Client screen(listener_.port());
  screen.send(head("GET /api/events HTTP/1.1"));
  screen.read_until("event: controls", milliseconds(5000));
  Client idle(listener_.port());
  const auto begin = steady_clock::now();
  end();
  EXPECT_LT(steady_clock::now() - begin, milliseconds(30'000));
}

TEST_F(ServeSocket, SurvivesMalformedBytes) {
  constexpr int kConnections = 500;
  constexpr std::uint32_t kSocketSeed = 20261127;
  std::mt19937 random(kSocketSeed);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  take_controls("Anna");
  const std::string command =
      head("POST /api/command HTTP/1.1",
           "Content-Type: application/json\r\nX-Panelcal-Controls: " + std::string(25, '0') +
               "\r\nContent-Length: 14\r\n") +
      R"({"do":"start"})";
  for (int i = 0; i < kConnections; ++i) {
    std::string bytes =
        i % 3 == 0 ? head("GET /api/state HTTP/1.1", "Range: bytes=0-5\r\n") : command;
    for (std::size_t n = below(12); n > 0; --n) {
      const std::size_t at = below(bytes.size());
      switch (below(4)) {
        case 0:
          bytes[at] = static_cast<char>(below(256));
          break;
        case 1:
          bytes.erase(at, below(20));
          break;
        case 2:
          bytes.insert(at, std::string(below(300), static_cast<char>(below(256))));
          break;
        default:
          bytes += bytes.substr(at);
      }
      if (bytes.empty()) bytes = "\r\n";
    }
    Client client(listener_.port());
    client.send(bytes);
    client.finish();
    client.read_until("", milliseconds(3000));
    ASSERT_EQ(machine.n_changes(), 0U) << "connection " << i;
  }
  EXPECT_EQ(controls.holder(), "Anna");
  EXPECT_THAT(ask(head("GET /api/state HTTP/1.1")), StartsWith("HTTP/1.1 200 "));
}

}  // namespace
}  // namespace panelcal::serve
