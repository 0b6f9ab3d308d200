// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "program/judge/depth_errors.h"
#include "program/judge/job_verdict.h"
#include "program/walk/walk.h"

namespace panelcal {

/// Holes or moves to explain: `L14` all that line 14 makes, `500` the 500th, from 1.
struct ExplainChoice {
  std::optional<int> line;
  std::optional<std::int64_t> number;
};

/// Fails  with nothing if `text` is neither
std::optional<ExplainChoice> parse_explain_choice(std::string_view text);

/// Says how places came about: source line, pattern path, every transform, the fiducials behind it,
/// where the uncertainty comes from, and how likely the tolerance is broken.
class Explainer final : public OperationSink {
 public:
  static constexpr int kMost = 20;  ///< places of one line; the rest are counted

  /// Precondition: program and survey outlive this; `machine` and `tolerances` are what they were
  /// walked with. `depths`: empty if nothing is asked of depths.
  Explainer(ExplainChoice choice,
            const Program& program,
            const Survey& survey,
            MachineUncertainty machine = {},
            Tolerances tolerances = {},
            std::optional<DepthJudge> depths = std::nullopt)
      : choice_(choice),
        program_(program),
        survey_(survey),
        machine_(std::move(machine)),
        tolerances_(std::move(tolerances)),
        depths_(std::move(depths)) {}

  void begin(const ProgramInfo& info) override {
    if (depths_) depths_->begin(info);
  }
  void put(const Operation& operation) override;
  /// The explanation, or that there is no such place.
  std::string text() const;
  bool has_found() const { return n_matching_ > 0; }

 private:
  void explain(const Operation& operation, const PlacedPoint& point);
  void explain_correction(const Origin& origin);
  void explain_risk(const PlacedPoint& place, const Origin& origin);
  void explain_depth(const Operation& operation);
  void explain_series(std::string_view name, std::size_t i_series);

  ExplainChoice choice_;
  const Program& program_;
  const Survey& survey_;
  MachineUncertainty machine_;
  Tolerances tolerances_;
  std::optional<DepthJudge> depths_;
  Tool tool_;
  std::int64_t n_places_ = 0;
  std::int64_t n_matching_ = 0;
  std::string text_;
};

/// Finds the number by which an Explainer knows a place.
///
/// Precondition: walked with the same cycles as the Explainer is
class PlaceNumber final : public OperationSink {
 public:
  explicit PlaceNumber(JobVerdict::WorstPlace place) : place_(std::move(place)) {}
  void put(const Operation& operation) override;
  /// From 1; absent if the job has no such place. A tool that goes down is no place of its own:
  /// then it is the move that took it there, in a line before.
  std::optional<std::int64_t> number() const { return number_; }
  bool is_of_its_line() const { return is_of_its_line_; }

 private:
  JobVerdict::WorstPlace place_;
  std::int64_t n_places_ = 0;
  std::optional<std::int64_t> number_;
  bool is_of_its_line_ = false;
};

}  // namespace panelcal
