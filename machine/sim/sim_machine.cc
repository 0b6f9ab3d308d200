// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_machine.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "machine/devices/table_stage.h"
#include "machine/sim/random_streams.h"
#include "machine/sim/sim_scene.h"
#include "program/walk/survey.h"
#include "vision/render/scene_marks.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::random_of;
using internal::RandomStream;

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
  return radius_mm / std::cos(camera.tilt.in_rad());
}

/// Rotation of a board on the table.
Angle rotation_of(const Transform<frame::Actual, frame::Nominal>& map) {
  const Eigen::Matrix2d& a = map.linear();
  return rad(std::atan2(a(1, 0) - a(0, 1), a(0, 0) + a(1, 1)));
}

/// Adds what was made at the optical axis.
void add_shifted(const std::vector<Feature>& at_axis,
                 const Displacement<frame::Machine>& shift,
                 std::vector<Feature>& features) {
  for (Feature feature : at_axis) {
    feature.center = feature.center + displacement_mm<frame::Optical>(shift.in_mm());
    features.push_back(std::move(feature));
  }
}

/// The generator of one of several views; of the first one it is that of the request.
Random of_view(const Random& random, const View& view) {
  return view.i_view == 0 ? random : random.fork(static_cast<std::uint64_t>(view.i_view));
}

bool is_left_of(const Position<frame::Machine>& a, const Position<frame::Machine>& b) {
  return std::pair(a.in_mm().x(), a.in_mm().y()) < std::pair(b.in_mm().x(), b.in_mm().y());
}

/// A hole may have more digits than the target that asks for it: copies, scaling and bolt circles
/// have any, and coordinates at the coarsest 0.01 mm. No two holes are drilled so close.
constexpr double kSamePlace_mm = 0.02;

bool is_one_place(const Position<frame::Machine>& a, const Position<frame::Machine>& b) {
  return (a - b).in_mm().norm() <= kSamePlace_mm;
}

/// Drills the coupon, and tells to which place the spindle was sent and where the hole really is.
class NotedDrilling final : public Stage, public Spindle {
 public:
  using Note = std::function<void(const Position<frame::Machine>& sent_to,
                                  const Position<frame::Machine>& hole)>;

  NotedDrilling(Stage& stage, SimCoupon& coupon, Note note)
      : stage_(stage), coupon_(coupon), note_(std::move(note)) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    sent_to_ = spindle;
    return stage_.move_to(spindle);
  }
  bool can_set(CameraSetting setting) const override { return stage_.can_set(setting); }
  Expected<void> set(CameraSetting setting, double value) override {
    return stage_.set(setting, value);
  }
  Expected<void> drill(int tool) override {
    PANELCAL_CHECK(coupon_.drill(tool));
    note_(sent_to_, coupon_.holes().back());
    return {};
  }

 private:
  Stage& stage_;
  SimCoupon& coupon_;
  Note note_;
  Position<frame::Machine> sent_to_;
};

}  // namespace

SimMachine::SimMachine(const MachineConfig& config, VisionProcedure procedure)
    : sim_(*config.sim),
      stated_focus_(config.vision.focus.value_or(Length())),
      stated_lamp_(config.vision.lamp),
      table_(config.walk.table),
      warm_offset_{config.sim->spindle_camera_offset.value_or(config.spindle_camera.offset), {}},
      settle_(config.settle),
      job_(config),
      calibrated_camera_(config.camera->mapping()),
      camera_(internal::sim_camera(*config.sim, calibrated_camera_)),
      procedure_(std::move(procedure)) {
}

Expected<SimMachine> SimMachine::create(const MachineConfig& config,
                                        const Program& program,
                                        PictureObserver observer) {
  DiagnosticLog log;
  const CheckedWalk checked = check(program, config.walk, log);
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) return failure(diagnostic);
  }
  return create(config, checked.survey, std::move(observer));
}

Expected<SimMachine> SimMachine::create(const MachineConfig& config,
                                        const Survey& nominal,
                                        PictureObserver observer) {
  if (!config.sim) {
    return failure({Code::ConfigValue,
                    {config.file.string(), 0, 0},
                    "[sim] is missing, which describes the virtual machine",
                    "[sim]"});
  }
  PANELCAL_TRY(VisionProcedure procedure, VisionProcedure::create(config, std::move(observer)));
  std::vector<MeasurementRequest> requests;
  for (const Measurement& measurement : nominal.measurements) {
    requests.push_back(measurement.request);
  }
  SimMachine machine(config, std::move(procedure));
  machine.truth_ = make_truth(*config.sim, requests);
  PANELCAL_CHECK(machine.place_marks(requests, config.file));
  return machine;
}

Expected<void> SimMachine::place_marks(std::span<const MeasurementRequest> requests,
                                       const std::filesystem::path& config_file) {
  const double picture_mm =
      std::min(sim_.width_px, sim_.height_px) * camera_.mapping.parameters().scale_mm_per_px;
  view_radius_mm_ = view_radius_mm(camera_);
  for (const MeasurementRequest& request : requests) {
    PANELCAL_CHECK(procedure_.locator().check(request));
    PANELCAL_TRY(const Camera camera, camera_for(request, {}));
    view_radius_mm_ = std::max(view_radius_mm_, view_radius_mm(camera));
  }
  for (const MeasurementRequest& request : requests) {
    const Eigen::Vector2d& nominal_mm = request.nominal.in_mm();
    target_places_.push_back({request.work_zero + displacement_mm<frame::Machine>(nominal_mm),
                              request.work_zero,
                              target_places_.size()});
    const auto offsets = procedure_.mark_offsets(request);
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      const int i_tool = request.settings.tools.size() > 1 ? static_cast<int>(i) : 0;
      PANELCAL_TRY(const Target target, procedure_.locator().target_of(request, i_tool));
      const double size_mm = size_of(target, calibrated_camera_).in_mm();
      if (!(size_mm < picture_mm)) {
        return failure({Code::ConfigValue,
                        {config_file.string(), 0, 0},
                        fmt::format("vision tool {} is {:.3f} mm large", target.number, size_mm),
                        fmt::format("less than the picture's {:.3f} mm", picture_mm)});
      }
      const Position<frame::Nominal> nominal =
          request.nominal + displacement_mm<frame::Nominal>(offsets[i].in_mm());
      const Position<frame::Actual> actual = truth_.actual_from_nominal(request.path)(nominal);
      marks_.push_back(make_mark(
          request, target, request.work_zero + displacement_mm<frame::Machine>(actual.in_mm()), i));
      marks_.back().programmed =
          request.work_zero + displacement_mm<frame::Machine>(nominal.in_mm());
      largest_reach_mm_ = std::max(largest_reach_mm_, marks_.back().reach_mm);
    }
  }
  // A target that is measured twice is one mark: painted twice, its rim would be too wide.
  std::ranges::stable_sort(marks_, is_left_of, &Mark::place);
  const auto twice = std::ranges::unique(marks_, std::ranges::equal_to(), &Mark::place);
  marks_.erase(twice.begin(), twice.end());
  std::ranges::stable_sort(target_places_, is_left_of, &TargetPlace::programmed);
  tell_holes(requests);
  return {};
}

/// Only now: of a target that is measured twice one mark is left.
void SimMachine::tell_holes(std::span<const MeasurementRequest> requests) {
  for (std::size_t i = 0; i < requests.size(); ++i) {
    Truth::Target& target = truth_.targets[i];
    const Position<frame::Machine> place =
        requests[i].work_zero + displacement_mm<frame::Machine>(target.actual.in_mm());
    const auto mark = std::ranges::lower_bound(marks_, place, is_left_of, &Mark::place);
    if (mark == marks_.end() || mark->place != place || mark->features.empty()) continue;
    const Feature& feature = mark->features.front();
    if (feature.shape != Feature::Shape::Ring) continue;
    target.hole_offset = displacement_mm<frame::Actual>(feature.hole_offset.in_mm());
  }
}

std::vector<SimMachine::TargetPlace> SimMachine::targets_at(
    const Position<frame::Machine>& programmed) const {
  const auto left = programmed + displacement_mm<frame::Machine>(-kSamePlace_mm, 0);
  std::vector<TargetPlace> targets;
  for (auto at =
           std::ranges::lower_bound(target_places_, left, is_left_of, &TargetPlace::programmed);
       at != target_places_.end() && (at->programmed - programmed).in_mm().x() <= kSamePlace_mm;
       ++at) {
    if (is_one_place(at->programmed, programmed)) targets.push_back(*at);
  }
  return targets;
}

void SimMachine::drill(const DrilledHole& hole) {
  const auto at = [&](const Eigen::Vector2d& from_zero_mm) {
    return hole.work_zero + displacement_mm<frame::Machine>(from_zero_mm);
  };
  const Position<frame::Machine> programmed = at(hole.nominal.in_mm());
  const std::vector<TargetPlace> targets = targets_at(programmed);
  if (targets.empty()) return;
  const auto standing = stands_at(at(hole.place.in_mm()));
  if (!standing) return;  // off the table: the working walk refuses the hole
  const double sigma_mm =
      std::hypot(sim_.coupon.wander.in_mm(), sim_.coupon.stage_repeatability.in_mm());
  Random random = random_of(
      sim_.seed, RandomStream::Holes, static_cast<std::int64_t>(targets.front().i_target));
  const double x_mm = sigma_mm * random.normal();
  const double y_mm = sigma_mm * random.normal();
  make_hole(programmed, *standing + displacement_mm<frame::Machine>(x_mm, y_mm));
}

void SimMachine::make_hole(const Position<frame::Machine>& programmed,
                           const Position<frame::Machine>& hole) {
  std::optional<Mark> made;
  for (auto mark = marks_.begin(); mark != marks_.end();) {
    if (!is_one_place(mark->programmed, programmed)) {
      ++mark;
      continue;
    }
    if (mark->is_hole) return;
    if (!made) made = std::move(*mark);
    mark = marks_.erase(mark);
  }
  if (!made) return;
  made->place = hole;
  made->is_hole = true;
  marks_.insert(std::ranges::lower_bound(marks_, hole, is_left_of, &Mark::place), *std::move(made));
  for (const TargetPlace& target : targets_at(programmed)) {
    Truth::Target& truth = truth_.targets[target.i_target];
    if (truth.seq <= last_seq_) continue;  // seen before it was drilled
    truth.actual = position_mm<frame::Actual>((hole - target.work_zero).in_mm());
  }
}

SimMachine::Mark SimMachine::make_mark(const MeasurementRequest& request,
                                       const Target& target,
                                       const Position<frame::Machine>& place,
                                       std::size_t i_mark) const {
  internal::SimMarkPlace at_axis;
  at_axis.turn = rotation_of(truth_.actual_from_nominal(request.path));
  at_axis.slot_length = mm(2 * view_radius_mm_);
  Random random = random_of(sim_.seed, RandomStream::Marks, request.seq).fork(i_mark);
  Mark mark;
  mark.place = place;
  mark.features = internal::sim_mark(sim_, target, at_axis, calibrated_camera_, random);
  mark.reach_mm = reach_of(mark.features, at_axis.center).in_mm();
  random = random_of(sim_.seed, RandomStream::Debris, request.seq).fork(i_mark);
  mark.debris = strew_debris(mark.features, sim_.debris, random).features;
  return mark;
}

std::vector<const SimMachine::Mark*> SimMachine::marks_in_view(
    const Position<frame::Machine>& true_axis) const {
  const double reach_mm = view_radius_mm_ + largest_reach_mm_;
  const auto left = displacement_mm<frame::Machine>(-reach_mm, 0);
  std::vector<const Mark*> marks;
  for (auto mark = std::ranges::lower_bound(marks_, true_axis + left, is_left_of, &Mark::place);
       mark != marks_.end();
       ++mark) {
    const Eigen::Vector2d from_axis_mm = (mark->place - true_axis).in_mm();
    if (from_axis_mm.x() > reach_mm) break;
    if (from_axis_mm.norm() <= view_radius_mm_ + mark->reach_mm) marks.push_back(&*mark);
  }
  return marks;
}

/// The real camera as the request's settings and the view's focus make it.
Expected<Camera> SimMachine::camera_for(const MeasurementRequest& request, const View& view) const {
  Camera camera = camera_;
  if (request.settings.zoom) {
    PANELCAL_TRY(const ZoomedCamera zoomed, procedure_.locator().camera_of(request));
    if (zoomed.tilted) {
      return failure(
          {Code::NotSupported,
           {},
           fmt::format("zoom {} is calibrated with a tilt or a lens that is not simulated",
                       *request.settings.zoom),
           "a calibration of scale, rotation, axis and k1"});
    }
    camera.mapping = zoomed.mapping;
    camera.width = zoomed.width_px;
    camera.height = zoomed.height_px;
  }
  camera.blur_px = internal::blur_px_at(sim_, view.focus_z.value_or(stated_focus_), camera);
  return camera;
}

/// Light multiplies all that is seen; the sensor clips what is too bright.
void SimMachine::set_light(const MeasurementRequest& request, Scene& scene) const {
  const std::optional<double> lamp = request.settings.lamp ? request.settings.lamp : stated_lamp_;
  if (!sim_.lamp || !lamp) return;
  scene.lamp = *lamp / *sim_.lamp;
}

Expected<Position<frame::Machine>> SimMachine::stands_at(
    const Position<frame::Machine>& spindle) const {
  std::optional<Position<frame::Machine>> command = spindle;
  if (table_ != nullptr) command = table_->command_for(spindle);
  if (!command) return failure(table_->refusal(spindle));
  if (!sim_.table) return *command;
  return *command + displacement_mm<frame::Machine>(sim_.table->error_mm(*command));
}

Expected<TakenPicture> SimMachine::picture(const MeasurementRequest& request,
                                           const View& view) const {
  PANELCAL_TRY(const Camera camera, camera_for(request, view));
  const Position<frame::Machine> spindle = job_.offset().spindle_to_see(view.axis);
  PANELCAL_TRY(const Position<frame::Machine> standing, stands_at(spindle));
  const Position<frame::Machine> true_axis = true_offset().optical_axis(standing);

  Scene scene = internal::sim_scene(sim_);
  const std::vector<const Mark*> marks = marks_in_view(true_axis);
  for (const Mark* mark : marks) {
    add_shifted(mark->features, mark->place - true_axis, scene.features);
  }
  // Focusing comes before the first target, with its line in place of a seq.
  const std::int64_t seq = request.seq < 0 ? -1 - request.line : request.seq;
  if (request.seq >= 0) {
    PANELCAL_TRY(const Target target, procedure_.locator().target_of(request, view.i_tool));
    internal::add_neighbors(sim_,
                            target,
                            camera,
                            calibrated_camera_,
                            of_view(random_of(sim_.seed, RandomStream::Neighbors, seq), view),
                            scene.features);
  }
  for (const Mark* mark : marks) {
    add_shifted(mark->debris, mark->place - true_axis, scene.features);
  }
  const Transform<frame::Actual, frame::Optical> actual_from_optical(
      Eigen::Matrix2d::Identity(), (true_axis - request.work_zero).in_mm());
  scene.weave.panel_from_optical =
      truth_.actual_from_nominal(request.path).inverse() * actual_from_optical;
  set_light(request, scene);
  Random noise = of_view(random_of(sim_.seed, RandomStream::Noise, seq)
                             .fork(static_cast<std::uint64_t>(view.i_inspection)),
                         view);
  return TakenPicture{render(scene, camera, noise), job_.offset().optical_axis(spindle), "", ""};
}

Expected<TakenPicture> SimMachine::take(const MeasurementRequest& request, const View& view) {
  // Inspections of one view follow each other where the camera stands.
  if (view.i_inspection == 0) now_ = now_ + settle_;
  last_seq_ = std::max(last_seq_, request.seq);
  return picture(request, view);
}

Expected<Measurement> SimMachine::measure(const MeasurementRequest& request, ViewTaker& eye) {
  PANELCAL_TRY(Measurement measurement, procedure_.measure(request, eye));
  return job_.complete(std::move(measurement));
}

Expected<SimCoupon*> SimMachine::coupon_for(const CalibrationOrder& order) {
  PANELCAL_TRY(MachineConfig config, job_.config_at(order));
  config.sim->spindle_camera_offset = warm_offset_.offset;
  if (order.zoom) {
    // As in camera_for: a zoom is what it is calibrated as.
    config.sim->camera.reset();
    config.sim->width_px = config.camera->picture_width_px;
    config.sim->height_px = config.camera->picture_height_px;
  }
  if (coupon_) {
    coupon_->look_through(config);
    return &*coupon_;
  }
  SimCouponOptions options = config.sim->coupon;
  if (config.coupon) options.vision_tool = config.coupon->vision_tool;
  PANELCAL_TRY(coupon_, SimCoupon::create(config, options));
  return &*coupon_;
}

Expected<std::optional<CalibrationAnswer>> SimMachine::calibrate(const CalibrationOrder& order) {
  if (order.correction) return job_.correct(order);
  PANELCAL_TRY(SimCoupon* const coupon, coupon_for(order));
  const std::optional<double> lamp = order.lamp ? order.lamp : stated_lamp_;
  if (lamp) PANELCAL_CHECK(coupon->set(CameraSetting::Lamp, *lamp));
  const Length focus_z = procedure_.focus_z().value_or(stated_focus_);
  PANELCAL_CHECK(coupon->set(CameraSetting::Focus, focus_z.in_mm()));
  coupon->wait(now_ - coupon->now());
  // The machine owns the coupon.
  const auto exact = std::shared_ptr<Stage>(std::shared_ptr<Stage>(), coupon);
  const auto stage = measuring_stage(simulated_stage(exact, sim_.table), table_);
  NotedDrilling drilling(
      *stage, *coupon, [this](const auto& sent_to, const auto& hole) { make_hole(sent_to, hole); });
  CalibrationDevices devices{drilling,
                             drilling,
                             *coupon,
                             [coupon](Time time) { coupon->wait(time); },
                             {},
                             {},
                             [coupon] { return coupon->now(); }};
  devices.taken_by = taken_by_;
  Expected<CalibrationAnswer> answer = job_.calibrate(order, devices);
  now_ = coupon->now();
  if (!answer) return failure(std::move(answer).error());
  return *std::move(answer);
}

}  // namespace panelcal
