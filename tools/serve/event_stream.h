// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tools/serve/access/controls.h"
#include "tools/serve/announcer.h"
#include "tools/serve/http/message.h"

namespace panelcal::serve {

/// Server-sent events of one screen: `state` with the document, `frame` with the number of a new
/// picture, `controls` with their holder. A screen that is slow gets the newest only.
class EventStream final : public EventSource {
 public:
  /// The document is sent no more often.
  static constexpr std::chrono::milliseconds kStateInterval{100};
  /// Something is sent at least this often, so that a screen notices a lost connection.
  static constexpr std::chrono::milliseconds kSignOfLife{5000};

  /// In     stream: the part of the controls' key that names it, or empty; may_look: false ends it
  /// Out    null: there are too many screens
  static std::shared_ptr<EventStream> open(Announcer& announcer,
                                           Controls& controls,
                                           const std::string& stream,
                                           std::function<bool()> may_look);
  EventStream(const EventStream&) = delete;
  EventStream& operator=(const EventStream&) = delete;
  ~EventStream() override;

  std::optional<std::string> next(std::chrono::milliseconds at_most) override;

 private:
  EventStream(Announcer& announcer, Controls& controls, std::function<bool()> may_look);
  std::string controls_event() const;

  Announcer& announcer_;
  Controls& controls_;
  std::function<bool()> may_look_;
  std::uint64_t number_ = 0;  ///< of the holder of the controls; 0: of another screen
  bool is_counted_ = false;
  Announcer::News seen_;
  Now last_state_{};
  Now last_sent_{};
};

}  // namespace panelcal::serve
