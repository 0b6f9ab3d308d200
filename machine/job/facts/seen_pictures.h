// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "machine/job/facts/input.h"
#include "machine/look/vision_procedure.h"

namespace panelcal {

/// The pictures of a job, as its facts show them, by the number of the request.
struct SeenPictures {
  std::map<std::int64_t, std::vector<SeenPicture>> by_seq;
  bool cuts_out = true;  ///< keeps the piece of each picture that shows the target

  /// Keeps what is seen here. Precondition: this outlives it
  PictureObserver observer();
};

}  // namespace panelcal
