// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/base/units.h"

namespace panelcal {

/// A program and its words. {x}, {y}, {z} in a word become places in mm with six decimals, {lamp}
/// and {zoom} numbers as the part program writes them, {tool} the number of a drill.
using CommandWords = std::vector<std::string>;

/// [machine] stage_command and its kin: programs through which any controller can be joined.
struct StageCommands {
  CommandWords move;         ///< needs {x} and {y}; empty: the stage cannot be moved
  CommandWords drill;        ///< needs {tool}; empty: the spindle cannot drill
  CommandWords lamp;         ///< needs {lamp}; empty: there is none to set
  CommandWords zoom;         ///< needs {zoom}
  CommandWords focus;        ///< needs {z}
  CommandWords probe;        ///< needs {x} and {y}; empty: the machine cannot probe
  Time limit = seconds(30);  ///< for one order
};

/// The problem of a command's placeholders: one that does not exist, or `wanted` ones that are
/// missing. Empty if nothing.
std::string placeholder_problem(const CommandWords& words, const std::vector<std::string>& wanted);

}  // namespace panelcal
