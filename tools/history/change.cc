// SPDX-License-Identifier: Apache-2.0
// By how much targets, and what is told for holes, differ between two calibrations.
#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "calib/camera/calibration/calibration_file.h"
#include "calib/table/calibration_file.h"
#include "tools/history/diff.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

using Shift = Displacement<frame::Actual>;

Diagnostic no_difference(const std::string& file, std::string what, std::string expected) {
  return {Code::LedgerEntryInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

Expected<Displacement<frame::Machine>> offset_of(const LedgerEntry& entry,
                                                 const std::string& file) {
  Eigen::Vector2d offset_mm;
  for (int axis = 0; axis < 2; ++axis) {
    const std::string name = axis == 0 ? "offset_x" : "offset_y";
    const auto i = entry.record.find(name);
    if (!i || entry.record.parameters[*i].unit != "mm") {
      return failure(no_difference(
          file, fmt::format("entry {} has no {} in mm", entry.id, name), "offset_x and offset_y"));
    }
    offset_mm[axis] = entry.record.parameters[*i].value;
  }
  return displacement_mm<frame::Machine>(offset_mm);
}

Expected<CalibrationChange> offset_change(const LedgerEntry& before,
                                          const LedgerEntry& after,
                                          const std::string& file) {
  SpindleCameraOffset from;
  SpindleCameraOffset to;
  PANELCAL_TRY(from.offset, offset_of(before, file));
  PANELCAL_TRY(to.offset, offset_of(after, file));
  const HoleShift shift = shift_between(from, to);
  CalibrationChange change;
  change.target_shift = [shift](const Measurement& target) -> Expected<Shift> {
    return shift(target.request.nominal);
  };
  change.notes = {
      "The offset lies between what is seen and what is drilled, so it moves whatever is placed by "
      "targets, and all of it alike, however they were fitted.",
      "If work zero is set with the camera, places that no target corrects move by it as well."};
  return change;
}

/// True if a target is looked at with the camera that a subject of the ledger names: "zoom 3" is
/// that of `$uvis,zoom,3`, any other name that of targets without a zoom level.
bool is_seen_with(const std::string& subject, const std::optional<double>& zoom) {
  if (!subject.starts_with("zoom ")) return !zoom;
  return zoom && subject == fmt::format("zoom {}", *zoom);
}

/// The camera of one calibration, and what of its picture it may be asked about.
struct SeenBy {
  CameraModel model;
  int width_px;
  int height_px;

  bool shows(const Position<frame::Image>& u) const {
    const Eigen::Vector2d& u_px = u.in_px();
    return u_px.minCoeff() >= -0.5 && u_px.x() <= width_px - 0.5 && u_px.y() <= height_px - 0.5;
  }
};

/// Of a slot one coordinate is only assumed; a search measures from a view that it does not name.
Expected<void> check_says_where_seen(const MeasurementRequest& request) {
  const bool is_searched = request.settings.search.value_or(false);
  if (!is_searched && request.axes == ObservedAxes::Both) return {};
  return failure({Code::MeasurementMismatch,
                  {request.file, request.line, 0},
                  fmt::format("target {} {}: where in the picture it was seen is not recorded",
                              request.seq,
                              is_searched ? "was searched for" : "is a slot"),
                  "targets that show both coordinates, without a search"});
}

Expected<CalibrationChange> camera_change(const CalibrationEntry& before,
                                          const CalibrationEntry& after,
                                          const std::string& file) {
  const auto read = [&](const CalibrationEntry& side) {
    return parse_camera_calibration(side.result, fmt::format("{} entry {}", file, side.entry.id));
  };
  PANELCAL_TRY(const CameraCalibration from, read(before));
  PANELCAL_TRY(const CameraCalibration to, read(after));
  const SeenBy old{from.model(), from.picture_width_px, from.picture_height_px};
  const CameraModel now = to.model();
  CalibrationChange change;
  const std::string subject = before.entry.record.key.subject;
  change.target_shift = [old, now, subject](const Measurement& target) -> Expected<Shift> {
    if (!is_seen_with(subject, target.request.settings.zoom)) return Shift();
    PANELCAL_CHECK(check_says_where_seen(target.request));
    const Shift seen = target.measured.position - target.request.expected;
    const auto u = old.model.image_of(position_mm<frame::Optical>(seen.in_mm()));
    if (!u || !old.shows(*u) || !now.sees(*u)) {
      return failure(
          {Code::MeasurementMismatch,
           {target.request.file, target.request.line, 0},
           fmt::format("target {} was seen {:.3f} mm from where it was looked for, which "
                       "is outside of the picture",
                       target.request.seq,
                       seen.in_mm().norm()),
           "targets found without a search, so that their places in the picture are not "
           "known"});
    }
    return displacement_mm<frame::Actual>(now(*u).in_mm() - old.model(*u).in_mm());
  };
  change.notes = {
      "A camera calibration moves a target by where in the picture it is seen; on a perfect panel "
      "all are on the optical axis. --measurements of a job states where they were."};
  return change;
}

/// The stage erred alike whichever calibration is believed; they differ in where they say that it
/// stood.
Expected<CalibrationChange> table_change(const CalibrationEntry& before,
                                         const CalibrationEntry& after,
                                         const std::string& file,
                                         const LookingMachine& machine) {
  const auto read =
      [&](const CalibrationEntry& side) -> Expected<std::shared_ptr<const TableCorrection>> {
    const std::string name = fmt::format("{} entry {}", file, side.entry.id);
    PANELCAL_TRY(TableCalibration table, parse_table_calibration(side.result, name));
    return std::make_shared<const TableCorrection>(std::move(table.map), machine.table_hold, name);
  };
  CalibrationChange change;
  PANELCAL_TRY(change.table_before, read(before));
  PANELCAL_TRY(change.table_after, read(after));
  change.target_shift = [from = change.table_before,
                         to = change.table_after,
                         offset = machine.offset](const Measurement& target) -> Expected<Shift> {
    const auto place = offset.spindle_to_see(target.request.expected_in_machine());
    const auto command = from->command_for(place);
    if (!command) return failure(from->refusal(place));
    const auto now = to->place_of(*command);
    if (!now) return failure(to->refusal(*command));
    return displacement_mm<frame::Actual>((*now - place).in_mm());
  };
  change.notes = {
      "A table calibration moves targets, by its place of the stage that looked at them, and "
      "holes, by its command to the machine.",
      "Each calibration chooses its own table origin and rotation; the fit to measured targets "
      "removes the difference, places without a correction keep it."};
  return change;
}

}  // namespace

Expected<CalibrationChange> change_between(const CalibrationEntry& before,
                                           const CalibrationEntry& after,
                                           const std::string& file,
                                           const LookingMachine& machine) {
  const LedgerKey& key = before.entry.record.key;
  if (key != after.entry.record.key) {
    const auto words = [](const LedgerEntry& entry) {
      return fmt::format("entry {} is of {} {} of {}",
                         entry.id,
                         word(entry.record.key.kind),
                         quoted(std::string_view(entry.record.key.subject)),
                         quoted(std::string_view(entry.record.key.machine)));
    };
    return failure(no_difference(
        file, words(before.entry) + ", " + words(after.entry), "two calibrations of one thing"));
  }
  switch (key.kind) {
    case LedgerKind::SpindleCamera:
      return offset_change(before.entry, after.entry, file);
    case LedgerKind::Camera:
      return camera_change(before, after, file);
    case LedgerKind::Table:
      return table_change(before, after, file, machine);
    default:
      return failure(
          no_difference(file,
                        fmt::format("entry {} is of {}, which moves no hole of a program",
                                    before.entry.id,
                                    word(key.kind)),
                        "spindle-camera, camera or table"));
  }
}

}  // namespace panelcal::history
