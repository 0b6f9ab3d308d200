// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "machine/operator/command.h"
#include "machine/operator/screen.h"
#include "machine/operator/shown_state.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Everything that the people at the screens and the machine thread share: the screen's document,
/// the last picture, and orders of the people.
///
/// All methods may be called from any thread; wait_for_work() and wait_for_word() are the machine
/// thread's.
class Desk {
 public:
  explicit Desk(Screen screen) : screen_(std::move(screen)) {}

  ShownState state() const;
  void wait(std::uint64_t state_number,
            std::uint64_t frame_number,
            std::chrono::milliseconds at_most) const;
  std::shared_ptr<const Frame> frame() const;
  void set_watched(bool is_watched);
  bool is_watched() const;

  /// Changes the document by a function of Screen&.
  template <class Change>
  void change(Change&& function) {
    const std::scoped_lock lock(mutex_);
    function(screen_);
    note_change();
  }
  /// The same by a function that may refuse, and then has changed nothing.
  template <class Change>
  Expected<void> try_change(Change&& function) {
    const std::scoped_lock lock(mutex_);
    PANELCAL_CHECK(function(screen_));
    note_change();
    return {};
  }
  template <class Read>
  auto read(Read&& function) const {
    const std::scoped_lock lock(mutex_);
    return function(screen_);
  }
  /// The last picture, and what it shows.
  void show(std::string jpeg, ScreenView view);

  // What people tell the machine thread. Of these, the first three only from within a
  // try_change(), so that what is told suits the screen.
  void give_work(Command command) {
    // Words to another job are forgotten.
    answer_.reset();
    jog_mm_.reset();
    wants_stop_ = false;
    work_ = std::move(command);
  }
  void answer(Answer answer) { answer_ = std::move(answer); }
  void jog(const Eigen::Vector2d& by_mm) {
    jog_mm_ = jog_mm_.value_or(Eigen::Vector2d(0, 0)) + by_mm;
  }
  void stop() { wants_stop_ = true; }
  /// The station closes: the machine thread is to end.
  void close();

  /// Work for the machine thread, or nothing when the time is over or the station closes.
  std::optional<Command> wait_for_work(std::chrono::milliseconds at_most);
  bool is_closing() const;

  /// A word of a person while a question is open.
  struct Word {
    std::optional<Answer> answer;
    std::optional<Eigen::Vector2d> jog_mm;
    bool must_stop = false;  ///< a person says so, or the station closes
  };
  Word wait_for_word(std::chrono::milliseconds at_most);
  /// A person has stopped the job, or the station closes.
  bool must_stop() const;
  bool is_stopped_by_person() const;

 private:
  void note_change() {
    ++number_;
    changed_.notify_all();
    told_.notify_all();
  }

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;  ///< the document or the picture
  std::condition_variable told_;             ///< something for the machine thread
  Screen screen_;
  std::uint64_t number_ = 1;
  mutable ShownState text_;  ///< of the document when its number was that
  std::shared_ptr<const Frame> frame_;
  bool is_watched_ = false;

  std::optional<Command> work_;
  std::optional<Answer> answer_;
  std::optional<Eigen::Vector2d> jog_mm_;
  bool wants_stop_ = false;
  bool is_closing_ = false;
};

}  // namespace panelcal::internal
