// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_coupon.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "machine/sim/sim_scene.h"

namespace panelcal {
namespace {

constexpr std::uint64_t kCouponMarkStream = 4;
constexpr std::uint64_t kHoleStream = 100;  ///< of the first hole

}  // namespace

SpindleCameraOffset internal::sim_offset_at(Time since_start,
                                            const SpindleCameraOffset& warm,
                                            const SimCouponOptions& options) {
  const double left = std::exp(-since_start.in_s() / options.warm_up.in_s());
  SpindleCameraOffset out = warm;
  out.offset = out.offset + left * options.cold;
  return out;
}

SimCoupon::SimCoupon(const MachineConfig& config,
                     const SimCouponOptions& options,
                     Target target,
                     std::optional<Target> mark)
    : options_(options),
      target_(std::move(target)),
      mark_(std::move(mark)),
      warm_offset_{config.sim->spindle_camera_offset.value_or(config.spindle_camera.offset), {}},
      motion_(options, Random(options.seed).fork(1)),
      eye_(config, Random(options.seed).fork(3)),
      drills_(Random(options.seed).fork(2)) {
}

Expected<SimCoupon> SimCoupon::create(const MachineConfig& config,
                                      const SimCouponOptions& options) {
  PANELCAL_TRY(Target target, internal::sim_target(config, options.vision_tool));
  std::optional<Target> mark;
  if (options.mark) {
    PANELCAL_TRY(mark, internal::sim_target(config, options.mark_tool));
  }
  return SimCoupon(config, options, std::move(target), std::move(mark));
}

Expected<void> SimCoupon::drill(int /*tool*/) {
  // A spindle goes down when the stage is at rest.
  const double x_mm = options_.wander.in_mm() * drills_.normal();
  const double y_mm = options_.wander.in_mm() * drills_.normal();
  holes_.push_back(motion_.rest() + displacement_mm<frame::Machine>(x_mm, y_mm));
  return {};
}

SpindleCameraOffset SimCoupon::true_offset() const {
  return internal::sim_offset_at(now(), warm_offset_, options_);
}

Expected<Image> SimCoupon::take() {
  std::vector<internal::SimSeenMark> marks;
  for (std::size_t i = 0; i < holes_.size(); ++i) {
    marks.push_back({target_, holes_[i], {}, Random(options_.seed).fork(kHoleStream + i)});
  }
  if (mark_) {
    marks.push_back({*mark_, *options_.mark, {}, Random(options_.seed).fork(kCouponMarkStream)});
  }
  return eye_.picture(true_offset().optical_axis(motion_.standing()), marks);
}

Expected<void> SimCoupon::set(CameraSetting setting, double value) {
  if (!can_set(setting)) return Stage::set(setting, value);
  eye_.set(setting, value);
  return {};
}

CalibrationDevices SimCoupon::devices(Stage& stage, Prompt prompt) {
  return {stage,
          *this,
          *this,
          [this](Time time) { wait(time); },
          std::move(prompt),
          {},
          [this] { return now(); }};
}

}  // namespace panelcal
