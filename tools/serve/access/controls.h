// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "tools/serve/access/attempts.h"

namespace panelcal::serve {

/// The right to give commands, which one screen has, or none. It proves itself by a key,
/// SECRET.STREAM, of which the second part names its stream of events and gives no right: it stands
/// in an address, which proxies write down. Thread-safe.
class Controls {
 public:
  /// Controls whose screen shows no sign of life for this long are free: longer than a reload
  /// takes.
  static constexpr std::chrono::seconds kGrace{15};

  struct Wish {
    std::string name;
    std::string key;   ///< of this screen, if it has one
    std::string from;  ///< the holder whom they shall be taken from; may be empty
  };
  /// The key: a new one, or the own one of who holds them already. Nothing: another holds them.
  std::optional<std::string> take(const Wish& wish, Now now);
  /// False: this key does not hold them.
  bool give_back(std::string_view key);

  /// Calls `act` with the holder's name if the key is theirs, which is a sign of life. Until it
  /// returns, the controls change hands for no one: nothing acts for who has lost them.
  Expected<void> while_held(std::string_view key,
                            Now now,
                            const std::function<Expected<void>(const std::string& name)>& act);
  bool is_held_by(std::string_view key) const;
  /// The name of the holder; empty: the controls are free.
  std::string holder() const;
  /// Grows with each change of the holder.
  std::uint64_t number() const;

  /// A stream of events begins. The number of the holder's, of others 0.
  std::uint64_t open_stream(std::string_view stream, Now now);
  void close_stream(std::uint64_t number, Now now);
  /// True of the newest stream of the holder: of a screen that was duplicated, one has the
  /// controls.
  bool is_mine(std::uint64_t stream_number) const;
  /// Frees what shows no sign of life; true: the holder changed.
  bool expire(Now now);

 private:
  bool is_own(std::string_view key) const;
  void free();

  std::mutex acting_;  ///< held while a command acts; locked before the other one
  mutable std::mutex mutex_;
  std::string key_;  ///< empty: free
  std::string name_;
  Now last_sign_{};
  std::vector<std::uint64_t> streams_;  ///< of the holder, oldest first
  std::uint64_t next_stream_ = 1;
  std::uint64_t number_ = 1;
};

}  // namespace panelcal::serve
