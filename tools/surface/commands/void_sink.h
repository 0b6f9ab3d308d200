// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "program/model/operation.h"
#include "surface/map/voids.h"

namespace panelcal::surface {

/// Collects what a program takes away from a panel: holes, slots and routed contours, each as wide
/// as its tool.
///
/// Routed moves are a void each, so that a message names the line. Under cutter compensation the
/// tool runs beside the contour, around its outer corners and a little too far into inner ones.
///
/// See    tests/tools/surface/commands/void_sink_test.cc
class VoidSink final : public OperationSink {
 public:
  explicit VoidSink(std::string file) : file_(std::move(file)) {}

  void put(const Operation& operation) override;
  /// In the order of the program, no hole twice.
  ///
  /// Fails  diameter-missing: a tool that works has none, at its first hole
  Expected<std::vector<Void>> take();

 private:
  /// Of a tool without a diameter.
  struct Unknown {
    Place first;
    std::int64_t n = 0;
  };

  Place place_of(const Operation& operation) const;
  std::optional<Length> diameter_of(const Operation& operation, int tool);
  void put_hole(const Operation& operation, const Drill& drill);
  void put_slot(const Operation& operation,
                const Position<frame::Nominal>& from,
                const Position<frame::Nominal>& to,
                int tool);
  void put_rout(const Operation& operation, const Rout& rout);
  std::vector<Eigen::Vector2d> tool_way_mm(const std::vector<Eigen::Vector2d>& contour_mm,
                                           Length to_the_left);

  std::string file_;
  std::map<int, std::optional<Length>> diameters_;
  std::map<int, Unknown> unknown_;
  Position<frame::Nominal> router_;
  CompensationSide side_ = CompensationSide::Off;
  std::optional<Length> compensation_;  ///< the diameter; empty: the tool's
  /// Direction at the end of the last move of the contour; empty at its beginning.
  std::optional<Eigen::Vector2d> heading_;
  std::vector<Void> voids_;
};

}  // namespace panelcal::surface
