// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "calib/base/expected.h"
#include "machine/devices/commands/command_stage.h"
#include "program/walk/probing.h"

namespace panelcal {

/// Probes through a program that speaks to the machine's controller ([machine] probe_command).
///
/// The program drives to the place, probes, and writes the height above Z0 in mm, which may be
/// followed by what a reading scatters; or the word `none`, where nothing was touched. It ends with
/// code 0.
///
/// See    tests/machine/devices/commands/command_probe_test.cc
class CommandProbe final : public ProbeSource {
 public:
  /// Precondition: commands.probe is not empty and has no placeholder_problem.
  explicit CommandProbe(StageCommands commands) : commands_(std::move(commands)) {}

  /// Out    a sigma of 0 if the program does not say it
  /// Fails  device-stage (see run_program; output of another form)
  Expected<ProbeReading> probe(const ProbeRequest& request) override;

 private:
  StageCommands commands_;
};

}  // namespace panelcal
