// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "tools/serve/access/controls.h"
#include "tools/serve/served_machine.h"

namespace panelcal::serve {

/// Tells all screens what is new: one thread asks the machine, however many screens there are, and
/// the document is copied once. Thread-safe.
class Announcer {
 public:
  static constexpr std::size_t kMaxScreens = 64;

  struct News {
    std::uint64_t state_number = 0;
    std::shared_ptr<const std::string> state;
    std::uint64_t picture_number = 0;
    std::uint64_t controls_number = 0;
    bool is_over = false;  ///< the server ends
  };

  Announcer(ServedMachine& machine, Controls& controls);
  Announcer(const Announcer&) = delete;
  Announcer& operator=(const Announcer&) = delete;
  ~Announcer();

  News latest() const;
  /// Returns at once if there is something newer than `seen`, and else when there is, or at
  /// `until`.
  News wait(const News& seen, Now until) const;
  /// Returns at `until`, or when the server ends.
  void pause(Now until) const;
  /// The controls have changed hands.
  void announce_controls();
  /// False: there are too many already.
  bool add_screen();
  void remove_screen();
  /// Ends all streams.
  void end();

 private:
  void follow();
  void look();

  ServedMachine& machine_;
  Controls& controls_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  News news_;
  std::size_t n_screens_ = 0;
  std::thread thread_;  ///< last: it uses all others
};

}  // namespace panelcal::serve
