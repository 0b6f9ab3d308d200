// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "program/model/measurement.h"
#include "program/walk/probing.h"

// What recorded measurements and recorded probe readings have in common.
namespace panelcal::internal {

/// The properties by which a recorded request is the program's.
struct RequestIdentity {
  std::string_view command;
  PatternFile pattern;
  int line = 0;
  std::string_view tool_words;  ///< "vision tool", "tool"
  int tool = 0;
  const InstancePath& path;
  Position<frame::Nominal> nominal;
};

RequestIdentity identity(const MeasurementRequest& request);
RequestIdentity identity(const ProbeRequest& request);

/// A number without answer: "seq 7", and what was expected: "a measurement for G35 target 7".
Diagnostic missing_answer(const std::string& file, std::string number, std::string wanted);
/// An answer in that line of a file that no request asks for.
Diagnostic unused_answer(const std::string& file, int line, const std::string& request);
/// Nothing where a recorded request is the program's.
std::optional<Diagnostic> other_request(const RequestIdentity& recorded,
                                        const RequestIdentity& requested,
                                        const std::string& number,
                                        const Place& place);

/// Recorded answers, and which of them a program has asked for.
template <class Answer>
class RecordedAnswers {
 public:
  struct Entry {
    Answer answer;
    int line = 0;  ///< in the file
  };

  /// In     kind: how messages call the number of a request: "seq", "probe"
  RecordedAnswers(std::string file, std::string_view kind, std::vector<Entry> entries)
      : file_(std::move(file)), kind_(kind), entries_(std::move(entries)) {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      uses_.emplace(entries_[i].answer.request.seq, Use{i, false});
    }
  }

  /// The answer to a request of the program.
  ///
  /// In     wanted: "a measurement", as messages call an answer
  /// Fails  measurement-missing; measurement-mismatch (it was recorded for another request)
  template <class Request>
  Expected<Answer> answer(const Request& request, std::string_view wanted) {
    const std::string number = kind_ + " " + std::to_string(request.seq);
    const auto found = uses_.find(request.seq);
    if (found == uses_.end()) {
      return failure(
          missing_answer(file_, number, std::string(wanted) + " for " + describe(request)));
    }
    const Entry& entry = entries_[found->second.index];
    const Place place{file_, entry.line, 1};
    if (auto other =
            other_request(identity(entry.answer.request), identity(request), number, place)) {
      return failure(std::move(*other));
    }
    found->second.is_used = true;
    Answer answer = entry.answer;
    answer.request = request;
    return answer;
  }

  /// Fails  measurement-mismatch, at the first answer that the program has not asked for
  Expected<void> check_all_used() const {
    for (const Entry& entry : entries_) {
      const auto& request = entry.answer.request;
      if (!uses_.at(request.seq).is_used) {
        return failure(unused_answer(file_, entry.line, describe(request)));
      }
    }
    return {};
  }

 private:
  struct Use {
    std::size_t index = 0;
    bool is_used = false;
  };

  std::string file_;
  std::string kind_;
  std::vector<Entry> entries_;
  std::map<std::int64_t, Use> uses_;
};

}  // namespace panelcal::internal
