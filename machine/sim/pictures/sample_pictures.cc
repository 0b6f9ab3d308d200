// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/pictures/sample_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "machine/config/json_files.h"
#include "machine/sim/pictures/synth_folder.h"
#include "machine/sim/random_streams.h"
#include "machine/sim/sim_scene.h"
#include "vision/picture/files/image_io.h"
#include "vision/render/scene_marks.h"
#include "vision/render/scene_projection.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

std::string_view shape_name(Shape shape) {
  return name(shape);
}

#include "machine/sim/pictures/sample_pictures.def"

}  // namespace

JsonFile sample_truth_file() {
  return {"sample-truth.json",
          "The truth of pictures of single targets: `truth.json` of `panelcal synth --tool`.",
          {&kSamples}};
}

}  // namespace panelcal::internal

namespace panelcal {
namespace {

using internal::RandomStream;
using internal::SceneProjection;

/// Around a target, for its blur and some of the ground it lies on.
constexpr double kMargin_px = 20;
/// Angles stay away from the limit of the tolerance: they are to be found.
constexpr double kToleranceShare = 0.8;
/// The weave's place under the camera.
constexpr double kPanel_mm = 300;

bool has_angle(Shape shape) {
  return shape != Shape::Disc && shape != Shape::Hole && shape != Shape::Ring;
}

/// Without a calibration a target in px needs only some scale.
CameraMapping mapping_of(const MachineConfig& config, const Target& target) {
  if (config.camera && target.size) return config.camera->mapping();
  CameraMapping::Parameters parameters;
  if (config.camera) parameters.scale_mm_per_px = config.camera->parameters.scale_mm_per_px;
  parameters.axis_px = {0.5 * (config.sim->width_px - 1), 0.5 * (config.sim->height_px - 1)};
  return CameraMapping(parameters);
}

Diagnostic refusal(Code code, const MachineConfig& config, std::string what, std::string expected) {
  return {code, {config.file.string(), 0, 0}, std::move(what), std::move(expected)};
}

}  // namespace

SampleRenderer::SampleRenderer(const MachineConfig& config, const Target& target)
    : sim_(*config.sim),
      target_(target),
      calibrated_(mapping_of(config, target)),
      camera_(internal::sim_camera(sim_, calibrated_)) {
  const double scale_mm = calibrated_.parameters().scale_mm_per_px;
  common_.seed = sim_.seed;
  common_.target = target;
  common_.size = target.size ? px(target.size->in_mm() / scale_mm) : *target.size_px;
  common_.noise = camera_.noise;
  common_.blur_px = camera_.blur_px;
}

Expected<SampleRenderer> SampleRenderer::create(const MachineConfig& config, int tool) {
  if (!config.sim) {
    return failure(refusal(Code::ConfigValue,
                           config,
                           "[sim] is missing, which describes the virtual camera",
                           "[sim]"));
  }
  const auto found = config.vision_tools.find(tool);
  if (found == config.vision_tools.end()) {
    return failure(refusal(Code::VisionToolUndefined,
                           config,
                           fmt::format("vision tool {}", tool),
                           fmt::format("[[vision.tool]] with number = {}", tool)));
  }
  const Target& target = found->second;
  PANELCAL_CHECK(target.validate());
  if (target.size && !config.camera) {
    return failure(refusal(Code::ConfigValue,
                           config,
                           fmt::format("the size of vision tool {} is in mm", tool),
                           "[camera], or a size in px"));
  }
  SampleRenderer renderer(config, target);
  const auto mark =
      internal::sim_mark(renderer.sim_, target, {{}, {}, mm(1)}, renderer.calibrated_, Random(1));
  if (mark.empty()) {
    return failure(refusal(Code::ConfigValue,
                           config,
                           fmt::format("vision tool {} asks for an unknown tag", tool),
                           "a number of the tag's family"));
  }
  const double reach_mm = target.shape == Shape::Slot ? 0.5 * mark.front().inner_size.in_mm()
                                                      : reach_of(mark, {}).in_mm();
  renderer.reach_px_ =
      reach_mm / renderer.camera_.mapping.parameters().scale_mm_per_px + kMargin_px;
  const int side_px = std::min(renderer.camera_.width, renderer.camera_.height);
  if (!(2 * renderer.reach_px_ < side_px)) {
    return failure(refusal(Code::ConfigValue,
                           config,
                           fmt::format("vision tool {} needs pictures of {:.0f} px on each side",
                                       tool,
                                       2 * renderer.reach_px_),
                           fmt::format("less than the {} px that they have", side_px)));
  }
  return renderer;
}

Eigen::Vector2d SampleRenderer::draw_place(Random& random) const {
  const double x_px = random.uniform(reach_px_, camera_.width - 1 - reach_px_);
  const double y_px = random.uniform(reach_px_, camera_.height - 1 - reach_px_);
  return {x_px, y_px};
}

Angle SampleRenderer::draw_turn(Random& random) const {
  if (target_.shape == Shape::AprilTag) return rad(random.uniform(0, 2 * std::numbers::pi));
  const double within = random.uniform(-kToleranceShare, kToleranceShare);
  return has_angle(target_.shape) ? within * target_.angle_tolerance : Angle();
}

/// Debris far outside of the picture is of no use to anyone.
std::vector<Feature> SampleRenderer::shortened(std::vector<Feature> mark) const {
  if (target_.shape != Shape::Slot) return mark;
  const double side_px = std::min(camera_.width, camera_.height);
  const Length side = mm(side_px * camera_.mapping.parameters().scale_mm_per_px);
  for (Feature& feature : mark) feature.size = std::min(feature.size, side);
  return mark;
}

Sample SampleRenderer::draw(int i) const {
  const Random base =
      internal::random_of(sim_.seed, RandomStream::Samples, static_cast<std::int64_t>(i));
  Random random = base.fork(0);
  const SceneProjection projection(camera_);
  Sample sample;
  SampleTruth& truth = sample.truth;
  truth.center_px = draw_place(random);
  const Eigen::Vector2d center_mm = projection.board_of(truth.center_px);
  if (target_.size) truth.center_mm = center_mm;
  const Angle turn = draw_turn(random);
  truth.angle = has_angle(target_.shape) ? target_.angle + turn : Angle();

  Scene scene = internal::sim_scene(sim_);
  const double x_mm = random.uniform(0, kPanel_mm);
  const double y_mm = random.uniform(0, kPanel_mm);
  scene.weave.panel_from_optical = Transform<frame::Nominal, frame::Optical>(
      Eigen::Matrix2d::Identity(), Eigen::Vector2d(x_mm, y_mm));
  const internal::SimMarkPlace place{
      position_mm<frame::Optical>(center_mm),
      turn,
      mm(2 * std::hypot(camera_.width, camera_.height) * projection.scale_mm_per_px())};
  scene.features = internal::sim_mark(sim_, target_, place, calibrated_, base.fork(1));
  const std::vector<Feature> mark = scene.features;
  if (target_.shape == Shape::Ring) {
    const Eigen::Vector2d hole_mm = center_mm + mark.front().hole_offset.in_mm();
    const auto hole_px = projection.image_of(hole_mm);
    if (hole_px) truth.hole_offset_px = *hole_px - truth.center_px;
  }
  internal::add_neighbors(sim_, target_, camera_, calibrated_, base.fork(2), scene.features);
  truth.n_neighbors = static_cast<int>(scene.features.size() - mark.size());
  Random dirt = base.fork(3);
  const Debris debris = strew_debris(shortened(mark), sim_.debris, dirt);
  truth.visible = 1 - debris.rim_share;
  scene.features.insert(scene.features.end(), debris.features.begin(), debris.features.end());
  Random noise = base.fork(4);
  sample.image = render(scene, camera_, noise);
  return sample;
}

Expected<SampleSet> write_samples(const SampleRenderer& renderer,
                                  int count,
                                  const std::filesystem::path& folder) {
  PANELCAL_CHECK(internal::prepare_synth_folder(folder));
  SampleSet set = renderer.common();
  for (int i = 0; i < count; ++i) {
    Sample sample = renderer.draw(i);
    sample.truth.file = fmt::format("{:04}.png", i);
    PANELCAL_CHECK(write_png(folder / sample.truth.file, sample.image));
    set.pictures.push_back(std::move(sample.truth));
  }
  PANELCAL_CHECK(write_file(folder / "truth.json", sample_truth_text(set)));
  std::vector<std::string> names = {"truth.json"};
  for (const SampleTruth& picture : set.pictures) names.push_back(picture.file);
  PANELCAL_CHECK(internal::finish_synth_folder(folder, std::move(names)));
  return set;
}

std::string sample_truth_text(const SampleSet& samples) {
  return internal::json_text(internal::kSamples, samples, internal::JsonStyle::Compact) + "\n";
}

}  // namespace panelcal
