// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/linuxcnc/session.h"

#include <algorithm>
#include <chrono>
#include <optional>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::string_view kEchoOff = "set echo off";
constexpr int kUsualPort = 5007;
const Time kLongestConnect = seconds(5);
const Time kLongestAnswer = seconds(5);
/// linuxcncrsh listens before the rest of LinuxCNC has started.
const Time kLongestGreeting = seconds(15);

std::string upper(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
  });
  return out;
}

std::string_view without_line_ends(std::string_view text) {
  while (!text.empty() && (text.front() == '\r' || text.front() == ' ')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
  return text;
}

std::string_view first_word(std::string_view text) {
  return text.substr(0, text.find(' '));
}

/// "hello" and "set enable" have theirs behind the word.
std::string_view without_passwords(std::string_view order) {
  constexpr std::string_view kEnable = "set enable";
  if (order.starts_with("hello")) return "hello";
  return order.starts_with(kEnable) ? kEnable : order;
}

}  // namespace

LinuxCncSession::LinuxCncSession(std::unique_ptr<LineLink> link)
    : link_(std::move(link)), longest_answer_(kLongestGreeting) {
}

Expected<std::unique_ptr<LinuxCncSession>> LinuxCncSession::open(const ControlSetting& setting,
                                                                 bool heeds_signals) {
  PANELCAL_TRY(std::unique_ptr<LineLink> link,
               LineLink::tcp(setting.host.empty() ? "127.0.0.1" : setting.host,
                             setting.port == 0 ? kUsualPort : setting.port,
                             kLongestConnect,
                             heeds_signals));
  std::unique_ptr<LinuxCncSession> session(new LinuxCncSession(std::move(link)));
  session->heeds_signals_ = heeds_signals;
  PANELCAL_CHECK(session->greet(setting));
  return session;
}

Expected<void> LinuxCncSession::greet(const ControlSetting& setting) {
  const auto refuse = [&](std::string what, std::string expected) {
    return failure({Code::DeviceStage, {name(), 0, 0}, std::move(what), std::move(expected)});
  };
  PANELCAL_TRY(const std::string hello,
               answer_to("hello " + setting.connect_password + " panelcal 1.0"));
  if (hello == "HELLO NAK") {
    return refuse("linuxcncrsh refuses the password of the connection",
                  "[machine] connect_password as linuxcncrsh --connectpw has it");
  }
  if (!hello.starts_with("HELLO ACK")) return failure(odd_answer("hello", hello));
  longest_answer_ = kLongestAnswer;
  // Without an answer of its own; `verbose` brings an answer to each order.
  PANELCAL_CHECK(link_->send(std::string(kEchoOff) + "\r\n"));
  PANELCAL_TRY(const std::string verbose, answer_to("set verbose on"));
  if (verbose != "SET VERBOSE ACK") return failure(odd_answer("set verbose on", verbose));
  PANELCAL_TRY(const bool is_enabled, set("enable " + setting.enable_password));
  if (!is_enabled) {
    return refuse("linuxcncrsh refuses the password that enables control",
                  "[machine] enable_password as linuxcncrsh --enablepw has it");
  }
  return {};
}

Diagnostic LinuxCncSession::odd_answer(const std::string& order, const std::string& answer) {
  is_broken_ = true;
  return {Code::DeviceStage,
          {name(), 0, 0},
          fmt::format("answers {} to {}", quoted(answer), quoted(without_passwords(order))),
          "linuxcncrsh of LinuxCNC, and nothing between that changes its answers"};
}

Expected<std::string> LinuxCncSession::next_answer(const std::string& order) {
  const auto until =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(longest_answer_.in_s());
  for (;;) {
    const std::chrono::duration<double> left = until - std::chrono::steady_clock::now();
    const Time within = seconds(std::max(left.count(), 0.0));
    auto line = link_->line(within, heeds_signals_);
    if (!line) {
      (line.error().code == Code::Interrupted ? owes_answer_ : is_broken_) = true;
      return failure(std::move(line).error());
    }
    if (!*line) {
      is_broken_ = true;
      return failure({Code::DeviceStage,
                      {name(), 0, 0},
                      fmt::format("does not answer {} within {:g} s",
                                  quoted(without_passwords(order)),
                                  longest_answer_.in_s()),
                      "a LinuxCNC that runs and a network that works"});
    }
    const std::string_view text = without_line_ends(**line);
    if (text.empty() || text == order || text == kEchoOff) continue;
    if (!owes_answer_) return std::string(text);
    owes_answer_ = false;
  }
}

Expected<std::string> LinuxCncSession::answer_to(const std::string& order) {
  auto sent = link_->send(order + "\r\n");
  if (!sent) {
    is_broken_ = true;
    return failure(std::move(sent).error());
  }
  return next_answer(order);
}

Expected<std::string> LinuxCncSession::get(std::string_view subject) {
  const std::string order = "get " + std::string(subject);
  PANELCAL_TRY(const std::string answer, answer_to(order));
  const std::string expected = upper(first_word(subject)) + " ";
  if (!answer.starts_with(expected)) return failure(odd_answer(order, answer));
  return answer.substr(expected.size());
}

Expected<bool> LinuxCncSession::set(std::string_view order) {
  PANELCAL_TRY(const std::string answer, answer_to("set " + std::string(order)));
  const std::string expected = "SET " + upper(first_word(order)) + " ";
  if (answer == expected + "ACK") return true;
  if (answer == expected + "NAK") return false;
  return failure(odd_answer("set " + std::string(order), answer));
}

}  // namespace panelcal::internal
