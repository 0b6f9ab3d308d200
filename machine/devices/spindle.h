// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"

namespace panelcal {

/// The drilling spindle: it drills where the stage stands.
class Spindle {
 public:
  virtual ~Spindle() = default;

  /// Machines that only look have none.
  virtual bool can_drill() const { return true; }
  /// Drills one hole with a tool of the machine's own numbers and lifts it again.
  ///
  /// Fails  device-stage
  virtual Expected<void> drill(int tool) = 0;
};

}  // namespace panelcal
