// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/fit/solver_log.h"

#include <glog/logging.h>

namespace panelcal {

void silence_solver_log() {
  FLAGS_minloglevel = google::GLOG_FATAL;
}

}  // namespace panelcal
