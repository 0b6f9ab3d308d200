// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/config/plate/plate.h"
#include "machine/plate/tagged_pose.h"
#include "vision/picture/files/folder.h"
#include "vision/picture/image.h"

// Not installed: a part of looking at plates.
namespace panelcal::internal {

/// A picture as its file has it, and in grey levels.
struct PlatePicture {
  std::string bytes;
  Image image;
};

/// Reads a picture that [camera] was calibrated for.
///
/// Fails  what reading it reports; picture-mismatch
Expected<PlatePicture> read_plate_picture(const MachineConfig& config,
                                          const CameraCalibration& camera,
                                          const std::filesystem::path& file);

/// Reads the plate's tags in the pictures of one pose, and how the plate lay; a picture is named by
/// its row. Pictures of another zoom are skipped.
///
/// If all tags are in one picture, a stop that was off there would shift the dots of every other
/// one unseen: that is refused if others show none.
///
/// Fails  what read_plate_picture, read_tags and pose_from_tags report; calibration-data
Expected<TaggedPose> look_at_tags(const MachineConfig& config,
                                  const CalibrationPlate& plate,
                                  const CameraCalibration& camera,
                                  const PictureFolder& folder,
                                  const std::optional<double>& zoom);

}  // namespace panelcal::internal
