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
  n_streams_ = 0;
  ++number_;
}

std::optional<std::string> Controls::take(const Wish& wish, Now now) {
  const std::lock_guard lock(mutex_);
  const bool is_holder = is_own(wish.key);
  if (!key_.empty() && !is_holder && (wish.from.empty() || wish.from != name_)) {
    return std::nullopt;
  }
  if (!is_holder) {
    free();
    key_ = random_secret();
  }
  name_ = wish.name;
  last_sign_ = now;
  ++number_;
  return key_;
}

bool Controls::give_back(std::string_view key) {
  const std::lock_guard lock(mutex_);
  if (!is_own(key)) return false;
  free();
  return true;
}

std::optional<std::string> Controls::use(std::string_view key, Now now) {
  const std::lock_guard lock(mutex_);
  if (!is_own(key)) return std::nullopt;
  last_sign_ = now;
  return name_;
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

void Controls::open_stream(std::string_view key, Now now) {
  const std::lock_guard lock(mutex_);
  if (!is_own(key)) return;
  ++n_streams_;
  last_sign_ = now;
}

void Controls::close_stream(std::string_view key, Now now) {
  const std::lock_guard lock(mutex_);
  if (!is_own(key) || n_streams_ == 0) return;
  --n_streams_;
  last_sign_ = now;
}

bool Controls::expire(Now now) {
  const std::lock_guard lock(mutex_);
  if (key_.empty() || n_streams_ > 0 || now - last_sign_ < kGrace) return false;
  free();
  return true;
}

}  // namespace panelcal::serve
