// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "machine/job/job.h"
#include "program/text/source_text.h"
#include "python/bindings/machine.h"

namespace panelcal::python {

/// The origin of a program: a file, or a text and the name that it goes by.
struct ProgramSource {
  std::string name;
  std::optional<std::string> text;  ///< absent: in the file of that name

  /// The program with its stored patterns, as this machine reads it; problems are in Job::reading.
  Job read(const MachineConfig& machine, std::chrono::sys_seconds now) const;
};

}  // namespace panelcal::python
