// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

// Options of all commands that read a program. What they fill must outlive `command`.
namespace panelcal {

void add_limit(CLI::App* command, std::int64_t& max_operations);

CLI::Option* add_accept(CLI::App* command, bool& accepts_unterminated);

void add_clock(CLI::App* command, std::string& clock);

}  // namespace panelcal
