// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/files/byte_sink.h"
#include "calib/base/frames.h"
#include "program/model/operation.h"
#include "program/writers/fixed_point.h"

namespace panelcal {

/// A sink that turns operations into text. Bytes leave in large pieces; the first write that fails
/// is remembered and everything after it is dropped.
class TextWriter : public OperationSink {
 public:
  /// Precondition: `bytes` outlives the writer.
  explicit TextWriter(ByteSink& bytes) : bytes_(bytes) {}

  /// Writes the end and hands over what is left; call it once. Fails with the first problem of the
  /// writer or the byte sink.
  Expected<void> finish();

 protected:
  std::string& text() {
    if (n_row_chars_ > 0) take_rows();
    return text_;
  }
  /// Memory for the next characters, for operations that come by the million; end_row() says how
  /// many there are. Precondition: n_most <= kMostRow
  char* begin_row(std::size_t n_most) {
    if (n_row_chars_ + n_most > rows_.size()) make_room();
    return rows_.data() + n_row_chars_;
  }
  void end_row(const char* end) { n_row_chars_ = static_cast<std::size_t>(end - rows_.data()); }
  static constexpr std::size_t kMostRow = 1024;
  /// Call after each operation but those between begin_row() and end_row().
  void flush_if_large();
  /// Hands over what there is.
  void flush();
  /// The output would be wrong: nothing more leaves, and finish() says why.
  void fail(Diagnostic diagnostic);
  bool has_failed() const { return !status_.has_value(); }
  /// Writes what can only come after the last operation.
  virtual void end() {}

 private:
  void write(std::string_view text);
  void take_rows();
  void make_room();

  ByteSink& bytes_;
  std::string text_;
  std::vector<char> rows_;  ///< the rows behind text_
  std::size_t n_row_chars_ = 0;
  Expected<void> status_;
};

/// Appends a length in fixed point with at most `n_decimals` decimals (0 to 9), trailing zeros and
/// a lone point left off: 12.5, -0.000125, 3. Rounds half away from zero.
void append_fixed(std::string& out, double value, int n_decimals);

/// Appends a probability with four digits, 0.0123 or 1.234e-09, and the same into memory.
void append_risk(std::string& out, double risk);
char* write_risk(char* at, double risk);  ///< Precondition: kRiskChars are free
inline constexpr std::size_t kRiskChars = 16;

/// One nanometre: far below anything a machine can do, and short to write.
inline constexpr int kMmDecimals = 6;

}  // namespace panelcal
