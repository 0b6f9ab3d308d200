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

EventStream::EventStream(Announcer& announcer, Controls& controls, std::function<bool()> may_look)
    : announcer_(announcer), controls_(controls), may_look_(std::move(may_look)) {
}

std::shared_ptr<EventStream> EventStream::open(Announcer& announcer,
                                               Controls& controls,
                                               const std::string& stream,
                                               std::function<bool()> may_look) {
  std::shared_ptr<EventStream> opened(new EventStream(announcer, controls, std::move(may_look)));
  opened->is_counted_ = announcer.add_screen();
  if (!opened->is_counted_) return nullptr;
  opened->number_ = controls.open_stream(stream, std::chrono::steady_clock::now());
  if (opened->number_ != 0) announcer.announce_controls();
  return opened;
}

EventStream::~EventStream() {
  if (!is_counted_) return;
  controls_.close_stream(number_, std::chrono::steady_clock::now());
  announcer_.remove_screen();
}

std::string EventStream::controls_event() const {
  const std::string holder = controls_.holder();
  facts::Json document;
  document["controls"]["held_by"] = holder.empty() ? facts::Json() : facts::Json(holder);
  document["controls"]["mine"] = controls_.is_mine(number_);
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
  if (news.is_over || !may_look_()) return std::nullopt;
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
