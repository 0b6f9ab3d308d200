// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "program/judge/depth_errors.h"
#include "program/writers/text_writer.h"

namespace panelcal {

/// Characters that the text of a point may touch in CSV: two numbers, each behind a comma, in whole
/// pieces of 16.
inline constexpr std::size_t kCsvPointChars = 80;
static_assert(kCsvPointChars >= 2 * (kFixedChars + 1));

/// Operations as CSV (RFC 4180) with a header row; the columns carry the names of the JSON keys,
/// points in two columns, and hold everything that JSON Lines do (docs/formats/operations.md).
/// A path is written with dots, outermost index first: 0.2.
class CsvWriter final : public TextWriter {
 public:
  /// In     judge: says how likely depths break their tolerance; empty: not asked for
  explicit CsvWriter(ByteSink& bytes, std::optional<DepthJudge> judge = std::nullopt)
      : TextWriter(bytes), judge_(std::move(judge)) {}
  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

 private:
  /// The sigma of the hole that was written last.
  struct SigmaText {
    double x_mm2 = std::numeric_limits<double>::quiet_NaN();
    double y_mm2 = x_mm2;
    std::array<char, kCsvPointChars> text = {};
    std::size_t n_chars = 0;  ///< of the text; 0: not made yet
  };

  char* write_hole(char* end, const Operation& operation, const Drill& drill);
  char* write_sigma(char* at, const Drill& drill);
  [[gnu::noinline]] void put_by_fields(const Operation& operation);

  std::optional<DepthJudge> judge_;
  SigmaText sigma_;
};

}  // namespace panelcal
