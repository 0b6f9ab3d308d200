// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/plate_pictures.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/base/digest.h"
#include "panelcal/calib/circle_bias.h"
#include "panelcal/calib/spindle_camera.h"
#include "panelcal/vision/bayer.h"
#include "panelcal/vision/image_io.h"
#include "panelcal/vision/locate.h"

namespace panelcal {
namespace {

/// Between a dot's rim and the picture's, px.
constexpr double kRim_px = 10;
/// How far a dot may be from where it is expected, as a part of the pitch: less than half, or it is
/// taken for its neighbour.
constexpr double kReach = 0.3;
/// Dots of one pose may be so far from it, rms and as a part of the pitch; a stage errs by less,
/// and more says that some were taken for their neighbours or that the axis was elsewhere.
constexpr double kMostScatter = 0.1;

/// A pair of places that are the same: on the plate, and on the machine.
struct Pair {
  Eigen::Vector2d plate_mm;
  Eigen::Vector2d machine_mm;
};

/// The rigid motion that carries one onto the other best; as it was if there is too little.
PlatePose refined(const std::vector<Pair>& pairs, const PlatePose& pose, double pitch_mm) {
  Eigen::Vector2d plate_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d machine_mm = Eigen::Vector2d::Zero();
  for (const Pair& pair : pairs) {
    plate_mm += pair.plate_mm / static_cast<double>(pairs.size());
    machine_mm += pair.machine_mm / static_cast<double>(pairs.size());
  }
  double dot = 0;
  double cross = 0;
  double lever_mm2 = 0;
  for (const Pair& pair : pairs) {
    const Eigen::Vector2d a = pair.plate_mm - plate_mm;
    const Eigen::Vector2d b = pair.machine_mm - machine_mm;
    dot += a.dot(b);
    cross += a.x() * b.y() - a.y() * b.x();
    lever_mm2 += a.squaredNorm();
  }
  PlatePose out = pose;
  if (lever_mm2 > 0.4 * pitch_mm * pitch_mm) out.angle_rad = std::atan2(cross, dot);
  const double c = std::cos(out.angle_rad);
  const double s = std::sin(out.angle_rad);
  out.shift_mm = machine_mm - Eigen::Vector2d(c * plate_mm.x() - s * plate_mm.y(),
                                              s * plate_mm.x() + c * plate_mm.y());
  return out;
}

/// How far dots are from where a pose has them, rms.
double rms_mm(const std::vector<Pair>& pairs, const PlatePose& pose) {
  double sum_mm2 = 0;
  for (const Pair& pair : pairs) {
    const auto lies = place_in(pose, position_mm<frame::Plate>(pair.plate_mm));
    sum_mm2 += (lies.in_mm() - pair.machine_mm).squaredNorm();
  }
  return pairs.empty() ? 0 : std::sqrt(sum_mm2 / static_cast<double>(pairs.size()));
}

/// Goes through the pictures of all poses.
class PlateLooks {
 public:
  PlateLooks(const MachineConfig& config,
             const CalibrationPlate& plate,
             const CameraCalibration& camera,
             const std::optional<double>& zoom)
      : config_(config), plate_(plate), camera_(camera), model_(camera.model()), zoom_(zoom) {
    const double scale_mm = camera.parameters.scale_mm_per_px;
    target_.shape = Shape::Disc;
    target_.polarity = plate.is_dark ? Polarity::Dark : Polarity::Bright;
    target_.size_px = px(plate.dot_diameter.in_mm() / scale_mm);
    options_ = config.locate;
    options_.search_radius = px(kReach * plate.pitch.in_mm() / scale_mm);
    stage_px2_ = config.walk.uncertainty.stage_mm2() / (scale_mm * scale_mm);
    sights_.data.dots = plate.dots();
    sights_.width_px = camera.picture_width_px;
    sights_.height_px = camera.picture_height_px;
  }

  Expected<void> add(const PictureFolder& folder, std::size_t i_pose, PlatePose pose) {
    std::vector<Pair> pairs;
    for (const PictureRow& row : folder.rows) {
      if (row.zoom != zoom_) {
        ++sights_.n_skipped;
        continue;
      }
      PANELCAL_CHECK(add_picture(folder, row, i_pose, pose, pairs));
      if (!pairs.empty()) pose = refined(pairs, pose, plate_.pitch.in_mm());
    }
    const double scatter_mm = rms_mm(pairs, pose);
    if (scatter_mm <= kMostScatter * plate_.pitch.in_mm()) return {};
    return failure(
        {Code::CalibrationData,
         {folder.folder.string(), 0, 0},
         fmt::format("the dots of pose {} are {:.3f} mm rms beside where one plate would "
                     "have them",
                     i_pose,
                     scatter_mm),
         fmt::format("less than {:.3f} mm; are x, y of images.csv where the axis stood?",
                     kMostScatter * plate_.pitch.in_mm())});
  }

  MarkSights& sights() { return sights_; }

 private:
  Expected<void> add_picture(const PictureFolder& folder,
                             const PictureRow& row,
                             std::size_t i_pose,
                             const PlatePose& pose,
                             std::vector<Pair>& pairs) {
    const std::string path = folder.path_of(row).string();
    PANELCAL_TRY(const std::string bytes, read_file(path));
    PANELCAL_TRY(Image image, decode_image(bytes, path));
    if (config_.bayer) image = from_bayer(image, *config_.bayer);
    if (image.width() != camera_.picture_width_px || image.height() != camera_.picture_height_px) {
      return failure({Code::PictureMismatch,
                      {path, 0, 0},
                      fmt::format("the picture has {} x {} px", image.width(), image.height()),
                      fmt::format("{} x {} px, for which [camera] is calibrated",
                                  camera_.picture_width_px,
                                  camera_.picture_height_px)});
    }
    const std::string name = folder.folder.filename().string() + "/" + row.file;
    sights_.inputs.push_back({name, sha256(bytes), bytes.size()});
    const std::size_t i_view = sights_.data.views.size();
    sights_.data.views.push_back({row.axis, i_pose});
    sights_.names.push_back(name);
    for (std::size_t i_dot = 0; i_dot < sights_.data.dots.size(); ++i_dot) {
      look(image, i_view, i_dot, pose, pairs);
    }
    return {};
  }

  /// Where a dot should be in the picture, if all of it is in there.
  std::optional<Position<frame::Image>> expected_at(const Position<frame::Machine>& lies,
                                                    const Position<frame::Machine>& axis) const {
    const Eigen::Vector2d from_axis_mm = (lies - axis).in_mm();
    const double view_mm = std::hypot(camera_.picture_width_px, camera_.picture_height_px) *
                           camera_.parameters.scale_mm_per_px;
    // Newton's method need not be asked about a dot at the plate's other end.
    if (from_axis_mm.norm() > view_mm) return std::nullopt;
    const auto pixel = model_.image_of(position_mm<frame::Optical>(from_axis_mm));
    if (!pixel) return std::nullopt;
    const double margin_px = 0.5 * target_.size_px->in_px() + kRim_px;
    const Eigen::Vector2d& u_px = pixel->in_px();
    const bool is_whole = u_px.minCoeff() >= margin_px &&
                          u_px.x() <= camera_.picture_width_px - 1 - margin_px &&
                          u_px.y() <= camera_.picture_height_px - 1 - margin_px;
    return is_whole ? pixel : std::nullopt;
  }

  void look(const Image& image,
            std::size_t i_view,
            std::size_t i_dot,
            const PlatePose& pose,
            std::vector<Pair>& pairs) {
    const PlateDot& dot = sights_.data.dots[i_dot];
    const Position<frame::Machine>& axis = sights_.data.views[i_view].axis_at;
    const auto pixel = expected_at(place_in(pose, dot.place), axis);
    if (!pixel) return;
    LocateOptions options = options_;
    options.search_center = *pixel;
    const Detection seen = locate(image, target_, nullptr, options);
    if (seen.status != DetectionStatus::Found || !model_.sees(seen.best->center.position)) {
      sights_.missed.push_back({fmt::format("{}, dot ({}, {})",
                                            sights_.names[i_view],
                                            i_dot % static_cast<std::size_t>(plate_.columns),
                                            i_dot / static_cast<std::size_t>(plate_.columns)),
                                seen.reason.empty() ? "out of sight" : seen.reason});
      return;
    }
    PositionEstimate<frame::Image> center = seen.best->center;
    // A detector leaves rounding in it.
    center.cov = (0.5 * (center.cov + center.cov.transpose()) + stage_px2_).eval();
    pairs.push_back(
        {dot.place.in_mm(), machine_from_optical(axis, model_(center.position)).in_mm()});
    sights_.data.seen.push_back({i_view, i_dot, center});
  }

  const MachineConfig& config_;
  const CalibrationPlate& plate_;
  const CameraCalibration& camera_;
  CameraModel model_;
  std::optional<double> zoom_;
  Target target_;
  LocateOptions options_;
  Eigen::Matrix2d stage_px2_;
  MarkSights sights_;
};

tl::unexpected<Diagnostic> refused(Code code,
                                   const std::filesystem::path& file,
                                   std::string what,
                                   std::string expected) {
  return failure({code, {file.string(), 0, 0}, std::move(what), std::move(expected)});
}

}  // namespace

Expected<std::vector<PictureFolder>> read_plate_folders(const std::filesystem::path& folder,
                                                        const CalibrationPlate& plate) {
  if (plate.poses.empty()) {
    return refused(Code::ConfigValue,
                   plate.file,
                   "nothing says how the plate lay, so that its dots could be told apart",
                   "[[pose]] origin_mm, angle_deg");
  }
  std::vector<PictureFolder> folders;
  std::error_code ignored;
  if (std::filesystem::exists(folder / "images.csv", ignored)) {
    PANELCAL_TRY(folders.emplace_back(), read_picture_folder(folder));
    return folders;
  }
  for (std::size_t i = 0; i < plate.poses.size(); ++i) {
    PANELCAL_TRY(folders.emplace_back(), read_picture_folder(folder / std::to_string(i)));
  }
  return folders;
}

Expected<MarkSights> look_at_plate(const MachineConfig& config,
                                   const CalibrationPlate& plate,
                                   const std::vector<PictureFolder>& poses,
                                   const std::optional<double>& zoom) {
  const CameraCalibration* camera = camera_at(config, zoom);
  if (camera == nullptr) {
    return refused(Code::ConfigValue,
                   config.file,
                   "there is no calibration of the camera that says where dots are expected",
                   zoom ? "[[camera.zoom]] of this level" : "[camera] calibration");
  }
  if (!(plate.dot_diameter > Length())) {
    return refused(Code::ConfigValue,
                   plate.file,
                   "[plate] has no dot_diameter_mm, by which dots are found in pictures",
                   "dot_diameter_mm");
  }
  PlateLooks looks(config, plate, *camera, zoom);
  for (std::size_t i = 0; i < std::min(poses.size(), plate.poses.size()); ++i) {
    PANELCAL_CHECK(looks.add(poses[i], i, plate.poses[i]));
  }
  if (!looks.sights().data.seen.empty()) return std::move(looks.sights());
  const auto& missed = looks.sights().missed;
  return refused(Code::CalibrationData,
                 plate.file,
                 missed.empty() ? std::string("no picture shows a place where a dot should be")
                                : fmt::format("no dot was found: {}", missed.front().reason),
                 "a [[pose]] that is right to a quarter of the pitch");
}

TableSights table_sights(const MachineConfig& config, const MarkSights& seen) {
  const CameraModel model = config.camera->model();
  TableSights sights;
  sights.inputs = seen.inputs;
  sights.data.dots = seen.data.dots;
  for (const PlateView& view : seen.data.views) {
    sights.data.views.push_back({config.spindle_camera.spindle_to_see(view.axis_at), view.i_pose});
  }
  for (const CameraObservation& look : seen.data.seen) {
    PositionEstimate<frame::Image> center = look.seen;
    center.position =
        center.position - circle_bias(model, center.position, seen.data.dots[look.i_dot].radius);
    if (!model.sees(center.position)) continue;
    PositionEstimate<frame::Optical> place = model(center);
    place.cov = (0.5 * (place.cov + place.cov.transpose())).eval();
    sights.data.seen.push_back({look.i_view, look.i_dot, place});
  }
  return sights;
}

}  // namespace panelcal
