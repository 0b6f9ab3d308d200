// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "machine/devices/stage.h"
#include <Eigen/Core>

namespace panelcal {

/// [sim.table]: where the virtual machine's stage really stands, commanded c mm from `center`.
///
///   x error = scale_x x + squareness y + bow_y (y / r)^2
///   y error = scale_y y + bow_x (x / r)^2,                 (x, y) = c - center, r = bow_radius
///
/// in the convention of TableGeometry: the x axis lies along x, and the angle between the axes is
/// 90 degrees minus the squareness.
struct SimTable {
  double scale_x_ppm = 0;
  double scale_y_ppm = 0;
  Angle squareness;
  Length bow_x;  ///< of the x axis: in y, at its ends
  Length bow_y;  ///< of the y axis: in x
  Length bow_radius = mm(300);
  Position<frame::Machine> center;

  Eigen::Vector2d error_mm(const Position<frame::Machine>& command) const;

  friend bool operator==(const SimTable&, const SimTable&) = default;
};

/// A virtual stage that errs: it stands where [sim.table] says, and believes what it was told.
class ErringStage final : public Stage {
 public:
  ErringStage(std::shared_ptr<Stage> exact, const SimTable& table)
      : exact_(std::move(exact)), table_(table) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& command) override;
  bool can_set(CameraSetting setting) const override { return exact_->can_set(setting); }
  Expected<void> set(CameraSetting setting, double value) override {
    return exact_->set(setting, value);
  }

 private:
  std::shared_ptr<Stage> exact_;
  SimTable table_;
};

/// The stage of a virtual machine, over what stands where it is sent: `exact` itself if it does not
/// err.
std::shared_ptr<Stage> simulated_stage(std::shared_ptr<Stage> exact,
                                       const std::optional<SimTable>& table);

}  // namespace panelcal
