// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "machine/config/settings/sim_options.h"
#include "machine/devices/stage.h"
#include <Eigen/Core>

namespace panelcal {

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
