// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "panelcal/calib/base/byte_sink.h"
#include "panelcal/calib/base/frames.h"
#include "panelcal/program/operation.h"

namespace panelcal {

/// A sink that turns operations into text. Bytes leave in large pieces; the first write that fails
/// is remembered and everything after it is dropped.
class TextWriter : public OperationSink {
 public:
  /// Precondition: `bytes` outlives the writer.
  explicit TextWriter(ByteSink& bytes) : bytes_(bytes) {}

  /// Hands over what is left. Fails with the first error of the byte sink.
  Expected<void> finish();

 protected:
  std::string& text() { return text_; }
  /// Call after each operation.
  void flush_if_large();

 private:
  void flush();

  ByteSink& bytes_;
  std::string text_;
  Expected<void> status_;
};

/// Appends a length in fixed point with at most `n_decimals` decimals (0 to 9), trailing zeros and
/// a lone point left off: 12.5, -0.000125, 3. Rounds half away from zero.
void append_fixed(std::string& out, double value, int n_decimals);

/// One nanometre: far below anything a machine can do, and short to write.
inline constexpr int kMmDecimals = 6;

}  // namespace panelcal
