// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/recorded_calibration.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "calib/base/json/json_line.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr Code kOrderCode = Code::MeasurementFile;
constexpr std::array<std::string_view, 12> kOrderKeys = {"calibration",
                                                         "command",
                                                         "cov",
                                                         "file",
                                                         "file_sha256",
                                                         "first_hole",
                                                         "lamp",
                                                         "line",
                                                         "offset",
                                                         "path",
                                                         "text",
                                                         "zoom"};
constexpr int kMaxOrderInt = std::numeric_limits<int>::max();
constexpr std::int64_t kMaxOrderNumber = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t kMaxOrderPath = 128;  // as of measurements
/// Recorded and requested places come from the same arithmetic; this only forgives printing.
constexpr double kSameOrder_mm = 1e-6;
/// Far beyond any machine; squares of larger ones would leave no covariance.
constexpr double kMaxOrderPlace_mm = 1e6;

Expected<CalibrationOrder> read_order(const JsonLine& line) {
  CalibrationOrder order;
  PANELCAL_TRY(order.number, line.integer("calibration", 0, kMaxOrderNumber, kOrderCode));
  PANELCAL_TRY(const auto program_line, line.integer("line", 0, kMaxOrderInt, kOrderCode));
  order.line = static_cast<int>(program_line);
  PANELCAL_TRY(order.command, line.text("command", kOrderCode));
  PANELCAL_TRY(order.path, line.integers("path", 0, kMaxOrderInt, kMaxOrderPath, kOrderCode));
  PANELCAL_CHECK(read_pattern(line, kOrderCode, order.file, order.file_sha256));
  if (line.has("first_hole")) {
    PANELCAL_TRY(const std::vector<double> xy_mm, line.numbers("first_hole", 2, kOrderCode));
    order.first_hole = position_mm<frame::Machine>(xy_mm[0], xy_mm[1]);
  }
  if (line.has("lamp")) {
    PANELCAL_TRY(order.lamp, line.number("lamp", kOrderCode));
  }
  if (line.has("zoom")) {
    PANELCAL_TRY(order.zoom, line.number("zoom", kOrderCode));
  }
  return order;
}

Expected<SpindleCameraOffset> read_offset(const JsonLine& line) {
  PANELCAL_TRY(const std::vector<double> xy_mm, line.numbers("offset", 2, kOrderCode));
  PANELCAL_TRY(const std::vector<double> cov, line.numbers("cov", 3, kOrderCode));
  for (const double number : xy_mm) {
    if (number >= -kMaxOrderPlace_mm && number <= kMaxOrderPlace_mm) continue;
    return failure(line.problem(
        "offset", kOrderCode, fmt::format("at most {:.0f} mm each", kMaxOrderPlace_mm)));
  }
  constexpr double kMost_mm2 = kMaxOrderPlace_mm * kMaxOrderPlace_mm;
  const bool is_covariance = cov[0] >= 0 && cov[2] >= 0 && cov[0] <= kMost_mm2 &&
                             cov[2] <= kMost_mm2 && cov[1] * cov[1] <= cov[0] * cov[2];
  if (!is_covariance) {
    return failure(line.problem(
        "cov", Code::MeasurementInvalid, "[xx, xy, yy] with xx >= 0, yy >= 0 and xy^2 <= xx yy"));
  }
  SpindleCameraOffset offset{displacement_mm<frame::Machine>(xy_mm[0], xy_mm[1]), {}};
  offset.cov_mm2 << cov[0], cov[1], cov[1], cov[2];
  return offset;
}

std::string place_text(const std::optional<Position<frame::Machine>>& place) {
  if (!place) return "no first hole";
  return fmt::format("first hole [{}, {}]", place->in_mm().x(), place->in_mm().y());
}

bool is_same_place(const std::optional<Position<frame::Machine>>& a,
                   const std::optional<Position<frame::Machine>>& b) {
  if (a.has_value() != b.has_value()) return false;
  // Written so that a NaN differs.
  return !a || (*a - *b).in_mm().norm() <= kSameOrder_mm;
}

/// Text of the recorded order and of the program's order where they differ; empty if they are the
/// same.
std::optional<std::pair<std::string, std::string>> order_difference(
    const CalibrationOrder& recorded, const CalibrationOrder& asked) {
  const auto words = [](const CalibrationOrder& order) {
    return fmt::format("{}{}, line {}, path [{}]",
                       order.command,
                       order.zoom ? fmt::format(" at zoom {}", *order.zoom) : "",
                       order.line,
                       fmt::join(order.path, ","));
  };
  if (!is_same_pattern(recorded.pattern(), asked.pattern())) {
    return std::pair("file " + pattern_text(recorded.pattern()),
                     "file " + pattern_text(asked.pattern()));
  }
  if (words(recorded) != words(asked)) return std::pair(words(recorded), words(asked));
  if (is_same_place(recorded.first_hole, asked.first_hole)) return std::nullopt;
  return std::pair(place_text(recorded.first_hole), place_text(asked.first_hole));
}

}  // namespace

bool is_calibration(const JsonLine& line) {
  return line.has("calibration");
}

Expected<CalibrationAnswer> read_calibration(const JsonLine& line) {
  PANELCAL_CHECK(line.check_keys(kOrderKeys, kOrderCode));
  CalibrationAnswer answer;
  PANELCAL_TRY(answer.order, read_order(line));
  if (line.has("offset")) {
    PANELCAL_TRY(answer.offset, read_offset(line));
  } else if (line.has("cov")) {
    return failure(line.problem("cov", kOrderCode, "no covariance without an offset"));
  }
  PANELCAL_TRY(answer.text, line.text("text", kOrderCode));
  return answer;
}

CalibrationReplay::CalibrationReplay(std::string file, std::vector<RecordedCalibration> recorded)
    : file_(std::move(file)), recorded_(std::move(recorded)), is_used_(recorded_.size(), false) {
  std::ranges::sort(
      recorded_, {}, [](const RecordedCalibration& one) { return one.answer.order.number; });
}

Expected<std::optional<CalibrationAnswer>> CalibrationReplay::calibrate(
    const CalibrationOrder& order) {
  const auto found =
      std::ranges::lower_bound(recorded_, order.number, {}, [](const RecordedCalibration& one) {
        return one.answer.order.number;
      });
  if (found == recorded_.end() || found->answer.order.number != order.number) return std::nullopt;
  if (const auto differs = order_difference(found->answer.order, order)) {
    return failure({Code::MeasurementMismatch,
                    {file_, found->line, 1},
                    fmt::format("calibration {} has {}", order.number, differs->first),
                    differs->second + ", as the program has it"});
  }
  is_used_[static_cast<std::size_t>(found - recorded_.begin())] = true;
  return found->answer;
}

Expected<void> CalibrationReplay::check_all_used() const {
  for (std::size_t i = 0; i < recorded_.size(); ++i) {
    if (is_used_[i]) continue;
    return failure(
        {Code::MeasurementMismatch,
         {file_, recorded_[i].line, 1},
         fmt::format("the program does not ask for {}", describe(recorded_[i].answer.order)),
         "only what the program asks for"});
  }
  return {};
}

}  // namespace panelcal::internal
