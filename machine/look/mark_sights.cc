// SPDX-License-Identifier: Apache-2.0
#include "machine/look/mark_sights.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/correction/spindle_camera.h"
#include "machine/devices/table_stage.h"
#include "vision/locate/locate.h"
#include "vision/picture/files/image_io.h"
#include "vision/picture/picture_form.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Between a mark's rim and the picture's, where the ground beside it must be seen, px.
constexpr double kMarkRim_px = 12;
/// Search radius of a mark, if not stated, as a part of the picture's width.
constexpr double kSearchPart = 0.1;
constexpr int kMaxSightsPerSide = 21;

tl::unexpected<Diagnostic> sight_refused(Code code,
                                         const MachineConfig& config,
                                         std::string what,
                                         std::string expected) {
  return failure({code, {config.file.string(), 0, 0}, std::move(what), std::move(expected)});
}

/// A mark as it is looked for: a circle in the picture, with the size it has on the panel.
struct PixelMark {
  Target target;
  Length radius;  ///< 0: not stated in mm
  double radius_px = 0;
  double scale_mm = 0;  ///< per px at present; 0: not known
};

Expected<PixelMark> mark_of(const MachineConfig& config, const MarkViews& views) {
  const auto found = config.vision_tools.find(views.tool);
  if (found == config.vision_tools.end()) {
    return sight_refused(Code::VisionToolUndefined,
                         config,
                         fmt::format("vision tool {}", views.tool),
                         fmt::format("a [[vision.tool]] with number = {}", views.tool));
  }
  PixelMark mark{found->second, {}, 0, 0};
  Target& target = mark.target;
  if (target.shape != Shape::Disc && target.shape != Shape::Hole && target.shape != Shape::Ring) {
    return sight_refused(
        Code::TargetInvalid,
        config,
        fmt::format("vision tool {} is a {}, and a camera is calibrated with round marks",
                    views.tool,
                    name(target.shape)),
        "a disc, a hole or a ring");
  }
  const CameraCalibration* camera = camera_at(config, views.zoom);
  if (camera != nullptr) mark.scale_mm = camera->parameters.scale_mm_per_px;
  if (target.size) {
    if (camera == nullptr) {
      return sight_refused(
          Code::ConfigValue,
          config,
          fmt::format("vision tool {} has its size in mm, and there is no calibration "
                      "that states how large that appears",
                      views.tool),
          "size_px in the vision tool, or a calibration to begin with");
    }
    mark.radius = 0.5 * *target.size;
    target.size_px = px(target.size->in_mm() / mark.scale_mm);
    if (target.inner_size) target.inner_size_px = px(target.inner_size->in_mm() / mark.scale_mm);
    target.size.reset();
    target.inner_size.reset();
  }
  mark.radius_px = 0.5 * target.size_px->in_px();
  return mark;
}

/// One after another: pictures in, observations out.
class SightCollector {
 public:
  SightCollector(const MachineConfig& config, const PixelMark& mark)
      : config_(config), mark_(mark) {
    sights_.data.dots = {{position_mm<frame::Plate>(0, 0), false, mark.radius}};
  }

  /// Finds the mark near a pixel, or anywhere.
  Detection find(const Image& image, const std::optional<Eigen::Vector2d>& near_px) const {
    LocateOptions options = config_.locate;
    if (near_px) {
      options.search_center = position_px<frame::Image>(*near_px);
      const double reach_px = config_.vision.search_radius && mark_.scale_mm > 0
                                  ? config_.vision.search_radius->in_mm() / mark_.scale_mm
                                  : kSearchPart * image.width();
      options.search_radius = px(reach_px);
    }
    return locate(image, mark_.target, nullptr, options);
  }

  /// Every picture has the size of the first.
  Expected<void> check_size(const Image& image, const std::string& name) {
    if (sights_.width_px == 0) {
      sights_.width_px = image.width();
      sights_.height_px = image.height();
    }
    if (image.width() == sights_.width_px && image.height() == sights_.height_px) return {};
    return failure({Code::PictureMismatch,
                    {name, 0, 0},
                    fmt::format("the picture has {} x {} px", image.width(), image.height()),
                    fmt::format("{} x {} px", sights_.width_px, sights_.height_px)});
  }

  void add(const Position<frame::Machine>& axis, const Detection& seen, const std::string& name) {
    if (seen.status != DetectionStatus::Found) {
      sights_.missed.push_back({name, seen.reason});
      return;
    }
    PositionEstimate<frame::Image> center = seen.best->center;
    // A detector leaves rounding in it.
    center.cov = (0.5 * (center.cov + center.cov.transpose())).eval();
    if (mark_.scale_mm > 0) {
      const double stage_px = config_.walk.uncertainty.stage_repeatability.in_mm() / mark_.scale_mm;
      center.cov += stage_px * stage_px * Eigen::Matrix2d::Identity();
    }
    sights_.data.views.push_back({axis, 0});
    sights_.data.seen.push_back({sights_.data.views.size() - 1, 0, center});
    sights_.names.push_back(name);
  }

  MarkSights& sights() { return sights_; }

 private:
  const MachineConfig& config_;
  const PixelMark& mark_;
  MarkSights sights_;
};

/// The pixels at which the mark is shown, in rows to and fro.
std::vector<Eigen::Vector2d> lattice_px(const CameraCalibration& camera,
                                        double margin_px,
                                        int per_side) {
  const Eigen::Vector2d low_px = Eigen::Vector2d::Constant(margin_px);
  const Eigen::Vector2d high_px(camera.picture_width_px - 1 - margin_px,
                                camera.picture_height_px - 1 - margin_px);
  std::vector<Eigen::Vector2d> pixels;
  for (int row = 0; row < per_side; ++row) {
    for (int i = 0; i < per_side; ++i) {
      const int column = row % 2 == 0 ? i : per_side - 1 - i;
      const Eigen::Vector2d part = Eigen::Vector2d(column, row) / static_cast<double>(per_side - 1);
      pixels.push_back(low_px + part.cwiseProduct(high_px - low_px));
    }
  }
  return pixels;
}

/// Drives, waits, takes.
class Driver {
 public:
  Driver(const MachineConfig& config, const CalibrationDevices& devices, Length approach)
      : config_(config), devices_(devices), approach_(approach) {}

  /// The spindle's place that shows `place` at a displacement K from the axis.
  Position<frame::Machine> spindle_for(const Position<frame::Machine>& place,
                                       const Eigen::Vector2d& from_axis_mm) const {
    return config_.spindle_camera.spindle_to_see(place -
                                                 displacement_mm<frame::Machine>(from_axis_mm));
  }
  Position<frame::Machine> start_of(const Position<frame::Machine>& spindle) const {
    return spindle - displacement_mm<frame::Machine>(Eigen::Vector2d::Constant(approach_.in_mm()));
  }
  Expected<void> check(const Position<frame::Machine>& spindle) const {
    for (const Position<frame::Machine>& stop : {start_of(spindle), spindle}) {
      PANELCAL_CHECK(check_travel(config_,
                                  stop,
                                  {config_.file.string(), 0, 0},
                                  "a calibration of the camera sends the spindle to"));
    }
    return {};
  }

  struct Taken {
    Image image;
    Position<frame::Machine> axis;
  };
  Expected<Taken> take(const Position<frame::Machine>& spindle) const {
    PANELCAL_CHECK(check(spindle));
    PANELCAL_CHECK(devices_.stage.move_to(start_of(spindle)));
    PANELCAL_TRY(const Position<frame::Machine> standing, devices_.stage.move_to(spindle));
    if (devices_.wait) devices_.wait(config_.settle);
    PANELCAL_TRY(Image image, devices_.camera.take());
    return Taken{std::move(image), config_.spindle_camera.optical_axis(standing)};
  }

  Expected<void> set_zoom(const std::optional<double>& zoom) const {
    if (!zoom) return {};
    if (devices_.camera.can_set(CameraSetting::Zoom)) {
      return devices_.camera.set(CameraSetting::Zoom, *zoom);
    }
    return devices_.stage.set(CameraSetting::Zoom, *zoom);
  }

 private:
  const MachineConfig& config_;
  const CalibrationDevices& devices_;
  Length approach_;
};

Expected<void> check_views(const MachineConfig& config, const MarkViews& views) {
  if (views.per_side >= 3 && views.per_side <= kMaxSightsPerSide) return {};
  return sight_refused(Code::ConfigValue,
                       config,
                       fmt::format("a lattice of {} views along each side", views.per_side),
                       fmt::format("3 to {}", kMaxSightsPerSide));
}

Expected<void> check_camera_size(const Image& image,
                                 const CameraCalibration& camera,
                                 const std::string& name) {
  if (image.width() == camera.picture_width_px && image.height() == camera.picture_height_px) {
    return {};
  }
  return failure({Code::PictureMismatch,
                  {name, 0, 0},
                  fmt::format("the picture has {} x {} px", image.width(), image.height()),
                  fmt::format("{} x {} px, for which [camera] is calibrated",
                              camera.picture_width_px,
                              camera.picture_height_px)});
}

/// True place of the mark, from a picture taken at the expected place.
Expected<Position<frame::Machine>> find_mark(const MachineConfig& config,
                                             const CameraCalibration& camera,
                                             const Driver& driver,
                                             const SightCollector& collector,
                                             const Position<frame::Machine>& place) {
  PANELCAL_TRY(const Driver::Taken taken,
               driver.take(driver.spindle_for(place, Eigen::Vector2d::Zero())));
  PANELCAL_CHECK(check_camera_size(taken.image, camera, config.file.string()));
  const CameraModel model = camera.model();
  const auto middle = model.image_of(position_mm<frame::Optical>((place - taken.axis).in_mm()));
  const auto near_px = middle ? std::optional<Eigen::Vector2d>(middle->in_px()) : std::nullopt;
  const Detection seen = collector.find(taken.image, near_px);
  if (seen.status != DetectionStatus::Found || !model.sees(seen.best->center.position)) {
    return sight_refused(
        Code::TargetNotFound,
        config,
        fmt::format("there is no mark to calibrate the camera with at ({:.3f}, {:.3f}) "
                    "mm: {}",
                    place.in_mm().x(),
                    place.in_mm().y(),
                    seen.reason.empty() ? "it is out of sight" : seen.reason),
        "a mark of the vision tool there");
  }
  return machine_from_optical(taken.axis, model(seen.best->center.position));
}

/// True if a recorded picture is one of those asked for.
bool is_wanted(const PictureRow& row, const MarkViews& views) {
  if (row.tool && *row.tool != views.tool) return false;
  return row.zoom == views.zoom;
}

}  // namespace

const CameraCalibration* camera_at(const MachineConfig& config, const std::optional<double>& zoom) {
  if (!zoom) return config.camera ? &*config.camera : nullptr;
  const auto found = config.zooms.find(*zoom);
  return found == config.zooms.end() ? nullptr : &found->second;
}

bool is_in_travel(const MachineConfig& config, const Position<frame::Machine>& spindle) {
  const Eigen::Vector2d& p_mm = spindle.in_mm();
  if (!p_mm.allFinite()) return false;
  return !config.travel || ((p_mm - config.travel->low.in_mm()).minCoeff() >= 0 &&
                            (config.travel->high.in_mm() - p_mm).minCoeff() >= 0);
}

Expected<void> check_travel(const MachineConfig& config,
                            const Position<frame::Machine>& spindle,
                            Place at,
                            std::string_view what,
                            std::string expected) {
  if (is_in_travel(config, spindle)) return {};
  const Eigen::Vector2d& p_mm = spindle.in_mm();
  return failure({Code::TravelExceeded,
                  std::move(at),
                  fmt::format("{} ({:.3f}, {:.3f}) mm", what, p_mm.x(), p_mm.y()),
                  std::move(expected)});
}

Expected<MarkSights> look_at_mark(const MachineConfig& config,
                                  const CalibrationDevices& devices,
                                  const Position<frame::Machine>& place,
                                  const MarkViews& views) {
  PANELCAL_CHECK(check_views(config, views));
  const CameraCalibration* camera = camera_at(config, views.zoom);
  if (camera == nullptr) {
    return sight_refused(Code::ConfigValue,
                         config,
                         views.zoom
                             ? fmt::format("zoom {} has no calibration to begin with", *views.zoom)
                             : "[camera] is missing, which states how far to drive",
                         "a calibration to begin with, or recorded pictures");
  }
  PANELCAL_TRY(const PixelMark mark, mark_of(config, views));
  const Driver driver(config, devices, views.approach_distance);
  const CameraModel model = camera->model();
  const auto pixels = lattice_px(*camera, mark.radius_px + kMarkRim_px, views.per_side);
  for (const Eigen::Vector2d& pixel : pixels) {
    const Eigen::Vector2d from_axis_mm = model(position_px<frame::Image>(pixel)).in_mm();
    PANELCAL_CHECK(driver.check(driver.spindle_for(place, from_axis_mm)));
  }
  SightCollector collector(config, mark);
  PANELCAL_CHECK(driver.set_zoom(views.zoom));
  PANELCAL_TRY(const Position<frame::Machine> lies,
               find_mark(config, *camera, driver, collector, place));
  for (const Eigen::Vector2d& pixel : pixels) {
    const Eigen::Vector2d from_axis_mm = model(position_px<frame::Image>(pixel)).in_mm();
    PANELCAL_TRY(const Driver::Taken taken, driver.take(driver.spindle_for(lies, from_axis_mm)));
    const Eigen::Vector2d& axis_mm = taken.axis.in_mm();
    const std::string name = fmt::format("({:.3f}, {:.3f}) mm", axis_mm.x(), axis_mm.y());
    PANELCAL_CHECK(collector.check_size(taken.image, config.file.string()));
    collector.add(taken.axis, collector.find(taken.image, pixel), name);
  }
  return std::move(collector.sights());
}

Expected<MarkSights> look_at_folder(const MachineConfig& config,
                                    const PictureFolder& folder,
                                    const MarkViews& views) {
  PANELCAL_TRY(const PixelMark mark, mark_of(config, views));
  SightCollector collector(config, mark);
  for (const PictureRow& row : folder.rows) {
    if (!is_wanted(row, views)) {
      ++collector.sights().n_skipped;
      continue;
    }
    const std::string path = folder.path_of(row).string();
    PANELCAL_TRY(const std::string bytes, read_file(path));
    PANELCAL_TRY(Image image, decode_image(bytes, path));
    image = understood(std::move(image), config.picture_form);
    PANELCAL_CHECK(collector.check_size(image, path));
    collector.sights().inputs.push_back({row.file, sha256(bytes), bytes.size()});
    collector.add(row.axis, collector.find(image, std::nullopt), row.file);
  }
  PANELCAL_CHECK(correct_views(config, collector.sights()));
  return std::move(collector.sights());
}

std::string pictures_report(const std::vector<MissedPicture>& left_out,
                            const std::vector<std::string>& without_tag) {
  std::string text;
  for (const MissedPicture& picture : left_out) {
    text += fmt::format("  without {}: {}\n", picture.picture, picture.reason);
  }
  if (without_tag.empty()) return text;
  return text + fmt::format(
                    "  pictures without a tag: {} (from {}); where the axis stood there is "
                    "not checked\n",
                    without_tag.size(),
                    without_tag.front());
}

Expected<void> correct_views(const MachineConfig& config, MarkSights& sights) {
  for (PlateView& view : sights.data.views) {
    PANELCAL_TRY(view.axis_at, axis_from_listed(config, view.axis_at));
  }
  return {};
}

}  // namespace panelcal
