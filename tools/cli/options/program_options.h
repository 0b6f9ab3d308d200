// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "program/walk/reading_terms.h"
#include "tools/cli/options/facts_files.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

// Options that several commands have. What they fill must outlive `command`.
namespace panelcal {

void add_limit(CLI::App& command, std::int64_t& max_operations);

/// --accept-unterminated and --format; a text that the latter cannot be is refused on the command
/// line.
///
/// In     program: the option of the program, where there need not be one; null: there is
///        format_option: another name than --format
void add_reading(CLI::App& command,
                 ReadingTerms& reading,
                 CLI::Option* program = nullptr,
                 const std::string& format_option = "--format");

/// --json of a command that states facts.
void add_json(CLI::App& command, FactsFiles& facts);
/// The database of many batches and machines (tools/gather/database.h).
CLI::Option* add_store(CLI::App& command, std::string& store);
/// --report of one whose facts a page shows.
void add_report(CLI::App& command, FactsFiles& facts, const char* help);

void add_clock(CLI::App& command, std::string& clock);

}  // namespace panelcal
