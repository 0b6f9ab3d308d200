// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "program/text/number_format.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

// Options of all commands that read a program. What they fill must outlive `command`.
namespace panelcal {

void add_limit(CLI::App* command, std::int64_t& max_operations);

CLI::Option* add_accept(CLI::App* command, bool& accepts_unterminated);

/// --format: a text that it cannot be is refused on the command line.
CLI::Option* add_format(CLI::App* command, PartialFormat& format);

void add_clock(CLI::App* command, std::string& clock);

}  // namespace panelcal
