// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "calib/base/expected.h"

namespace panelcal::serve {

/// All that screens can do with a machine. In the program the station of machine/operator, in tests
/// one that only notes what it was asked. Called from many threads at once.
class ServedMachine {
 public:
  struct State {
    std::uint64_t number = 0;  ///< grows with each change
    std::string json;          ///< the document "screen" (share/schema/screen.schema.json)
  };
  struct Picture {
    std::uint64_t number = 0;  ///< 0: there is none yet
    std::string jpeg;
  };

  virtual ~ServedMachine() = default;
  virtual State state() const = 0;
  virtual Picture picture() const = 0;
  virtual std::uint64_t picture_number() const = 0;
  /// Returns when state or picture are newer than these, or the time is over.
  virtual void wait(std::uint64_t state_number,
                    std::uint64_t picture_number,
                    std::chrono::milliseconds at_most) const = 0;
  /// Live pictures are taken only while a screen looks.
  virtual void set_watched(bool is_watched) = 0;
  /// In     json: an object, at most 16 levels deep; who: the holder of the controls
  virtual Expected<void> command(std::string_view json, const std::string& who) = 0;
  virtual Expected<void> add_program(const std::string& name, std::string_view bytes) = 0;
  /// In     job_id, name: of the signs and the list that Service allows
  virtual Expected<std::string> job_file(const std::string& job_id,
                                         const std::string& name) const = 0;
};

}  // namespace panelcal::serve
