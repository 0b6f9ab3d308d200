// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/options/program_options.h"

#include "tools/cli/help/help_text.h"
#include <CLI/CLI.hpp>

namespace panelcal {

void add_limit(CLI::App& command, std::int64_t& max_operations) {
  constexpr std::int64_t kMost = 1'000'000'000'000;
  command.add_option("--max-operations", max_operations, "Stop a program that never ends")
      ->check(CLI::Range(std::int64_t{1}, kMost))
      ->capture_default_str();
}

void add_reading(CLI::App& command,
                 ReadingTerms& reading,
                 CLI::Option* program,
                 const std::string& format_option) {
  const auto check = [](const std::string& text) {
    const auto parsed = parse_format(text);
    return parsed ? std::string() : "expected " + parsed.error();
  };
  const auto take = [&reading, format_option](const std::string& text) {
    if (auto parsed = parse_format(text)) reading.format = *std::move(parsed);
    reading.format.from = format_option + " " + text;
  };
  CLI::Option* accept = command.add_flag(
      "--accept-unterminated", reading.accepts_unterminated, kAcceptUnterminatedHelp);
  CLI::Option* format =
      command
          .add_option_function<std::string>(format_option,
                                            take,
                                            "Number format of the program, whatever it "
                                            "states: inch or metric, zeros that are "
                                            "kept (lz, tz), digits; such as inch,tz,2.4")
          ->check(CLI::Validator(check, "UNIT,ZEROS,DIGITS"));
  if (program == nullptr) return;
  accept->needs(program);
  format->needs(program);
}

CLI::Option* add_store(CLI::App& command, std::string& store) {
  return command.add_option(
      "--store", store, "Database: postgresql://USER@HOST/NAME, or a file of SQLite");
}

void add_json(CLI::App& command, FactsFiles& facts) {
  command.add_option("--json", facts.json, "The facts as JSON; - is standard output");
}

void add_report(CLI::App& command, FactsFiles& facts, const char* help) {
  command.add_option("--report", facts.report, help);
}

void add_clock(CLI::App& command, std::string& clock) {
  command.add_option("--clock",
                     clock,
                     "Date and time for texts (&D, &T), for the report and for the ages of "
                     "calibrations, such as 2026-11-21T13:45:00 (default: now)");
}

}  // namespace panelcal
