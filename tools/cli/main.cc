// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <exception>
#include <iostream>
#include <variant>

#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include "tools/modules/module.h"

namespace panelcal {
namespace {

struct Dispatch {
  CommandContext& context;

  ExitCode operator()(const DoneOptions&) const { return ExitCode::Done; }
  template <class CommandOptionsType>
  ExitCode operator()(const CommandOptionsType& options) const {
    return run_command(options, context);
  }
};

int run(int argc, char** argv) {
  // A closed pipe, or a file that may not grow, is an error of ours to report, not a reason to die
  // without a word.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  const Expected<Options> options = parse_options(argc, argv);
  if (!options) {
    Console(CommonOptions{}).print(options.error());
    return static_cast<int>(exit_code(options.error()));
  }
  Console console(options->common);
  StandardOutput output;
  FileRegister files = files_in_use(*options);
  if (const Expected<void> free = check_outputs(*options, files); !free) {
    console.print(free.error());
    return static_cast<int>(exit_code(free.error()));
  }
  CommandContext context{console, output, *options, files};
  const ExitCode code = std::visit(Dispatch{context}, options->command);
  // Help goes through the stream library; whether it arrived shows only now.
  if (!std::cout.flush()) return static_cast<int>(ExitCode::DeviceFailed);
  return static_cast<int>(code);
}

int report_internal(const char* what, const char* expected) {
  const Diagnostic diagnostic{Code::Internal, {"panelcal", 0, 0}, what, expected};
  Console(CommonOptions{}).print(diagnostic);
  return static_cast<int>(exit_code(diagnostic));
}

}  // namespace
}  // namespace panelcal

int main(int argc, char** argv) {
  try {
    return panelcal::run(argc, argv);
  } catch (const panelcal::modules::ModuleError& error) {
    return panelcal::report_internal(error.what(), "the modules of this very installation");
  } catch (const std::exception& error) {
    return panelcal::report_internal(error.what(), "no exception here; please report it");
  }
}
