// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/desk.h"

namespace panelcal::internal {

ShownState Desk::state() const {
  const std::scoped_lock lock(mutex_);
  if (text_.number != number_) {
    text_ = {number_, to_json(screen_)};
    text_.json.pop_back();  // its line end: events are lines
  }
  return text_;
}

void Desk::wait(std::uint64_t state_number,
                std::uint64_t frame_number,
                std::chrono::milliseconds at_most) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, at_most, [&] {
    const std::uint64_t frame = frame_ ? frame_->number : 0;
    return number_ > state_number || frame > frame_number || is_closing_;
  });
}

std::shared_ptr<const Frame> Desk::frame() const {
  const std::scoped_lock lock(mutex_);
  return frame_;
}

void Desk::set_watched(bool is_watched) {
  const std::scoped_lock lock(mutex_);
  is_watched_ = is_watched;
  told_.notify_all();
}

bool Desk::is_watched() const {
  const std::scoped_lock lock(mutex_);
  return is_watched_;
}

void Desk::show(std::string jpeg, ScreenView view) {
  const std::scoped_lock lock(mutex_);
  auto frame = std::make_shared<Frame>();
  frame->number = ++screen_.frame;
  frame->jpeg = std::move(jpeg);
  frame_ = std::move(frame);
  screen_.view = std::move(view);
  note_change();
}

void Desk::close() {
  const std::scoped_lock lock(mutex_);
  is_closing_ = true;
  changed_.notify_all();
  told_.notify_all();
}

std::optional<Command> Desk::wait_for_work(std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  told_.wait_for(lock, at_most, [&] { return work_ || is_closing_; });
  if (is_closing_) return std::nullopt;
  return std::exchange(work_, std::nullopt);
}

bool Desk::is_closing() const {
  const std::scoped_lock lock(mutex_);
  return is_closing_;
}

Desk::Word Desk::wait_for_word(std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  told_.wait_for(lock, at_most, [&] { return answer_ || jog_mm_ || wants_stop_ || is_closing_; });
  Word word;
  word.must_stop = wants_stop_ || is_closing_;
  word.jog_mm = std::exchange(jog_mm_, std::nullopt);
  word.answer = std::exchange(answer_, std::nullopt);
  return word;
}

bool Desk::must_stop() const {
  const std::scoped_lock lock(mutex_);
  return wants_stop_ || is_closing_;
}

bool Desk::is_stopped_by_person() const {
  const std::scoped_lock lock(mutex_);
  return wants_stop_;
}

}  // namespace panelcal::internal
