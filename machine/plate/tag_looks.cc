// SPDX-License-Identifier: Apache-2.0
#include "machine/plate/tag_looks.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/camera/model.h"
#include "calib/correction/spindle_camera.h"
#include "vision/picture/files/image_io.h"
#include "vision/picture/picture_form.h"
#include "vision/tag/read_tags.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Tags of another size are not the plate's. Wide enough for a camera that is to be calibrated.
constexpr double kMostSizeError = 0.15;

Target tag_target(const PlateTags& tags, double scale_mm_per_px) {
  Target target;
  target.shape = Shape::AprilTag;
  target.polarity = tags.polarity;
  target.tag_family = tags.family;
  target.size_px = px(tags.size.in_mm() / scale_mm_per_px);
  return target;
}

/// Places of the corners of a tag; empty where the camera does not see one.
std::optional<TagSight> sight_of(const ReadTag& tag,
                                 const CameraModel& model,
                                 const Position<frame::Machine>& axis) {
  TagSight sight;
  sight.id = tag.id;
  for (std::size_t i = 0; i < tag.corners.size(); ++i) {
    if (!model.sees(tag.corners[i])) return std::nullopt;
    sight.corners[i] = machine_from_optical(axis, model(tag.corners[i]));
  }
  return sight;
}

double side_mm(const TagSight& sight) {
  double sum_mm = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    sum_mm += (sight.corners[(i + 1) % 4] - sight.corners[i]).in_mm().norm();
  }
  return sum_mm / 4;
}

/// Refuses pictures without a tag that follow from a single one with tags, against which nothing is
/// held.
Expected<void> check_followed(const TaggedPose& pose,
                              const PictureFolder& folder,
                              const std::optional<double>& zoom) {
  if (pose.agreeing.size() > 1) return {};
  const auto n_of_zoom =
      static_cast<std::size_t>(std::ranges::count(folder.rows, zoom, &PictureRow::zoom));
  const std::size_t n_without = n_of_zoom - pose.agreeing.size() - pose.contradictions.size();
  if (n_without == 0) return {};
  const std::string shows =
      pose.agreeing.empty() ? std::string("in no picture all tags agree with the others")
                            : "only " + folder.rows[pose.agreeing.front()].file + " shows a tag";
  return failure({Code::CalibrationData,
                  {},
                  fmt::format("{}, so that nothing checks where the axis stood there; pictures "
                              "without a tag that would follow: {}",
                              shows,
                              n_without),
                  "tags that agree in two pictures or more"});
}

Expected<TaggedPose> pose_of(const CalibrationPlate& plate,
                             const std::vector<TagSight>& sights,
                             const PictureFolder& folder,
                             const std::optional<double>& zoom) {
  PANELCAL_TRY(TaggedPose pose, pose_from_tags(plate, sights));
  PANELCAL_CHECK(check_followed(pose, folder, zoom));
  return pose;
}

}  // namespace

Expected<PlatePicture> read_plate_picture(const MachineConfig& config,
                                          const CameraCalibration& camera,
                                          const std::filesystem::path& file) {
  const std::string path = file.string();
  PlatePicture out;
  PANELCAL_TRY(out.bytes, read_file(path));
  PANELCAL_TRY(out.image, decode_image(out.bytes, path));
  out.image = understood(std::move(out.image), config.picture_form);
  if (out.image.width() == camera.picture_width_px &&
      out.image.height() == camera.picture_height_px) {
    return out;
  }
  return failure({Code::PictureMismatch,
                  {path, 0, 0},
                  fmt::format("the picture has {} x {} px", out.image.width(), out.image.height()),
                  fmt::format("{} x {} px, for which [camera] is calibrated",
                              camera.picture_width_px,
                              camera.picture_height_px)});
}

Expected<TaggedPose> look_at_tags(const MachineConfig& config,
                                  const CalibrationPlate& plate,
                                  const CameraCalibration& camera,
                                  const PictureFolder& folder,
                                  const std::optional<double>& zoom) {
  const CameraModel model = camera.model();
  const Target target = tag_target(*plate.tags, camera.parameters.scale_mm_per_px);
  const double size_mm = plate.tags->size.in_mm();
  std::vector<TagSight> sights;
  std::string of_other_size;
  for (std::size_t i = 0; i < folder.rows.size(); ++i) {
    const PictureRow& row = folder.rows[i];
    if (row.zoom != zoom) continue;
    PANELCAL_TRY(const PlatePicture picture,
                 read_plate_picture(config, camera, folder.path_of(row)));
    PANELCAL_TRY(const auto tags, read_tags(picture.image, target, config.locate));
    for (const ReadTag& tag : tags) {
      auto sight = sight_of(tag, model, row.axis);
      if (!sight) continue;
      sight->i_picture = i;
      if (std::abs(side_mm(*sight) / size_mm - 1) <= kMostSizeError) {
        sights.push_back(*std::move(sight));
      } else {
        of_other_size =
            fmt::format("; tag {} in {} is {:.3f} mm wide", tag.id, row.file, side_mm(*sight));
      }
    }
  }
  auto pose = pose_of(plate, sights, folder, zoom);
  if (pose) return pose;
  Diagnostic diagnostic = std::move(pose).error();
  diagnostic.place.file = folder.folder.string();
  if (sights.empty()) diagnostic.what += of_other_size;
  return failure(std::move(diagnostic));
}

}  // namespace panelcal::internal
