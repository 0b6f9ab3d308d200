// SPDX-License-Identifier: Apache-2.0
#include "machine/plate/pictures.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include "calib/base/digest.h"
#include "calib/camera/circle_bias.h"
#include "calib/correction/spindle_camera.h"
#include "machine/plate/fit.h"
#include "machine/plate/tag_looks.h"
#include "vision/locate/locate.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::PlacePair;

/// Between a dot's rim and the picture's, px.
constexpr double kDotRim_px = 10;
/// How far a dot may be from where it is expected, as a part of the pitch: less than half, or it is
/// taken for its neighbour.
constexpr double kDotReach = 0.3;
/// Dots nearer together say nothing of a pose's angle, as a part of the pitch; two neighbours do.
constexpr double kLeastLever = 0.63;
/// Tags say where dots are to this part of the pitch; more says that the file has them elsewhere.
constexpr double kMostBesideTags = 0.25;
/// Dots of one pose may be so far from it, rms and as a part of the pitch; a stage errs by less,
/// and more says that some were taken for their neighbours or that the axis was elsewhere.
constexpr double kMostScatter = 0.1;

/// From where every stop over a plate is come to.
Displacement<frame::Machine> plate_approach() {
  return displacement_mm<frame::Machine>(1, 1);
}
/// Along each side at most this number of dots is driven to.
constexpr int kMostStops = 15;

/// The dots that are driven to, row by row.
std::vector<PlateDot> stops_of(const CalibrationPlate& plate) {
  const std::vector<PlateDot> dots = plate.dots();
  const int every_column = (plate.columns + kMostStops - 1) / kMostStops;
  const int every_row = (plate.rows + kMostStops - 1) / kMostStops;
  std::vector<PlateDot> stops;
  for (int row = 0; row < plate.rows; row += every_row) {
    for (int column = 0; column < plate.columns; column += every_column) {
      stops.push_back(dots[plate.index(column, row)]);
    }
  }
  return stops;
}

/// Goes through the pictures of all poses.
class PlateLooks {
 public:
  PlateLooks(const MachineConfig& config,
             const CalibrationPlate& plate,
             const CameraCalibration& camera,
             const std::optional<double>& zoom)
      : config_(config),
        plate_(plate),
        camera_(camera),
        model_(camera.model()),
        zoom_(zoom),
        is_covered_(plate.covered_dots()) {
    const double scale_mm = camera.parameters.scale_mm_per_px;
    target_.shape = Shape::Disc;
    target_.polarity = plate.is_dark ? Polarity::Dark : Polarity::Bright;
    target_.size_px = px(plate.dot_diameter.in_mm() / scale_mm);
    options_ = config.locate;
    options_.search_radius = px(kDotReach * plate.pitch.in_mm() / scale_mm);
    stage_px2_ = config.walk.uncertainty.stage_mm2() / (scale_mm * scale_mm);
    sights_.data.dots = plate.dots();
    sights_.width_px = camera.picture_width_px;
    sights_.height_px = camera.picture_height_px;
  }

  Expected<void> add(const PictureFolder& folder, std::size_t i_pose) {
    const auto n_of_zoom = std::ranges::count(folder.rows, zoom_, &PictureRow::zoom);
    sights_.n_skipped += static_cast<int>(std::ssize(folder.rows) - n_of_zoom);
    if (n_of_zoom == 0) return {};
    PANELCAL_TRY(const internal::TaggedPose start, begin(folder, i_pose));
    PlatePose pose = start.pose;
    std::vector<PlacePair> pairs;
    for (std::size_t i = 0; i < folder.rows.size(); ++i) {
      const PictureRow& row = folder.rows[i];
      if (row.zoom != zoom_) continue;
      PANELCAL_TRY(const internal::PlatePicture picture,
                   internal::read_plate_picture(config_, camera_, folder.path_of(row)));
      const std::string name = name_of(folder, row);
      // Those that are left out, too: their tags had a say in how the plate lay.
      sights_.inputs.push_back({name, sha256(picture.bytes), picture.bytes.size()});
      const auto contradicts = std::ranges::find(
          start.contradictions, i, &internal::TaggedPose::Contradiction::i_picture);
      if (contradicts != start.contradictions.end()) {
        sights_.left_out.push_back({name, contradicts->why});
        continue;
      }
      if (plate_.tags && std::ranges::count(start.agreeing, i) == 0) {
        sights_.without_tag.push_back(name);
      }
      add_picture(picture.image, name, row, pose, pairs);
      pose = internal::best_pose(pairs, pose, kLeastLever * plate_.pitch);
    }
    ++n_poses_;
    if (plate_.tags) PANELCAL_CHECK(check_tags(folder, i_pose, start.pose, pairs));
    return check_scatter(folder, i_pose, pose, pairs);
  }

  /// Drives over a plate that lies as its first pose says.
  Expected<void> drive(const CalibrationDevices& devices) {
    PlatePose pose = plate_.poses.front();
    const std::vector<PlateDot> stops = stops_of(plate_);
    PANELCAL_CHECK(check_plate_travel(config_, plate_));
    std::vector<PlacePair> pairs;
    for (const PlateDot& stop : stops) {
      const auto spindle =
          config_.spindle_camera.spindle_to_see(place_in(plate_.poses.front(), stop.place));
      PANELCAL_CHECK(devices.stage.move_to(spindle - plate_approach()));
      PANELCAL_TRY(const Position<frame::Machine> standing, devices.stage.move_to(spindle));
      if (devices.wait) devices.wait(config_.settle);
      PANELCAL_TRY(const Image image, devices.camera.take());
      PANELCAL_CHECK(check_size(image));
      PictureRow row;
      row.axis = config_.spindle_camera.optical_axis(standing);
      const Eigen::Vector2d& axis_mm = row.axis.in_mm();
      add_picture(
          image, fmt::format("({:.3f}, {:.3f}) mm", axis_mm.x(), axis_mm.y()), row, pose, pairs);
      pose = internal::best_pose(pairs, pose, kLeastLever * plate_.pitch);
    }
    ++n_poses_;
    return check_scatter({plate_.file, {}}, 0, pose, pairs);
  }

  MarkSights& sights() { return sights_; }

 private:
  Expected<void> check_size(const Image& image) const {
    if (image.width() == camera_.picture_width_px && image.height() == camera_.picture_height_px) {
      return {};
    }
    return failure({Code::PictureMismatch,
                    {config_.file.string(), 0, 0},
                    fmt::format("a picture is {} x {} px", image.width(), image.height()),
                    fmt::format("{} x {} px, for which [camera] is calibrated",
                                camera_.picture_width_px,
                                camera_.picture_height_px)});
  }

  static std::string name_of(const PictureFolder& folder, const PictureRow& row) {
    return folder.folder.filename().string() + "/" + row.file;
  }

  /// How the plate lay, as its tags or its file say.
  Expected<internal::TaggedPose> begin(const PictureFolder& folder, std::size_t i_pose) const {
    if (!plate_.tags) return internal::TaggedPose{plate_.poses[i_pose], {}, {}};
    return internal::look_at_tags(config_, plate_, camera_, folder, zoom_);
  }

  /// Refuses dots that lie elsewhere on the plate than its tags say.
  Expected<void> check_tags(const PictureFolder& folder,
                            std::size_t i_pose,
                            const PlatePose& pose,
                            const std::vector<PlacePair>& pairs) const {
    const Length beside = internal::rms_from(pose, pairs);
    if (beside <= kMostBesideTags * plate_.pitch) return {};
    return failure({Code::CalibrationData,
                    {folder.folder.string(), 0, 0},
                    fmt::format("the dots of pose {} are {:.3f} mm rms beside where the tags "
                                "have them",
                                i_pose,
                                beside.in_mm()),
                    fmt::format("less than {:.3f} mm; are their places in [tags] right?",
                                kMostBesideTags * plate_.pitch.in_mm())});
  }

  Expected<void> check_scatter(const PictureFolder& folder,
                               std::size_t i_pose,
                               const PlatePose& pose,
                               const std::vector<PlacePair>& pairs) const {
    const double scatter_mm = internal::rms_from(pose, pairs).in_mm();
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

  void add_picture(const Image& image,
                   const std::string& name,
                   const PictureRow& row,
                   const PlatePose& pose,
                   std::vector<PlacePair>& pairs) {
    const std::size_t i_view = sights_.data.views.size();
    sights_.data.views.push_back({row.axis, n_poses_});
    sights_.names.push_back(name);
    for (std::size_t i_dot = 0; i_dot < sights_.data.dots.size(); ++i_dot) {
      if (!is_covered_[i_dot]) look(image, i_view, i_dot, pose, pairs);
    }
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
    const double margin_px = 0.5 * target_.size_px->in_px() + kDotRim_px;
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
            std::vector<PlacePair>& pairs) {
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
  std::vector<bool> is_covered_;  ///< by a tag: such a dot is not there
  std::size_t n_poses_ = 0;       ///< with pictures: the fit numbers them without gaps
  MarkSights sights_;
};

tl::unexpected<Diagnostic> picture_refused(Code code,
                                           const std::filesystem::path& file,
                                           std::string what,
                                           std::string expected) {
  return failure({code, {file.string(), 0, 0}, std::move(what), std::move(expected)});
}

}  // namespace

Expected<std::vector<PictureFolder>> read_plate_folders(const std::filesystem::path& folder,
                                                        const CalibrationPlate& plate) {
  if (plate.poses.empty() && !plate.tags) {
    return picture_refused(Code::ConfigValue,
                           plate.file,
                           "the pose of the plate is missing, without which its dots look alike",
                           "[[pose]] origin_mm, angle_deg; or [tags]");
  }
  const auto has_list = [](const std::filesystem::path& of) {
    std::error_code ignored;
    return std::filesystem::exists(of / "images.csv", ignored);
  };
  std::vector<PictureFolder> folders;
  std::size_t n = plate.poses.size();
  if (n == 0) {
    while (has_list(folder / std::to_string(n))) ++n;
  }
  if (n == 0 || has_list(folder)) {
    PANELCAL_TRY(folders.emplace_back(), read_picture_folder(folder));
    return folders;
  }
  for (std::size_t i = 0; i < n; ++i) {
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
    return picture_refused(Code::ConfigValue,
                           config.file,
                           "a calibration of the camera is missing, without which the places of "
                           "the dots are not known",
                           zoom ? "[[camera.zoom]] of this level" : "[camera] calibration");
  }
  if (!(plate.dot_diameter > Length())) {
    return picture_refused(Code::ConfigValue,
                           plate.file,
                           "[plate] has no dot_diameter_mm, by which dots are found in pictures",
                           "dot_diameter_mm");
  }
  PlateLooks looks(config, plate, *camera, zoom);
  const std::size_t n = plate.tags ? poses.size() : std::min(poses.size(), plate.poses.size());
  for (std::size_t i = 0; i < n; ++i) PANELCAL_CHECK(looks.add(poses[i], i));
  if (!looks.sights().data.seen.empty()) return std::move(looks.sights());
  const auto& missed = looks.sights().missed;
  return picture_refused(Code::CalibrationData,
                         plate.file,
                         missed.empty()
                             ? std::string("no picture shows a place where a dot should be")
                             : fmt::format("no dot was found: {}", missed.front().reason),
                         plate.tags ? "dots where [plate] and [tags] have them"
                                    : "a [[pose]] that is right to a quarter of the pitch");
}

Expected<MarkSights> look_at_plate(const MachineConfig& config,
                                   const CalibrationDevices& devices,
                                   const CalibrationPlate& plate) {
  if (!config.camera) {
    return picture_refused(
        Code::ConfigValue, config.file, "there is no [camera]", "[camera] calibration");
  }
  if (!(plate.dot_diameter > Length()) || plate.poses.empty()) {
    return picture_refused(Code::ConfigValue,
                           plate.file,
                           "the diameter of the dots and the pose of the plate are missing",
                           "dot_diameter_mm and a [[pose]]");
  }
  PlateLooks looks(config, plate, *config.camera, std::nullopt);
  PANELCAL_CHECK(looks.drive(devices));
  if (!looks.sights().data.seen.empty()) return std::move(looks.sights());
  return picture_refused(Code::CalibrationData,
                         plate.file,
                         "no dot was found",
                         "a [[pose]] that is right to a quarter of the pitch");
}

Expected<void> check_plate_travel(const MachineConfig& config, const CalibrationPlate& plate) {
  for (const PlateDot& stop : stops_of(plate)) {
    const Position<frame::Machine> spindle =
        config.spindle_camera.spindle_to_see(place_in(plate.poses.front(), stop.place));
    if (is_in_travel(config, spindle) && is_in_travel(config, spindle - plate_approach())) continue;
    const Eigen::Vector2d& p_mm = spindle.in_mm();
    return failure(
        {Code::TravelExceeded,
         {plate.file.string(), 0, 0},
         fmt::format("a dot sends the spindle to ({:.3f}, {:.3f}) mm", p_mm.x(), p_mm.y()),
         "a plate all of whose dots can be seen within [machine] travel"});
  }
  return {};
}

TableSights table_sights(const MachineConfig& config, const MarkSights& seen) {
  const CameraModel model = config.camera->model();
  TableSights sights;
  sights.inputs = seen.inputs;
  sights.left_out = seen.left_out;
  sights.without_tag = seen.without_tag;
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
