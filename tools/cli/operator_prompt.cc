// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/operator_prompt.h"

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace panelcal {
namespace {

constexpr const char* kPerson = "a person at a terminal";

}  // namespace

Expected<void> ask_operator(const std::string& command,
                            const std::string& expected,
                            Console& console,
                            std::string_view what) {
  console.end_progress();
  const std::string question = fmt::format("{}, then press Enter: ", what);
  std::fwrite(question.data(), 1, question.size(), stderr);
  for (int c = std::getchar(); c != '\n'; c = std::getchar()) {
    if (c != EOF) continue;
    return failure({Code::Usage, {command, 0, 0}, "no answer: " + std::string(what), expected});
  }
  return {};
}

Expected<Prompt> operator_prompt(const std::string& command, Console& console) {
  if (::isatty(STDIN_FILENO) != 1) {
    return failure({Code::Usage,
                    {command, 0, 0},
                    "the coupon needs entry material, and no person is there to lay it on",
                    kPerson});
  }
  return Prompt([command, &console](std::string_view what) {
    return ask_operator(command, kPerson, console, what);
  });
}

}  // namespace panelcal
