// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/login.h"

#include "tools/serve/access/secret.h"

namespace panelcal::serve {
namespace {

/// Sessions are kept hashed: what is compared then tells nothing about them.
std::string session_hash(std::string_view session) {
  return salted_hash("session", session);
}

}  // namespace

Login::Answer Login::log_in(std::string_view token, const std::string& address, Now now) {
  const std::lock_guard lock(mutex_);
  if (!token_.is(token)) {
    const auto wait = attempts_.wait_of(address, now);
    attempts_.note_wrong(address, now);
    return {"", wait};
  }
  Answer answer{random_secret(), {}};
  sessions_.push_back({session_hash(answer.session), now});
  if (sessions_.size() > kMaxSessions) sessions_.pop_front();
  return answer;
}

void Login::log_out(std::string_view session) {
  const std::string hash = session_hash(session);
  const std::lock_guard lock(mutex_);
  std::erase_if(sessions_,
                [&](const Session& known) { return is_equal_in_constant_time(known.hash, hash); });
}

bool Login::is_session(std::string_view session, Now now) {
  if (session.empty()) return false;
  const std::string hash = session_hash(session);
  const std::lock_guard lock(mutex_);
  while (!sessions_.empty() && now - sessions_.front().since >= kSessionLength) {
    sessions_.pop_front();
  }
  bool is_known = false;
  for (const Session& known : sessions_) {
    if (is_equal_in_constant_time(known.hash, hash)) is_known = true;
  }
  return is_known;
}

}  // namespace panelcal::serve
