// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/config/settings/stage_commands.h"
#include "machine/devices/stage.h"

namespace panelcal {

namespace internal {

/// The words of a command with the values of its placeholders.
CommandWords filled(CommandWords words,
                    const std::vector<std::pair<std::string_view, std::string>>& values);

/// A place as commands get it: in mm, to a nanometre.
std::string place_text(double v_mm);
/// Takes a number from the front of what a program answered; empty if there is none, or none that
/// a machine has.
std::optional<double> take_number(std::string_view& text);

}  // namespace internal

/// Drives a machine through programs that speak to its controller.
///
/// A move has arrived when the program ends with code 0. It may write where the spindle then
/// stands, "x y" in mm, which is believed; if it writes nothing, the spindle stands where it was
/// sent.
class CommandStage final : public Stage {
 public:
  /// Precondition: commands.move is not empty and no command has a placeholder_problem.
  explicit CommandStage(StageCommands commands) : commands_(std::move(commands)) {}

  /// Fails  device-stage (see run_program; output that is not two numbers)
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override;
  bool can_set(CameraSetting setting) const override { return !command_of(setting).empty(); }
  /// Fails  not-supported; device-stage
  Expected<void> set(CameraSetting setting, double value) override;

 private:
  const CommandWords& command_of(CameraSetting setting) const;

  StageCommands commands_;
};

}  // namespace panelcal
