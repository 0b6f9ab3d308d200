// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "calib/base/diagnostic.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/byte_sink.h"
#include "tools/cli/options/options.h"

namespace panelcal {

/// Standard error: diagnostics, one-line messages, and a progress line if it is a terminal.
class Console {
 public:
  explicit Console(const CommonOptions& options);

  void print(const DiagnosticLog& log);
  void print(const Diagnostic& diagnostic);
  /// For people; silent with --quiet.
  void say(std::string_view text);
  /// Redraws one line on a terminal; does nothing elsewhere.
  void progress(std::string_view text);
  void end_progress();

 private:
  bool shows_warnings_ = true;
  bool shows_info_ = true;
  bool is_terminal_ = false;
  bool has_progress_ = false;
};

/// Standard output as a byte sink.
class StandardOutput final : public ByteSink {
 public:
  Expected<void> write(std::string_view bytes) override;
  /// A result of a command: to a file, whole or not at all; "-" is standard output.
  Expected<void> write_to(const std::string& path, std::string_view bytes) {
    return path == "-" ? write(bytes) : write_file(path, bytes);
  }
};

}  // namespace panelcal
