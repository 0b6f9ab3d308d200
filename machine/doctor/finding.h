// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/diagnostic.h"

namespace panelcal {

enum class FindingState : std::uint8_t {
  Ok,
  Warning,   ///< jobs and nights run, and a person should know
  Fails,     ///< a job or a night would fail or be held
  NotTried,  ///< the text says what would try it
};

/// "ok", "warning", "fails", "not tried".
constexpr std::string_view name(FindingState state) {
  switch (state) {
    case FindingState::Ok:
      return "ok";
    case FindingState::Warning:
      return "warning";
    case FindingState::Fails:
      return "fails";
    case FindingState::NotTried:
      return "not tried";
  }
  return "";
}

/// One line of an examination.
struct Finding {
  FindingState state = FindingState::Ok;
  std::string subject;  ///< "camera", "ledger", "tonight spindle-camera", ...
  std::string text;     ///< with its numbers
  std::string remedy;   ///< the mend, by a person; empty where nothing is to be done
};

/// All lines of an examination, in its order.
class Findings {
 public:
  void ok(std::string subject, std::string text) {
    add({FindingState::Ok, std::move(subject), std::move(text), {}});
  }
  void warn(std::string subject, std::string text, std::string remedy) {
    add({FindingState::Warning, std::move(subject), std::move(text), std::move(remedy)});
  }
  void fail(std::string subject, std::string text, std::string remedy) {
    add({FindingState::Fails, std::move(subject), std::move(text), std::move(remedy)});
  }
  void not_tried(std::string subject, std::string text, std::string remedy) {
    add({FindingState::NotTried, std::move(subject), std::move(text), std::move(remedy)});
  }
  /// An error fails, all others warn.
  void add(std::string subject, const Diagnostic& problem) {
    const bool is_error = problem.severity() == Severity::Error;
    add({is_error ? FindingState::Fails : FindingState::Warning,
         std::move(subject),
         problem.text(),
         {}});
  }

  const std::vector<Finding>& all() const { return all_; }
  int count(FindingState state) const {
    return static_cast<int>(std::ranges::count(all_, state, &Finding::state));
  }

 private:
  void add(Finding finding) { all_.push_back(std::move(finding)); }

  std::vector<Finding> all_;
};

}  // namespace panelcal
