// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <utility>

#include "calib/base/interruption.h"
#include "tools/cli/command_line.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/kept_memory.h"
#include "tools/cli/process/memory_limit.h"
#include "tools/modules/module.h"

namespace panelcal {
namespace {

/// As a shell reports a process that a signal ended.
constexpr int kEndedBySignal = 128;

ExitCode execute(Expected<Answer> (*run)(CommandContext& context), CommandContext& context) {
  const Expected<Answer> answer = run(context);
  context.console.end_progress();
  const Expected<void> done = answer ? context.output.write(answer->text) : failure(answer.error());
  if (done) return answer->code;
  context.console.print(done.error());
  return exit_code(done.error());
}

int run(int argc, char** argv) {
  // A closed pipe, or a file that may not grow, is an error of ours to report, not a reason to die
  // without a word.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  keep_freed_memory();
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
  const ExitCode code = options->run != nullptr ? execute(options->run, context) : ExitCode::Done;
  if (code != ExitCode::Done && interruption() != 0) return kEndedBySignal + interruption();
  // Help goes through the stream library; whether it arrived shows only now.
  if (!std::cout.flush()) return static_cast<int>(ExitCode::DeviceFailed);
  return static_cast<int>(code);
}

int fail(Code code, std::string what, const char* expected) {
  const Diagnostic diagnostic{code, {"panelcal", 0, 0}, std::move(what), expected};
  Console(CommonOptions{}).print(diagnostic);
  return static_cast<int>(exit_code(diagnostic));
}

}  // namespace
}  // namespace panelcal

int main(int argc, char** argv) {
  using panelcal::Code;
  using panelcal::fail;
  try {
    return panelcal::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return fail(Code::OutOfMemory, panelcal::memory_limit(), "more memory, or a smaller job");
  } catch (const panelcal::modules::ModuleError& error) {
    return fail(Code::Internal, error.what(), "the modules of this very installation");
  } catch (const std::exception& error) {
    return fail(Code::Internal, error.what(), "no exception here; please report it");
  }
}
