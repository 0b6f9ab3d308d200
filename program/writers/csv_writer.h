// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>

#include "program/judge/depth_errors.h"
#include "program/writers/text_writer.h"

namespace panelcal {

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
  std::optional<DepthJudge> judge_;
};

}  // namespace panelcal
