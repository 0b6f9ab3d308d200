// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "calib/base/files/byte_sink.h"

namespace panelcal {

/// Keeps bytes until they are wanted: few in memory, many in a temporary file that has no name.
///
/// Fails  device-write (the temporary file; with the system's text)
/// See    tests/calib/base/files/spool_test.cc
class Spool final : public ByteSink {
 public:
  static constexpr std::size_t kInMemory = std::size_t{1} << 20;

  Expected<void> write(std::string_view bytes) override;
  /// Drops all bytes.
  void clear();
  /// Passes all bytes on, in pieces; nothing may be written any more.
  ///
  /// Fails  also what `target` reports
  Expected<void> pass_to(ByteSink& target);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::string memory_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace panelcal
