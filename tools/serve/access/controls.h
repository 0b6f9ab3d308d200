// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "tools/serve/access/attempts.h"

namespace panelcal::serve {

/// Who may give commands: one screen, or none. It proves itself by a key. Thread-safe.
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

  /// The holder's name if the key is theirs, which is a sign of life.
  std::optional<std::string> use(std::string_view key, Now now);
  bool is_held_by(std::string_view key) const;
  /// The name of the holder; empty: the controls are free.
  std::string holder() const;
  /// Grows with each change of the holder.
  std::uint64_t number() const;

  /// A stream of events of a screen with this key begins or ends.
  void open_stream(std::string_view key, Now now);
  void close_stream(std::string_view key, Now now);
  /// Frees what shows no sign of life; true: the holder changed.
  bool expire(Now now);

 private:
  bool is_own(std::string_view key) const;
  void free();

  mutable std::mutex mutex_;
  std::string key_;  ///< empty: free
  std::string name_;
  Now last_sign_{};
  int n_streams_ = 0;  ///< of the holder
  std::uint64_t number_ = 1;
};

}  // namespace panelcal::serve
