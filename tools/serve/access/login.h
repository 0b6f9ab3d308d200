// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "tools/serve/access/attempts.h"
#include "tools/serve/access/token_file.h"

namespace panelcal::serve {

/// Screens that have shown the token. Thread-safe.
class Login {
 public:
  /// A working day: who left a screen open has to log in on the next one.
  static constexpr std::chrono::hours kSessionLength{12};

  explicit Login(Token token, AttemptLimits limits = {})
      : token_(std::move(token)), attempts_(limits) {}

  struct Answer {
    std::string session;           ///< empty: refused
    std::chrono::seconds wait{0};  ///< above zero: too many wrong tokens
  };
  /// The right token always passes: otherwise strangers who guess could lock its owner out, from
  /// behind the same proxy for ever. Wrong ones beyond the limits are answered late.
  Answer log_in(std::string_view token, const std::string& address, Now now);
  bool is_session(std::string_view session, Now now);
  void log_out(std::string_view session);

 private:
  struct Session {
    std::string hash;
    Now since;
  };
  static constexpr std::size_t kMaxSessions = 200;

  std::mutex mutex_;
  Token token_;
  Attempts attempts_;
  std::deque<Session> sessions_;  ///< oldest first
};

}  // namespace panelcal::serve
