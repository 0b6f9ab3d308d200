// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/sim/sim_machine.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "panelcal/machine/sim/random_streams.h"
#include "panelcal/program/survey.h"

namespace panelcal {
namespace {

using internal::random_of;
using internal::RandomStream;

/// More inspections of one place than this are a typing error, not a wish.
constexpr int kMaxInspections = 100;
/// The hole of a ring whose vision tool accepts any.
constexpr double kInnerShare = 0.5;
/// Neighbours are this much smaller or larger than the target: beyond the widest size_tolerance.
constexpr double kSmallest = 0.3;
constexpr double kSmall = 0.45;
constexpr double kLarge = 1.7;
constexpr double kLargest = 2.0;
/// Copper is kept free around fiducials; nearer pads would be part of the target's rim.
constexpr double kClearance_px = 15;
constexpr int kMaxAttempts = 200;

Expected<std::vector<MeasurementRequest>> requests_of(const Program& program,
                                                      const WalkOptions& options) {
  NominalSource nominal;
  DiagnosticLog log;
  const Survey survey = panelcal::survey(program, options, nominal, log);
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) return failure(diagnostic);
  }
  std::vector<MeasurementRequest> requests;
  for (const Measurement& measurement : survey.measurements) {
    requests.push_back(measurement.request);
  }
  return requests;
}

Length size_of(const Target& target, const CameraMapping& calibrated) {
  if (target.size) return *target.size;
  return mm(target.size_px->in_px() * calibrated.parameters().scale_mm_per_px);
}

/// Far enough from the optical axis to hold every place in the picture.
double view_radius_mm(const Camera& camera) {
  double radius_mm = 0;
  for (const double x_px : {-0.5, camera.width - 0.5}) {
    for (const double y_px : {-0.5, camera.height - 0.5}) {
      radius_mm = std::max(radius_mm, camera.mapping(position_px(x_px, y_px)).in_mm().norm());
    }
  }
  return radius_mm;
}

Camera camera_of(const SimConfig& sim, const CameraMapping& calibrated) {
  Camera camera{.mapping = sim.camera ? CameraMapping(*sim.camera) : calibrated};
  camera.width = sim.width_px;
  camera.height = sim.height_px;
  camera.blur_px = sim.blur_px;
  camera.noise = sim.noise;
  return camera;
}

bool is_left_of(const Position<frame::Machine>& a, const Position<frame::Machine>& b) {
  return std::pair(a.in_mm().x(), a.in_mm().y()) < std::pair(b.in_mm().x(), b.in_mm().y());
}

}  // namespace

SimMachine::SimMachine(const MachineConfig& config, PictureLocator locator)
    : sim_(*config.sim),
      calibrated_offset_(config.spindle_camera),
      calibrated_camera_(config.camera->mapping()),
      camera_(camera_of(*config.sim, calibrated_camera_)),
      locator_(std::move(locator)) {
}

Expected<SimMachine> SimMachine::create(const MachineConfig& config,
                                        const Program& program,
                                        PictureObserver observer) {
  if (!config.sim) {
    return failure({Code::ConfigValue,
                    {config.file.string(), 0, 0},
                    "there is no [sim] to say what the virtual machine is like",
                    "[sim]"});
  }
  PANELCAL_TRY(PictureLocator locator, PictureLocator::create(config, std::move(observer)));
  PANELCAL_TRY(const std::vector<MeasurementRequest> requests, requests_of(program, config.walk));
  SimMachine machine(config, std::move(locator));
  machine.truth_ = make_truth(*config.sim, requests);
  PANELCAL_CHECK(machine.place_marks(requests, config.file));
  return machine;
}

Expected<void> SimMachine::place_marks(std::span<const MeasurementRequest> requests,
                                       const std::filesystem::path& config_file) {
  const double picture_mm =
      std::min(sim_.width_px, sim_.height_px) * camera_.mapping.parameters().scale_mm_per_px;
  double largest_mm = 0;
  for (const MeasurementRequest& request : requests) {
    PANELCAL_TRY(Target target, locator_.target_of(request));
    const double size_mm = size_of(target, calibrated_camera_).in_mm();
    if (!(size_mm < picture_mm)) {
      return failure({Code::ConfigValue,
                      {config_file.string(), 0, 0},
                      fmt::format("vision tool {} is {:.3f} mm large", target.number, size_mm),
                      fmt::format("less than the picture's {:.3f} mm", picture_mm)});
    }
    largest_mm = std::max(largest_mm, size_mm);
    const Position<frame::Actual> actual =
        truth_.actual_from_nominal(request.path)(request.nominal);
    marks_.push_back(
        {request.work_zero + displacement_mm<frame::Machine>(actual.in_mm()), std::move(target)});
  }
  // A target that is measured twice is one mark: painted twice, its rim would be too wide.
  std::ranges::stable_sort(marks_, is_left_of, &Mark::place);
  const auto twice = std::ranges::unique(marks_, std::ranges::equal_to(), &Mark::place);
  marks_.erase(twice.begin(), twice.end());
  view_radius_mm_ = view_radius_mm(camera_) + largest_mm / 2;
  return {};
}

Feature SimMachine::feature_of(const Target& target, const Position<frame::Optical>& center) const {
  Feature feature;
  feature.shape = target.shape == Shape::Ring ? Feature::Shape::Ring : Feature::Shape::Disc;
  feature.center = center;
  feature.size = size_of(target, calibrated_camera_);
  if (target.shape == Shape::Ring) {
    feature.inner_size = kInnerShare * feature.size;
    if (target.inner_size) feature.inner_size = *target.inner_size;
    if (target.inner_size_px) {
      feature.inner_size =
          mm(target.inner_size_px->in_px() * calibrated_camera_.parameters().scale_mm_per_px);
    }
  }
  feature.level = target.polarity == Polarity::Bright
                      ? sim_.target_level
                      : std::max(0.0, 2 * sim_.background - sim_.target_level);
  return feature;
}

std::vector<Feature> SimMachine::marks_in_view(const Position<frame::Machine>& true_axis) const {
  const auto left = displacement_mm<frame::Machine>(-view_radius_mm_, 0);
  std::vector<Feature> features;
  for (auto mark = std::ranges::lower_bound(marks_, true_axis + left, is_left_of, &Mark::place);
       mark != marks_.end();
       ++mark) {
    const Eigen::Vector2d from_axis_mm = (mark->place - true_axis).in_mm();
    if (from_axis_mm.x() > view_radius_mm_) break;
    if (from_axis_mm.norm() > view_radius_mm_) continue;
    features.push_back(feature_of(mark->target, position_mm<frame::Optical>(from_axis_mm)));
  }
  return features;
}

void SimMachine::add_neighbors(const Target& target,
                               Random random,
                               std::vector<Feature>& features) const {
  const double clearance_mm = kClearance_px * camera_.mapping.parameters().scale_mm_per_px;
  for (int n = 0, attempts = 0; n < sim_.neighbors && attempts < kMaxAttempts; ++attempts) {
    const double x_px = random.uniform(0, sim_.width_px);
    const double y_px = random.uniform(0, sim_.height_px);
    const double ratio = random.uniform() < 0.5 ? random.uniform(kSmallest, kSmall)
                                                : random.uniform(kLarge, kLargest);
    Feature pad = feature_of(target, camera_.mapping(position_px(x_px, y_px)));
    pad.shape = Feature::Shape::Disc;
    pad.size = ratio * pad.size;
    const bool is_free = std::ranges::all_of(features, [&](const Feature& other) {
      const double distance_mm = (pad.center - other.center).in_mm().norm();
      return distance_mm > 0.5 * (pad.size + other.size).in_mm() + clearance_mm;
    });
    if (!is_free) continue;
    features.push_back(pad);
    ++n;
  }
}

Expected<TakenPicture> SimMachine::take_picture(const MeasurementRequest& request, int i) const {
  PANELCAL_TRY(const Target target, locator_.target_of(request));
  const Position<frame::Machine> spindle =
      calibrated_offset_.spindle_to_see(request.expected_in_machine());
  const SpindleCameraOffset true_offset{
      sim_.spindle_camera_offset.value_or(calibrated_offset_.offset), {}};
  const Position<frame::Machine> true_axis = true_offset.optical_axis(spindle);

  Scene scene;
  scene.features = marks_in_view(true_axis);
  add_neighbors(target, random_of(sim_.seed, RandomStream::Neighbors, request.seq), scene.features);
  scene.background = sim_.background;
  scene.light_gradient.x() = sim_.light_gradient;
  scene.vignetting = sim_.vignetting;
  scene.weave.amplitude = sim_.weave_amplitude;
  scene.weave.seed = sim_.seed;
  const Transform<frame::Actual, frame::Optical> actual_from_optical(
      Eigen::Matrix2d::Identity(), (true_axis - request.work_zero).in_mm());
  scene.weave.panel_from_optical =
      truth_.actual_from_nominal(request.path).inverse() * actual_from_optical;
  Random noise =
      random_of(sim_.seed, RandomStream::Noise, request.seq).fork(static_cast<std::uint64_t>(i));
  return TakenPicture{
      render(scene, camera_, noise), calibrated_offset_.optical_axis(spindle), "", ""};
}

Expected<int> SimMachine::inspections_of(const MeasurementRequest& request) {
  const int n = std::max(1, request.settings.inspections);
  if (n <= kMaxInspections) return n;
  return failure({Code::NotSupported,
                  {},
                  fmt::format("{} asks for {} inspections", describe(request), n),
                  fmt::format("at most {}", kMaxInspections)});
}

Expected<Measurement> SimMachine::measure(const MeasurementRequest& request) {
  PANELCAL_TRY(const int n_pictures, inspections_of(request));
  return locator_.measure(request, n_pictures, [&](int i) { return take_picture(request, i); });
}

}  // namespace panelcal
