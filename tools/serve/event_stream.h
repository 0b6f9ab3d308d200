// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
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

  /// Null: there are too many screens.
  static std::shared_ptr<EventStream> open(Announcer& announcer,
                                           Controls& controls,
                                           std::string key);
  EventStream(const EventStream&) = delete;
  EventStream& operator=(const EventStream&) = delete;
  ~EventStream() override;

  std::optional<std::string> next(std::chrono::milliseconds at_most) override;

 private:
  EventStream(Announcer& announcer, Controls& controls, std::string key);
  std::string controls_event() const;

  Announcer& announcer_;
  Controls& controls_;
  std::string key_;
  Announcer::News seen_;
  Now last_state_{};
  Now last_sent_{};
};

}  // namespace panelcal::serve
