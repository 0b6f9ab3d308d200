// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "machine/devices/commands/command_stage.h"
#include "machine/devices/spindle.h"

namespace panelcal {

/// Drills through [machine] drill_command, a program that speaks to the machine's controller. The
/// hole is drilled and the tool lifted when it ends with code 0.
class CommandSpindle final : public Spindle {
 public:
  /// In     drill: needs {tool}; empty: it cannot drill
  CommandSpindle(CommandWords drill, Time limit) : drill_(std::move(drill)), limit_(limit) {}

  bool can_drill() const override { return !drill_.empty(); }
  /// Fails  not-supported (see can_drill); device-stage (see run_program)
  Expected<void> drill(int tool) override;

 private:
  CommandWords drill_;
  Time limit_;
};

}  // namespace panelcal
