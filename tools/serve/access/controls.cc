// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/controls.h"

#include "tools/serve/access/secret.h"

namespace panelcal::serve {

bool Controls::is_own(std::string_view key) const {
  return !key_.empty() && is_equal_in_constant_time(key_, key);
}

void Controls::free() {
  key_.clear();
  name_.clear();
  streams_.clear();
  ++number_;
}

std::optional<std::string> Controls::take(const Wish& wish, Now now) {
  const std::lock_guard after_commands(acting_);
  const std::lock_guard lock(mutex_);
  const bool is_holder = is_own(wish.key);
  if (!key_.empty() && !is_holder && (wish.from.empty() || wish.from != name_)) {
    return std::nullopt;
  }
  if (!is_holder) {
    free();
    key_ = random_secret() + "." + random_secret();
  }
  name_ = wish.name;
  last_sign_ = now;
  ++number_;
  return key_;
}

bool Controls::give_back(std::string_view key) {
  const std::lock_guard after_commands(acting_);
  const std::lock_guard lock(mutex_);
  if (!is_own(key)) return false;
  free();
  return true;
}

Expected<void> Controls::while_held(
    std::string_view key,
    Now now,
    const std::function<Expected<void>(const std::string& name)>& act) {
  const std::lock_guard acting(acting_);
  std::string name;
  {
    const std::lock_guard lock(mutex_);
    if (!is_own(key)) {
      return failure(
          {Code::Usage, {}, "controls held by another screen", "take the controls first"});
    }
    last_sign_ = now;
    name = name_;
  }
  return act(name);
}

bool Controls::is_held_by(std::string_view key) const {
  const std::lock_guard lock(mutex_);
  return is_own(key);
}

std::string Controls::holder() const {
  const std::lock_guard lock(mutex_);
  return name_;
}

std::uint64_t Controls::number() const {
  const std::lock_guard lock(mutex_);
  return number_;
}

std::uint64_t Controls::open_stream(std::string_view stream, Now now) {
  const std::lock_guard lock(mutex_);
  const std::size_t dot = key_.find('.');
  if (key_.empty() || !is_equal_in_constant_time(key_.substr(dot + 1), stream)) return 0;
  last_sign_ = now;
  streams_.push_back(next_stream_);
  ++number_;
  return next_stream_++;
}

void Controls::close_stream(std::uint64_t number, Now now) {
  const std::lock_guard lock(mutex_);
  if (std::erase(streams_, number) == 0) return;
  last_sign_ = now;
  ++number_;
}

bool Controls::is_mine(std::uint64_t stream_number) const {
  const std::lock_guard lock(mutex_);
  return !streams_.empty() && streams_.back() == stream_number;
}

bool Controls::expire(Now now) {
  // Who acts shows signs of life.
  const std::unique_lock after_commands(acting_, std::try_to_lock);
  if (!after_commands) return false;
  const std::lock_guard lock(mutex_);
  if (key_.empty() || !streams_.empty() || now - last_sign_ < kGrace) return false;
  free();
  return true;
}

}  // namespace panelcal::serve
