// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "calib/base/expected.h"

namespace panelcal {

/// The receiver of bytes: a file being written, standard output, a string.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual Expected<void> write(std::string_view bytes) = 0;
};

/// Collects the bytes in memory.
class StringSink final : public ByteSink {
 public:
  Expected<void> write(std::string_view bytes) override {
    text_ += bytes;
    return {};
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace panelcal
