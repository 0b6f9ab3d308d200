// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/align/pad.h"
#include "machine/config/machine_config.h"
#include "program/walk/program.h"
#include "program/walk/reading_terms.h"

namespace panelcal {

/// Terms on which pads are looked for in a file.
struct PadChoice {
  std::optional<int> vision_tool;   ///< absent: the only one, or the one of the pads' size
  std::optional<Length> diameter;   ///< of round flashes that no attribute names
  std::optional<int> n_best_holes;  ///< number of a program's holes, in place of its targets
  ReadingTerms reading;             ///< of a program
  /// Told of a program that was read; a failure ends the reading. May be empty.
  std::function<Expected<void>(const Program&)> read;
};

/// Most pads of one alignment.
inline constexpr std::size_t kMostPads = 100;

/// Reads pads: a list "X,Y;X,Y" (mm, relative to work zero), a Gerber file, a placement file, or a
/// part program, whose targets of the panel they are.
///
/// In     pads: the list, or a file's path
/// Fails  usage (no pads, more than kMostPads, one twice, no vision tool for them);
/// file-unreadable;
///        what the file's reader reports
/// See    tests/machine/align/pads_test.cc
Expected<PadList> read_pads(const std::string& pads,
                            const PadChoice& choice,
                            const MachineConfig& machine);

/// A program that measures the pads as one series of targets.
std::string pad_program(const std::vector<Pad>& pads);

}  // namespace panelcal
