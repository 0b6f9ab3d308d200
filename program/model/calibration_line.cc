// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <utility>

#include "calib/base/fields/json.h"
#include "program/model/line_fields.h"
#include "program/model/recorded.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// An order or a calibration as a line has it. The other settings are orders to the camera, not a
/// part of what is recorded: as of a focus.
struct CalibrationLine {
  CalibrationOrder request;
  std::optional<Displacement<frame::Machine>> offset;
  std::optional<std::array<double, 3>> cov;
  std::string text;
};

#include "program/model/calibration.def"

CalibrationLine written_order(const CalibrationOrder& order) {
  CalibrationLine line;
  line.request = order;
  line.request.file = without_folders(order.file);
  return line;
}

}  // namespace

Expected<CalibrationAnswer> calibration_of(const JsonLine& line) {
  PANELCAL_TRY(CalibrationLine read, read_line(kCalibrationLine, line, kLineCode));
  PANELCAL_CHECK(check_pattern(line, read.request.file));
  CalibrationAnswer answer;
  answer.order = std::move(read.request);
  answer.text = std::move(read.text);
  if (!read.offset) {
    if (!read.cov) return answer;
    return failure(line.problem("cov", kLineCode, "no covariance without an offset"));
  }
  if (!read.cov) return failure(line.missing("cov", kLineCode));
  // Squares of what an offset may be.
  constexpr double kMost_mm2 = 1e12;
  const auto [xx, xy, yy] = *read.cov;
  const bool is_covariance =
      xx >= 0 && yy >= 0 && xx <= kMost_mm2 && yy <= kMost_mm2 && xy * xy <= xx * yy;
  if (!is_covariance) {
    return failure(line.problem(
        "cov", Code::MeasurementInvalid, "[xx, xy, yy] with xx >= 0, yy >= 0 and xy^2 <= xx yy"));
  }
  answer.offset = {*read.offset, recorded_covariance(*read.cov)};
  return answer;
}

JsonFile calibrations_file() {
  return {"calibrations.jsonl",
          "Lines of a file of measurements that have `calibration` in place of `seq`: an order to "
          "calibrate the spindle-camera offset (G39, `$uvis,calib`, `G39,SPOP` and its kin), and "
          "what was found. See docs/formats/measurements.md.",
          {&kOrderLine, &kCalibrationLine}};
}

}  // namespace panelcal::internal

namespace panelcal {

std::string to_json(const CalibrationOrder& order) {
  return internal::json_text(
      internal::kOrderLine, internal::written_order(order), internal::JsonStyle::Line);
}

std::string to_json(const CalibrationAnswer& answer) {
  internal::CalibrationLine line = internal::written_order(answer.order);
  line.text = answer.text;
  if (answer.offset) {
    const Eigen::Matrix2d& cov_mm2 = answer.offset->cov_mm2;
    line.offset = answer.offset->offset;
    line.cov = {cov_mm2(0, 0), cov_mm2(0, 1), cov_mm2(1, 1)};
  }
  return internal::json_text(internal::kCalibrationLine, line, internal::JsonStyle::Line);
}

}  // namespace panelcal
