// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "machine/calibrate/table/run.h"
#include "machine/config/machine_config.h"
#include "machine/config/plate/plate.h"
#include "machine/look/mark_sights.h"
#include "vision/picture/files/folder.h"

namespace panelcal {

/// The picture folders of a plate, one a pose: DIR itself if it has an images.csv, else DIR/0,
/// DIR/1, ... as many as the plate's file has poses; of a plate with tags whose file has none, as
/// many as there are.
///
/// Fails  config-value (the plate's file has neither pose nor tags); file-unreadable; images-csv
Expected<std::vector<PictureFolder>> read_plate_folders(const std::filesystem::path& folder,
                                                        const CalibrationPlate& plate);

/// Looks for a plate's dots in recorded pictures: views, dots and what was seen of them.
///
/// The places of the axis and the plate's pose tell which dot is which; the pose that its file
/// states need only be right to a quarter of the pitch where the first picture was taken, since it
/// is refined with every picture. Of a plate with tags these say how it lay (tagged_pose.h),
/// whatever its file states. A picture whose tags contradict the others is left out. One that shows
/// no tag is looked at by what two others or more said, and named in `without_tag`: where the axis
/// stood there is checked by nothing but the dots, which look the same a pitch off. Dots are fitted
/// as circles in the picture itself, as look_at_mark does. A dot that is not found is no error:
/// plates get dirty. Axes stay where they were sent to: correct_views of mark_sights.h takes them
/// to where they stood, for code that does not calibrate the table itself. A pose without pictures
/// of the zoom is skipped.
///
/// Fails  config-value (no [camera]; no dot diameter); picture-mismatch; what reading a picture
///        reports; calibration-data (no dot in any picture; dots that do not make one plate; no tag
///        in any picture of a pose, or in one alone that others follow from; tags or dots that
///        contradict one another)
/// See    tests/machine/plate/pictures_test.cc, tagged_plate_test.cc
Expected<MarkSights> look_at_plate(const MachineConfig& config,
                                   const CalibrationPlate& plate,
                                   const std::vector<PictureFolder>& poses,
                                   const std::optional<double>& zoom = {});

/// The same of a plate that is fixed to the machine, as its one [[pose]] says: the axis is driven
/// over its dots, or evenly chosen ones of many, each come to from the same side.
///
/// Fails  travel-exceeded, before anything moves; device errors; else as above
/// Cost   a picture a dot, at most 225
Expected<MarkSights> look_at_plate(const MachineConfig& config,
                                   const CalibrationDevices& devices,
                                   const CalibrationPlate& plate);

/// Checks that all dots of a plate that is fixed to the machine can be come to and looked at.
///
/// In     plate: with one [[pose]]
/// Fails  travel-exceeded
Expected<void> check_plate_travel(const MachineConfig& config, const CalibrationPlate& plate);

/// The same as looks for the table's fit, through the present calibration of the camera.
TableSights table_sights(const MachineConfig& config, const MarkSights& seen);

}  // namespace panelcal
