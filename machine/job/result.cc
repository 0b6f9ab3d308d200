// SPDX-License-Identifier: Apache-2.0
#include "machine/job/result.h"

#include <algorithm>

namespace panelcal {

Diagnostic JobResult::refusal() const {
  const auto is_error = [](const Diagnostic& diagnostic) {
    return diagnostic.severity() == Severity::Error;
  };
  const auto is_no_limit = [&](const Diagnostic& diagnostic) {
    return is_error(diagnostic) && info(diagnostic.code).fault != Fault::Gate;
  };
  const auto kept = log.kept();
  auto found = std::ranges::find_if(kept, is_no_limit);
  if (found == kept.end()) found = std::ranges::find_if(kept, is_error);
  if (found != kept.end()) return *found;
  return {Code::Internal, {}, "the job was not executed", ""};
}

}  // namespace panelcal
