// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/announcer.h"

#include <new>
#include <utility>

namespace panelcal::serve {

Announcer::Announcer(ServedMachine& machine, Controls& controls)
    : machine_(machine), controls_(controls) {
  look();
  thread_ = std::thread([this] { follow(); });
}

Announcer::~Announcer() {
  end();
  thread_.join();
}

void Announcer::look() {
  ServedMachine::State state = machine_.state();
  const std::uint64_t picture_number = machine_.picture_number();
  controls_.expire(std::chrono::steady_clock::now());
  const std::uint64_t controls_number = controls_.number();
  {
    const std::lock_guard lock(mutex_);
    if (news_.state == nullptr || state.number != news_.state_number) {
      news_.state_number = state.number;
      news_.state = std::make_shared<const std::string>(std::move(state.json));
    }
    news_.picture_number = picture_number;
    news_.controls_number = controls_number;
  }
  changed_.notify_all();
}

void Announcer::follow() {
  // Long enough to cost nothing, short enough that the end of the server does not wait for it.
  constexpr std::chrono::milliseconds kLook{250};
  for (News seen = latest(); !seen.is_over; seen = latest()) {
    machine_.wait(seen.state_number, seen.picture_number, kLook);
    try {
      look();
    } catch (const std::bad_alloc&) {
      // The next look may find the memory.
      pause(std::chrono::steady_clock::now() + kLook);
    }
  }
}

Announcer::News Announcer::latest() const {
  const std::lock_guard lock(mutex_);
  return news_;
}

Announcer::News Announcer::wait(const News& seen, Now until) const {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, until, [&] {
    return news_.is_over || news_.state_number != seen.state_number ||
           news_.picture_number != seen.picture_number ||
           news_.controls_number != seen.controls_number;
  });
  return news_;
}

void Announcer::pause(Now until) const {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, until, [&] { return news_.is_over; });
}

void Announcer::announce_controls() {
  const std::uint64_t number = controls_.number();
  {
    const std::lock_guard lock(mutex_);
    news_.controls_number = number;
  }
  changed_.notify_all();
}

bool Announcer::add_screen() {
  const std::lock_guard lock(mutex_);
  if (n_screens_ == kMaxScreens) return false;
  if (++n_screens_ == 1) machine_.set_watched(true);
  return true;
}

void Announcer::remove_screen() {
  const std::lock_guard lock(mutex_);
  if (--n_screens_ == 0) machine_.set_watched(false);
}

void Announcer::end() {
  {
    const std::lock_guard lock(mutex_);
    news_.is_over = true;
  }
  changed_.notify_all();
}

}  // namespace panelcal::serve
