// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/event_stream.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "calib/base/json/facts.h"
#include <fmt/format.h>

namespace panelcal::serve {
namespace {

/// As the living standard of HTML has it ("Server-sent events"): each line of the data behind
/// `data: `, an empty line at the end.
std::string event_text(std::string_view name, std::string_view data) {
  std::string text = fmt::format("event: {}\n", name);
  while (!data.empty()) {
    const std::size_t end = std::min(data.find_first_of("\r\n"), data.size());
    if (end > 0) text += fmt::format("data: {}\n", data.substr(0, end));
    data.remove_prefix(std::min(end + 1, data.size()));
  }
  return text + "\n";
}

}  // namespace

EventStream::EventStream(Announcer& announcer, Controls& controls, std::string key)
    : announcer_(announcer), controls_(controls), key_(std::move(key)) {
}

std::shared_ptr<EventStream> EventStream::open(Announcer& announcer,
                                               Controls& controls,
                                               std::string key) {
  if (!announcer.add_screen()) return nullptr;
  controls.open_stream(key, std::chrono::steady_clock::now());
  return std::shared_ptr<EventStream>(new EventStream(announcer, controls, std::move(key)));
}

EventStream::~EventStream() {
  controls_.close_stream(key_, std::chrono::steady_clock::now());
  announcer_.remove_screen();
}

std::string EventStream::controls_event() const {
  const std::string holder = controls_.holder();
  facts::Json document;
  document["controls"]["held_by"] = holder.empty() ? facts::Json() : facts::Json(holder);
  document["controls"]["mine"] = controls_.is_held_by(key_);
  return event_text("controls", facts::text(document));
}

std::optional<std::string> EventStream::next(std::chrono::milliseconds at_most) {
  Announcer::News news = announcer_.wait(
      seen_,
      std::min(std::chrono::steady_clock::now() + at_most,
               std::max(last_sent_ + kSignOfLife, std::chrono::steady_clock::now())));
  if (news.state_number != seen_.state_number || seen_.state == nullptr) {
    announcer_.pause(last_state_ + kStateInterval);
    news = announcer_.latest();
  }
  if (news.is_over) return std::nullopt;
  const Now now = std::chrono::steady_clock::now();
  std::string text;
  if (news.controls_number != seen_.controls_number || now - last_sent_ >= kSignOfLife) {
    text += controls_event();
  }
  if (news.state_number != seen_.state_number || seen_.state == nullptr) {
    text += event_text("state", *news.state);
    last_state_ = now;
  }
  if (news.picture_number != seen_.picture_number) {
    text += event_text("frame", fmt::format("{{\"number\":{}}}", news.picture_number));
  }
  if (!text.empty()) last_sent_ = now;
  seen_ = std::move(news);
  return text;
}

}  // namespace panelcal::serve
