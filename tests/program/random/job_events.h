// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "program/model/operation.h"

namespace panelcal::test {

/// Accuracy that a plain Excellon program promises (issue 3).
inline constexpr double kWritten_mm = 1e-4;
/// Twice the last digit that the writer writes, in x and y.
inline constexpr double kLastDigit_mm = 3e-6;
/// Rates are written as whole numbers, in the header's unit; the control's own is 42.33 mm/s.
inline constexpr double kWholeFeed_mm_s = 0.5;

/// An operation with a copy of what a sink sees only for a moment.
struct Event {
  int line = 0;
  decltype(Operation::what) what;
  std::string text;
};

/// Remembers everything, and passes it on if a sink waits for it.
class EventRecorder final : public OperationSink {
 public:
  explicit EventRecorder(OperationSink* next = nullptr) : next_(next) {}

  void begin(const ProgramInfo& info) override {
    if (next_ != nullptr) next_->begin(info);
  }
  void put(const Operation& operation) override {
    Event event{operation.line, operation.what, {}};
    if (const auto* message = std::get_if<Message>(&event.what)) event.text = message->text;
    if (const auto* function = std::get_if<Function>(&event.what)) event.text = function->text;
    if (const auto* setting = std::get_if<Setting>(&event.what)) event.text = setting->text;
    events_.push_back(std::move(event));
    if (next_ != nullptr) next_->put(operation);
  }
  std::vector<Event>& events() { return events_; }

 private:
  OperationSink* next_;
  std::vector<Event> events_;
};

/// Greatest differences of operations that count as the same.
struct Tolerance {
  double place_mm = kLastDigit_mm;
  double center_mm = kWritten_mm;
  double rate_mm_s = 1e-6;
};

/// Without what a writer says in its own way: the header's settings, modes, and scaling, which may
/// be in the places already.
std::vector<Event> essence_of(const std::vector<Event>& events);

/// The first difference, in words; empty if there is none that a written program keeps. The centre
/// of a nearly straight arc is far away and says little: there the middles of the arcs count.
std::string difference(const std::vector<Event>& a,
                       const std::vector<Event>& b,
                       Tolerance tolerance = {});

}  // namespace panelcal::test
