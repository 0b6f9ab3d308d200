// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/console.h"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include <unistd.h>

namespace panelcal {
namespace {

void write_error(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace

Console::Console(const CommonOptions& options)
    : shows_warnings_(!options.quiet && options.log_level != "error"),
      shows_info_(!options.quiet && options.log_level == "info"),
      is_terminal_(::isatty(STDERR_FILENO) == 1) {
}

void Console::print(const Diagnostic& diagnostic) {
  if (diagnostic.severity() == Severity::Warning && !shows_warnings_) return;
  end_progress();
  write_error(diagnostic.text() + "\n");
}

void Console::print(const DiagnosticLog& log) {
  for (const Diagnostic& diagnostic : log.kept()) print(diagnostic);
  if (log.n_dropped() > 0) {
    write_error("... and " + std::to_string(log.n_dropped()) + " more\n");
  }
}

void Console::say(std::string_view text) {
  if (!shows_info_) return;
  end_progress();
  write_error(escaped_controls(text, "\n\t") + "\n");
}

void Console::progress(std::string_view text) {
  if (!is_terminal_ || !shows_info_) return;
  has_progress_ = true;
  write_error("\r\x1b[2K" + escaped_controls(text));
}

void Console::end_progress() {
  if (!has_progress_) return;
  has_progress_ = false;
  write_error("\r\x1b[2K");
}

Expected<void> StandardOutput::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      return failure({Code::DeviceWrite,
                      {"standard output", 0, 0},
                      "cannot write: " + std::generic_category().message(errno),
                      ""});
    }
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

}  // namespace panelcal
