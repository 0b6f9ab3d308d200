// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "panelcal/program/walk.h"

namespace panelcal {

/// Which holes or moves to explain: `L14` all that line 14 makes, `500` the 500th, from 1.
struct ExplainChoice {
  std::optional<int> line;
  std::optional<std::int64_t> number;
};

/// Fails  with nothing if `text` is neither
std::optional<ExplainChoice> parse_explain_choice(std::string_view text);

/// Says how places came about: source line, pattern path, every transform, the fiducials behind it,
/// and where the uncertainty comes from.
class Explainer final : public OperationSink {
 public:
  static constexpr int kMost = 20;  ///< places of one line; the rest are counted

  /// Precondition: program and survey outlive this; `machine` is what they were walked with.
  Explainer(ExplainChoice choice,
            const Program& program,
            const Survey& survey,
            MachineUncertainty machine = {})
      : choice_(choice), program_(program), survey_(survey), machine_(std::move(machine)) {}

  void put(const Operation& operation) override;
  /// The explanation, or that there is no such place.
  std::string text() const;
  bool has_found() const { return n_matching_ > 0; }

 private:
  void explain(const Operation& operation, const PlacedPoint& point);
  void explain_correction(const Origin& origin);
  void explain_series(std::string_view name, std::size_t i_series);

  ExplainChoice choice_;
  const Program& program_;
  const Survey& survey_;
  MachineUncertainty machine_;
  Tool tool_;
  std::int64_t n_places_ = 0;
  std::int64_t n_matching_ = 0;
  std::string text_;
};

}  // namespace panelcal
