// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_plate.h"

#include <utility>

#include "machine/sim/sim_scene.h"

namespace panelcal {
namespace {

constexpr std::uint64_t kPlateMarkStream = 100;  ///< of the first mark

}  // namespace

SimPlate::SimPlate(const MachineConfig& config, SimPlateOptions options, Target target)
    : options_(std::move(options)),
      target_(std::move(target)),
      offset_{config.sim->spindle_camera_offset.value_or(config.spindle_camera.offset), {}},
      motion_(options_, Random(options_.seed).fork(1)),
      eye_(config, Random(options_.seed).fork(2)) {
}

Expected<SimPlate> SimPlate::create(const MachineConfig& config, SimPlateOptions options) {
  PANELCAL_TRY(const Target target, internal::sim_target(config, options.vision_tool));
  return SimPlate(config, std::move(options), target);
}

Expected<Position<frame::Machine>> SimPlate::move_to(const Position<frame::Machine>& spindle) {
  if (!options_.error_mm) return motion_.move_to(spindle);
  return motion_.move_to(spindle, options_.error_mm(spindle));
}

Expected<void> SimPlate::drill(int /*tool*/) {
  return failure(
      {Code::DeviceStage, {"sim", 0, 0}, "the virtual table with marks cannot be drilled", ""});
}

Expected<void> SimPlate::set(CameraSetting setting, double value) {
  if (!can_set(setting)) return Stage::set(setting, value);
  eye_.set(setting, value);
  return {};
}

Expected<Image> SimPlate::take() {
  std::vector<internal::SimSeenMark> marks;
  const auto add = [&](const Target& target, const Position<frame::Machine>& place, Angle turn) {
    marks.push_back(
        {target, place, turn, Random(options_.seed).fork(kPlateMarkStream + marks.size())});
  };
  for (const Position<frame::Machine>& mark : options_.marks) add(target_, mark, {});
  for (const SimOtherMark& other : options_.others) add(other.target, other.place, other.turn);
  return eye_.picture(offset_.optical_axis(motion_.standing()), marks);
}

}  // namespace panelcal
