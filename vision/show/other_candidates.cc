// SPDX-License-Identifier: Apache-2.0
#include "vision/show/other_candidates.h"

namespace panelcal {

std::span<const Candidate> other_candidates(const Detection& detection) {
  const std::span<const Candidate> all = detection.candidates;
  const bool is_first_the_answer = detection.status == DetectionStatus::Found && detection.best &&
                                   !all.empty() &&
                                   all.front().center == detection.best->center.position;
  return is_first_the_answer ? all.subspan(1) : all;
}

}  // namespace panelcal
