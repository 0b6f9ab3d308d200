// SPDX-License-Identifier: Apache-2.0
#include "tests/machine/devices/controls/grbl/fake_grbl.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "calib/base/units.h"
#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace panelcal {
namespace {

const double kInch_mm = inch(1).in_mm();

/// The number behind a letter of G-code.
std::optional<double> word(const std::string& line, char letter) {
  const auto at = line.find(letter);
  if (at == std::string::npos) return std::nullopt;
  return std::strtod(line.c_str() + at + 1, nullptr);
}

}  // namespace

FakeGrbl::FakeGrbl(Setting setting)
    : setting_(std::move(setting)), line_(setting_.half_line), at_mm_(setting_.at_mm) {
  listener_ = internal::FileDescriptor(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  bind(listener_.get(), reinterpret_cast<sockaddr*>(&address), size);
  listen(listener_.get(), 1);
  getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&address), &size);
  port_ = ntohs(address.sin_port);
  std::array<int, 2> ends{};
  (void)!pipe2(ends.data(), O_CLOEXEC);
  wake_read_ = internal::FileDescriptor(ends[0]);
  wake_write_ = internal::FileDescriptor(ends[1]);
  thread_ = std::jthread([this] { serve(); });
}

FakeGrbl::~FakeGrbl() {
  (void)!write(wake_write_.get(), "x", 1);
  thread_.join();
}

void FakeGrbl::serve() {
  for (;;) {
    std::array<pollfd, 3> waiting = {{{wake_read_.get(), POLLIN, 0},
                                      {peer_.get() < 0 ? listener_.get() : -1, POLLIN, 0},
                                      {peer_.get(), POLLIN, 0}}};
    poll(waiting.data(), waiting.size(), 1);
    if (waiting[0].revents != 0) return;
    const std::lock_guard lock(mutex_);
    advance();
    if (waiting[1].revents != 0) {
      peer_ = internal::FileDescriptor(accept(listener_.get(), nullptr, nullptr));
      const int on = 1;
      setsockopt(peer_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      if (setting_.greets) say("\r\nGrbl 1.1h ['$' for help]");
    }
    if (waiting[2].revents == 0) continue;
    std::array<char, 256> bytes{};
    const auto n = read(peer_.get(), bytes.data(), bytes.size());
    if (n <= 0) peer_ = internal::FileDescriptor();
    for (ssize_t i = 0; i < n && peer_.get() >= 0; ++i) take(bytes[static_cast<std::size_t>(i)]);
  }
}

void FakeGrbl::say(std::string_view line) {
  if (is_silent_ || peer_.get() < 0) return;
  const std::string text = std::string(line) + "\r\n";
  send(peer_.get(), text.data(), text.size(), MSG_NOSIGNAL);
}

bool FakeGrbl::is_struck() {
  if (++n_messages_ != setting_.at_message) return false;
  strike();
  return true;
}

void FakeGrbl::strike() {
  advance();
  switch (setting_.fault) {
    case GrblFault::None:
      break;
    case GrblFault::Close:
      peer_ = internal::FileDescriptor();
      break;
    case GrblFault::Silence:
      is_silent_ = true;
      break;
    case GrblFault::Garbage:
      say("<Id\x01le|MP?s:1,2");
      break;
    case GrblFault::Error:
      say("error:20");
      break;
    case GrblFault::Alarm:
      move_.reset();
      setting_.state = "Alarm";
      say("ALARM:1");
      break;
    case GrblFault::Reset:
      move_.reset();
      say("\r\nGrbl 1.1h ['$' for help]");
      break;
    case GrblFault::Hold:
      stop_move();
      setting_.state = "Hold:0";
      report();
      break;
    case GrblFault::Door:
      stop_move();
      setting_.state = "Door:0";
      report();
      break;
  }
}

void FakeGrbl::stop_move() {
  move_.reset();
}

void FakeGrbl::advance() {
  if (!move_) return;
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - move_->begin).count();
  double part = move_->s <= 0 ? 1 : std::min(1.0, elapsed_s / move_->s);
  const bool touches = move_->is_probing && move_->to[2] < setting_.surface_mm;
  if (touches) {
    const double way_mm = move_->to[2] - move_->from[2];
    part = std::min(part, (setting_.surface_mm - move_->from[2]) / way_mm);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    at_mm_[i] = move_->from[i] + part * (move_->to[i] - move_->from[i]);
  }
  if (touches && at_mm_[2] <= setting_.surface_mm + 1e-9) {
    move_.reset();
    setting_.probe_is_tripped = setting_.probe_sticks;
    say(fmt::format("[PRB:{}:1]", place(at_mm_)));
    say("ok");
  } else if (part >= 1 && move_->is_probing) {
    move_.reset();
    setting_.state = "Alarm";
    say("ALARM:5");
    say(fmt::format("[PRB:{}:0]", place(at_mm_)));
    say("ok");
  } else if (part >= 1) {
    move_.reset();
  }
}

void FakeGrbl::take(char byte) {
  switch (byte) {
    case '?':
      if (!is_struck()) report();
      return;
    case '\x18':
      received_.emplace_back("reset");
      if (move_) {
        setting_.state = "Alarm";
        say("ALARM:3");
      } else if (setting_.state != "Alarm") {
        setting_.state = "Idle";
      }
      move_.reset();
      line_.clear();
      say("\r\nGrbl 1.1h ['$' for help]");
      return;
    case '\x85':
      received_.emplace_back("jog cancel");
      advance();
      if (move_ && move_->is_jog) stop_move();
      return;
    case '!':
      received_.emplace_back("!");
      advance();
      if (move_) setting_.state = "Hold:0";
      stop_move();
      return;
    case '\x87':
      report();
      return report(setting_.full_extra);
    case '\n':
      take_line(std::exchange(line_, {}));
      return;
    default:
      if (byte != '\r' && static_cast<unsigned char>(byte) < 0x80) line_ += byte;
  }
}

std::string FakeGrbl::settings() const {
  std::string text = "$0=10\r\n$10=" + std::string(setting_.work_only ? "0" : "1");
  text += fmt::format(
      "\r\n$13={}\r\n$20=0\r\n$22={}\r\n", setting_.inches ? 1 : 0, setting_.homing ? 1 : 0);
  for (int axis = 0; axis < 3; ++axis) {
    text += fmt::format("${}=250.000\r\n${}=500.000\r\n${}={:.3f}\r\n",
                        100 + axis,
                        110 + axis,
                        130 + axis,
                        setting_.travel_mm);
  }
  return text;
}

void FakeGrbl::take_line(const std::string& line) {
  if (!line.empty() && line != "$") received_.push_back(line);
  if (is_struck()) return;
  // It begins a line of the control's own; elsewhere it makes any line invalid.
  if (line != "$$" && line.find('$', 1) != std::string::npos) return say("error:1");
  if (line == "$") say("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]");
  if (line == "$I") say(setting_.identity);
  if (line == "$$") say(settings());
  if (line == "$#") say(setting_.offsets);
  if (line == "$G") say("[GC:" + setting_.modes + "]");
  if (line == "$H") {
    setting_.state = "Idle";
    at_mm_ = {-1, -1, -1};
  }
  if (line.starts_with("$J=")) return jog(line);
  if (line.find("G38.2") != std::string::npos) return probe(line);
  if (line.starts_with("G9")) setting_.modes = line;
  say("ok");
}

void FakeGrbl::jog(const std::string& line) {
  if (setting_.state != "Idle") return say("error:9");
  const std::string words = line.substr(line.find("G90") + 3);
  std::array<double, 3> to = at_mm_;
  for (std::size_t i = 0; i < 3; ++i) to[i] = word(words, "XYZ"[i]).value_or(to[i]);
  begin_move(to, true, false, setting_.mm_s);
  say("ok");
}

void FakeGrbl::probe(const std::string& line) {
  if (setting_.state != "Idle") return say("error:9");
  if (setting_.probe_is_tripped) {
    setting_.state = "Alarm";
    return say("ALARM:4");
  }
  std::array<double, 3> to = at_mm_;
  to[2] += word(line, 'Z').value_or(0);
  begin_move(to, false, true, setting_.mm_s);
}

void FakeGrbl::begin_move(std::array<double, 3> to, bool is_jog, bool is_probing, double mm_s) {
  const double way_mm = std::hypot(to[0] - at_mm_[0], to[1] - at_mm_[1], to[2] - at_mm_[2]);
  move_ = Move{at_mm_, to, Clock::now(), way_mm / mm_s, is_jog, is_probing};
}

std::string FakeGrbl::place(std::array<double, 3> mm) const {
  const double unit = setting_.inches ? kInch_mm : 1;
  const int digits = setting_.inches ? 4 : 3;
  return fmt::format(
      "{:.{}f},{:.{}f},{:.{}f}", mm[0] / unit, digits, mm[1] / unit, digits, mm[2] / unit, digits);
}

void FakeGrbl::report(std::string_view extra) {
  advance();
  std::string state = setting_.state;
  if (move_) state = move_->is_jog ? "Jog" : "Run";
  std::array<double, 3> shown = at_mm_;
  if (setting_.work_only) {
    for (std::size_t i = 0; i < 3; ++i) shown[i] -= setting_.offset_mm[i];
  }
  std::string text =
      fmt::format("<{}|{}:{}|FS:0,0", state, setting_.work_only ? "WPos" : "MPos", place(shown));
  if (setting_.probe_is_tripped) text += "|Pn:P";
  if (++n_reports_ % 4 == 0) text += "|WCO:" + place(setting_.offset_mm);
  say(text + setting_.extra + std::string(extra) + ">");
}

std::vector<std::string> FakeGrbl::received() const {
  const std::lock_guard lock(mutex_);
  return received_;
}

std::array<double, 3> FakeGrbl::end_mm() const {
  const std::lock_guard lock(mutex_);
  return move_ ? move_->to : at_mm_;
}

bool FakeGrbl::is_moving() const {
  const std::lock_guard lock(mutex_);
  return move_.has_value() && Clock::now() < move_->begin + std::chrono::duration<double>(move_->s);
}

std::string FakeGrbl::modes() const {
  const std::lock_guard lock(mutex_);
  return setting_.modes;
}

}  // namespace panelcal
