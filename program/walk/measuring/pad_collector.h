// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "calib/faults/known_pads.h"
#include "program/model/operation.h"
#include "program/walk/survey.h"

namespace panelcal {

/// Notes where a program has holes and targets, that a camera may take for another.
///
/// Of programs with very many holes those far from every target are left out; then it cannot be
/// recognised that a whole panel was taken for another way to lay it.
///
/// See    tests/program/walk/measuring/series_examination_test.cc
class PadCollector final : public OperationSink {
 public:
  static constexpr std::size_t kMost = 200'000;
  static constexpr double kNear_mm = 20;  ///< of a target, where every hole counts

  /// `nominal`: a survey of the perfect panel, whose targets are pads as well.
  explicit PadCollector(const Survey& nominal);

  void put(const Operation& operation) override;
  KnownPads take() { return KnownPads(std::move(pads_)); }

 private:
  std::vector<KnownPad> pads_;
  KnownPads targets_;
};

}  // namespace panelcal
