// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "machine/look/vision_procedure.h"
#include "tools/report/input/views.h"

namespace panelcal {

/// The pictures of a job, as its report shows them, by the number of the request.
struct SeenPictures {
  std::map<std::int64_t, std::string> crops_png;
  std::map<std::int64_t, std::vector<ReportView>> views;

  /// Keeps what is seen here. Precondition: this outlives it
  PictureObserver observer();
};

}  // namespace panelcal
