// SPDX-License-Identifier: Apache-2.0
#include "tests/machine/devices/controls/linuxcnc/fake_linuxcnc.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace panelcal::test {
namespace {

constexpr double kSpeed_mm_s = 2000;
constexpr double kTravel_mm = 500;
constexpr double kLow_mm = -5;
/// Beyond the touch, as a control that has to brake.
constexpr double kOvershoot_mm = 0.004;
constexpr double kWork_mm = 3;  ///< Z of the work offset, which #5063 and #5422 count from

std::string upper_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string word_of(std::string_view text, std::size_t index) {
  std::istringstream words{std::string(text)};
  std::string word;
  for (std::size_t i = 0; i <= index; ++i) {
    word.clear();
    words >> word;
  }
  return word;
}

}  // namespace

FakeLinuxCnc::FakeLinuxCnc(Setting setting)
    : setting_(std::move(setting)), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  if (setting_.codes.find(" G20 ") != std::string::npos) mm_per_word_ = 25.4;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(listener_.get(), reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      listen(listener_.get(), 4) != 0 ||
      getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    std::abort();
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { serve(); });
}

FakeLinuxCnc::~FakeLinuxCnc() {
  ends_ = true;
  thread_.join();
}

void FakeLinuxCnc::serve() {
  std::vector<Client> clients;
  const auto end = [&clients](std::size_t i) {
    ::close(clients[i].fd);
    clients.erase(clients.begin() + static_cast<std::ptrdiff_t>(i));
  };
  while (!ends_) {
    std::vector<pollfd> waiting{{.fd = listener_.get(), .events = POLLIN, .revents = 0}};
    for (const Client& client : clients) {
      waiting.push_back({.fd = client.fd, .events = POLLIN, .revents = 0});
    }
    poll(waiting.data(), waiting.size(), 5);
    for (std::size_t i = clients.size(); i-- > 0;) {
      if (waiting[i + 1].revents == 0) continue;
      std::array<char, 4096> piece{};
      const ssize_t n = read(clients[i].fd, piece.data(), piece.size());
      if (n <= 0) {
        end(i);
        continue;
      }
      Client& client = clients[i];
      client.received.append(piece.data(), static_cast<std::size_t>(n));
      bool stays = true;
      for (auto at = client.received.find('\n'); stays && at != std::string::npos;
           at = client.received.find('\n')) {
        std::string line = client.received.substr(0, at);
        client.received.erase(0, at + 1);
        while (!line.empty() && line.back() == '\r') line.pop_back();
        stays = answer(client, line);
      }
      if (!stays) end(i);
    }
    if ((waiting[0].revents & POLLIN) != 0 && listener_.get() >= 0) {
      const int fd = accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC);
      if (fd >= 0) clients.push_back({.fd = fd});
    }
  }
  while (!clients.empty()) end(0);
}

/// False: the connection ends.
bool FakeLinuxCnc::answer(Client& client, const std::string& line) {
  const std::lock_guard lock(mutex_);
  const bool is_struck = n_requests_++ == setting_.fault_at ||
                         (setting_.fault_in_move != 0 && n_moves_ == setting_.fault_in_move);
  if (is_struck) {
    setting_.fault_in_move = 0;
    setting_.at_fault();
  }
  const CncFault fault = is_struck ? setting_.fault : CncFault::None;
  strike(fault);
  if (fault == CncFault::Gone) listener_.close();
  if (fault == CncFault::Close || fault == CncFault::Gone) return false;
  if (fault == CncFault::Silence) return true;
  const std::string verb = upper_case(word_of(line, 0));
  const std::string subject = upper_case(word_of(line, 1));
  std::string out = client.has_echo && client.is_linked ? line + "\r\n" : "";
  if (fault == CncFault::Garbage) {
    out += "\x01?!#\r\n";
  } else if (fault == CncFault::Nak) {
    out += verb + " " + subject + " NAK\n\r";
  } else if (verb == "HELLO") {
    client.is_linked = word_of(line, 1) == connect_password;
    out += client.is_linked ? "HELLO ACK EMCNETSVR 1.1\r\n" : "HELLO NAK\r\n";
  } else if (!client.is_linked) {
    out.clear();
  } else if (verb == "GET") {
    out += get_answer(client, subject) + "\r\n";
  } else if (verb == "SET") {
    const std::string result = set_answer(client, line.substr(4));
    if (client.is_verbose) out += "SET " + subject + " " + result + "\n\r";
  }
  return send(client.fd, out.data(), out.size(), MSG_NOSIGNAL) >= 0;
}

void FakeLinuxCnc::strike(CncFault fault) {
  const bool was_moving = is_moving();
  if (fault == CncFault::Estop) {
    estop = true;
  } else if (fault == CncFault::Limit) {
    joint_limit_ = "OK MAXHARD OK OK OK OK";
  } else if (fault == CncFault::Fault) {
    joint_fault_ = "OK OK FAULT OK OK OK";
  }
  if (fault == CncFault::Estop || fault == CncFault::Limit || fault == CncFault::Fault) {
    is_on = false;
    halt();
  } else if (fault == CncFault::Pause) {
    status_word = "PAUSED";
    halt();
  } else if (fault == CncFault::Hold) {
    is_held_ = true;
  } else if (fault == CncFault::Mode) {
    mode = "MANUAL";
    halt();
  } else if (fault == CncFault::Steal) {
    owner_ = -1;
  } else if (fault == CncFault::Error) {
    error_ = "joint 0 following error";
    is_on = false;
    halt();
  } else if (fault == CncFault::ProbeStuck) {
    probe_is_stuck = true;
  }
  if (is_held_ && was_moving) {
    motion_.from = now();
    motion_.start = Clock::now();
    motion_.duration_s = 1e9;
  }
}

std::string FakeLinuxCnc::set_answer(Client& client, const std::string& words) {
  const std::string subject = upper_case(word_of(words, 0));
  const std::string value = word_of(words, 1);
  if (subject == "ECHO") {
    client.has_echo = upper_case(value) == "ON";
  } else if (subject == "VERBOSE") {
    client.is_verbose = upper_case(value) == "ON";
  } else if (subject == "ENABLE") {
    if (value != enable_password) return "NAK";
    owner_ = client.fd;
  } else if (owner_ != client.fd) {
    return "NAK";
  } else if (subject == "MODE") {
    // As LinuxCNC: accepted, and not carried out.
    if (has_program) {
      error_ = "Can't switch mode while mode is AUTO and interpreter is not IDLE";
    } else {
      mode = upper_case(value);
    }
  } else if (subject == "HOME") {
    setting_.is_homed = true;
  } else if (subject == "ABORT") {
    halt();
    status_word.clear();
    is_held_ = false;
  } else if (subject == "PROBE_CLEAR") {
    tripped_ = false;
  } else if (subject == "MDI") {
    if (estop || !is_on) return "NAK";
    mdi(words.substr(4));
  } else if (subject != "SET_WAIT") {
    return "NAK";
  }
  return "ACK";
}

std::string FakeLinuxCnc::get_answer(const Client& client, const std::string& subject) {
  const auto on_off = [&](bool value) { return subject + (value ? " ON" : " OFF"); };
  const auto place = [&](const Eigen::Vector3d& at_mm) {
    const Eigen::Vector3d at = at_mm / (setting_.is_inch ? 25.4 : 1.0);
    return fmt::format(
        "{} {:.6f} {:.6f} {:.6f} 0.000000 0.000000 0.000000", subject, at.x(), at.y(), at.z());
  };
  if (motion_.trips && !is_moving()) tripped_ = true;
  if (subject == "ESTOP") return on_off(estop);
  if (subject == "MACHINE") return on_off(is_on);
  if (subject == "ENABLE") return on_off(owner_ == client.fd);
  if (subject == "MODE") return "MODE " + mode;
  if (subject == "USER_LINEAR_UNITS") return subject + (setting_.is_inch ? " INCH" : " MM");
  if (subject == "JOINT_LIMIT") return "JOINT_LIMIT " + joint_limit_;
  if (subject == "JOINT_FAULT") return "JOINT_FAULT " + joint_fault_;
  if (subject == "JOINT_HOMED") {
    return subject + (setting_.is_homed ? " YES YES YES NO NO NO" : " YES NO YES NO NO NO");
  }
  if (subject == "PROGRAM_STATUS") {
    if (!status_word.empty()) return subject + " " + status_word;
    return subject + (is_moving() || has_program ? " RUNNING" : " IDLE");
  }
  if (subject == "PROGRAM_CODES") return subject + " " + setting_.codes;
  if (subject == "ABS_CMD_POS") return place(now());
  if (subject == "ABS_ACT_POS") return place(now() + setting_.encoder_mm);
  if (subject == "PROBE_TRIPPED") return subject + (tripped_ ? " 1" : " 0");
  if (subject == "PROBE_VALUE") {
    const Eigen::Vector3d at = now();
    const bool touches = probe_is_stuck || at.z() <= setting_.surface_mm(at.x(), at.y());
    return subject + (touches ? " 1" : " 0");
  }
  if (subject == "ERROR") {
    return "ERROR " + (error_.empty() ? "OK" : std::exchange(error_, std::string()));
  }
  return "GET " + subject + " NAK\r\n";
}

void FakeLinuxCnc::mdi(const std::string& line) {
  lines_.push_back(line);
  if (mode != "MDI") {
    error_ = "Must be in MDI mode to issue MDI command";
    return;
  }
  std::istringstream words(line);
  Eigen::Vector3d to = now();
  bool is_machine = false;
  bool is_probing = false;
  double feed_mm_min = 0;
  for (std::string word; words >> word;) {
    if (word == "G90") is_relative_ = false;
    if (word == "G91") is_relative_ = true;
    if (word == "G20" || word == "G21") mm_per_word_ = word == "G20" ? 25.4 : 1;
    if (word == "G53") is_machine = true;
    if (word == "G38.3") is_probing = true;
    const std::size_t axis = std::string_view("XYZ").find(word.front());
    if (word.front() == 'F') feed_mm_min = std::strtod(word.c_str() + 1, nullptr) * mm_per_word_;
    if (axis == std::string_view::npos) continue;
    constexpr std::string_view kReadBack = "[#5063-#5422+";
    double value_mm = 0;
    if (const auto at = word.find(kReadBack); at != std::string::npos) {
      const double current_mm = to.z() - kWork_mm;
      value_mm = touch_mm_ - kWork_mm - current_mm +
                 std::strtod(word.c_str() + at + kReadBack.size(), nullptr) * mm_per_word_;
    } else {
      value_mm = std::strtod(word.c_str() + 1, nullptr) * mm_per_word_;
    }
    const auto i = static_cast<Eigen::Index>(axis);
    to[i] = is_relative_ ? to[i] + value_mm : value_mm;
  }
  if (is_machine && is_relative_) {
    error_ = "Cannot use g53 incremental";
  } else if (to.cwiseAbs().maxCoeff() > kTravel_mm) {
    error_ = "Linear move on line 0 would exceed X's positive limit";
  } else if (is_probing) {
    const double surface_mm = setting_.surface_mm(to.x(), to.y());
    const bool trips = probe_is_stuck || surface_mm >= to.z();
    touch_mm_ = probe_is_stuck ? now().z() - 0.001 : surface_mm;
    if (trips) to.z() = touch_mm_ - kOvershoot_mm;
    start(to, std::min(0.05, (now() - to).norm() / feed_mm_min * 60), trips);
  } else {
    start(to, (now() - to).norm() / kSpeed_mm_s, false);
  }
}

void FakeLinuxCnc::start(const Eigen::Vector3d& to, double duration_s, bool trips) {
  const Eigen::Vector3d from = now();
  was_low_ = was_low_ || (std::min(from.z(), to.z()) < kLow_mm &&
                          (from - to).head<2>().cwiseAbs().maxCoeff() > 1e-6);
  ++n_moves_;
  motion_ = {from, to, Clock::now(), is_held_ ? 1e9 : duration_s, trips};
}

Eigen::Vector3d FakeLinuxCnc::now() const {
  const std::chrono::duration<double> passed = Clock::now() - motion_.start;
  if (passed.count() >= motion_.duration_s) return motion_.to;
  return motion_.from + (motion_.to - motion_.from) * (passed.count() / motion_.duration_s);
}

bool FakeLinuxCnc::is_moving() const {
  return std::chrono::duration<double>(Clock::now() - motion_.start).count() < motion_.duration_s;
}

void FakeLinuxCnc::halt() {
  motion_ = {now(), now(), Clock::now(), 0, motion_.trips && !is_moving()};
  motion_.from = motion_.to;
}

Eigen::Vector3d FakeLinuxCnc::place_mm() {
  const std::lock_guard lock(mutex_);
  return now();
}

bool FakeLinuxCnc::moves() {
  const std::lock_guard lock(mutex_);
  return is_moving() && !is_held_;
}

std::vector<std::string> FakeLinuxCnc::lines() {
  const std::lock_guard lock(mutex_);
  return lines_;
}

bool FakeLinuxCnc::was_low_in_xy() {
  const std::lock_guard lock(mutex_);
  return was_low_;
}

void FakeLinuxCnc::set(const std::function<void(FakeLinuxCnc&)>& change) {
  const std::lock_guard lock(mutex_);
  change(*this);
}

}  // namespace panelcal::test
