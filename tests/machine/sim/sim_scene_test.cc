// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_scene.h"

#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal::internal {
namespace {

CameraMapping calibrated() {
  return CameraMapping(test::test_camera(320, 240).parameters);
}

SimConfig sim_of(int neighbors) {
  SimConfig sim;
  sim.width_px = 320;
  sim.height_px = 240;
  sim.neighbors = neighbors;
  return sim;
}

Target target_of(Shape shape) {
  Target target;
  target.shape = shape;
  target.size = mm(0.4);
  if (shape == Shape::Cross) target.width = mm(0.1);
  if (shape == Shape::Dots) target.dots = {{0, 0}, {0.6, 0}, {0, 0.6}};
  return target;
}

/// A camera that sees wider than the clearance around marks: blurred, pads still do not meet.
TEST(SimScene, NeighborsKeepClearOfMarks) {
  const SimConfig sim = sim_of(6);
  Camera camera = sim_camera(sim, calibrated());
  camera.blur_px = 2;
  for (const Shape shape : {Shape::Disc,
                            Shape::Ring,
                            Shape::Square,
                            Shape::Cross,
                            Shape::Slot,
                            Shape::Dots,
                            Shape::AprilTag}) {
    const Target target = target_of(shape);
    const auto mark = sim_mark(sim, target, {{}, deg(10), mm(5)}, calibrated(), Random(1));
    std::vector<Feature> all = mark;
    add_neighbors(sim, target, camera, calibrated(), Random(2), all);
    ASSERT_GT(all.size(), mark.size()) << name(shape);
    const std::vector<Feature> neighbors(all.begin() + static_cast<std::ptrdiff_t>(mark.size()),
                                         all.end());
    const std::vector<bool> marked = touched_pixels(mark, camera);
    const std::vector<bool> beside = touched_pixels(neighbors, camera);
    int n_marked = 0;
    for (std::size_t i = 0; i < marked.size(); ++i) {
      n_marked += marked[i] ? 1 : 0;
      ASSERT_FALSE(marked[i] && beside[i]) << name(shape);
    }
    EXPECT_GT(n_marked, 100) << name(shape);
  }
}

TEST(SimScene, MarksAreFunctionsOfTheirGenerator) {
  SimConfig sim = sim_of(0);
  sim.burrs = um(10);
  const Camera camera = sim_camera(sim, calibrated());
  const auto picture = [&](std::uint64_t seed) {
    Scene scene = sim_scene(sim);
    scene.features =
        sim_mark(sim, target_of(Shape::Hole), {{}, {}, mm(5)}, calibrated(), Random(seed));
    return render_levels(scene, camera);
  };
  EXPECT_EQ(picture(3), picture(3));
  EXPECT_NE(picture(3), picture(4));
}

TEST(SimScene, RingsHoldTheirHolesWhereTheyScatterTo) {
  SimConfig sim = sim_of(0);
  sim.ring_offset_sigma = um(20);
  double squares = 0;
  constexpr int kRings = 400;
  for (int i = 0; i < kRings; ++i) {
    const auto ring = sim_mark(sim,
                               target_of(Shape::Ring),
                               {{}, {}, mm(5)},
                               calibrated(),
                               Random(static_cast<std::uint64_t>(i)));
    squares += ring.front().hole_offset.in_mm().squaredNorm();
  }
  // Chi-square with 800 degrees of freedom: 4 sigma are 20 %.
  EXPECT_NEAR(squares / (2 * kRings) / (0.02 * 0.02), 1, 0.2);
}

TEST(SimScene, NoiseIsInLevelsOf255) {
  SimConfig sim = sim_of(0);
  sim.noise = 2;
  sim.shot_noise = 0.01;
  sim.full_scale = 65535;
  const Camera camera = sim_camera(sim, calibrated());
  EXPECT_EQ(camera.full_scale, 65535);
  EXPECT_EQ(camera.noise, 2 * 257);
  // Of the variance, gain times level: both grow by 257.
  EXPECT_DOUBLE_EQ(camera.shot_noise * 65535, 257.0 * 257.0 * 0.01 * 255);
}

}  // namespace
}  // namespace panelcal::internal
