// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>

#include "program/judge/depth_errors.h"
#include "program/writers/text_writer.h"

namespace panelcal {

/// Operations as JSON Lines (docs/formats/operations.md): mm, mm/s, rpm, s.
class JsonlWriter final : public TextWriter {
 public:
  /// In     judge: says how likely depths break their tolerance; empty: not asked for
  explicit JsonlWriter(ByteSink& bytes, std::optional<DepthJudge> judge = std::nullopt)
      : TextWriter(bytes), judge_(std::move(judge)) {}
  void begin(const ProgramInfo& info) override {
    if (judge_) judge_->begin(info);
  }
  void put(const Operation& operation) override;

 private:
  std::optional<DepthJudge> judge_;
};

}  // namespace panelcal
