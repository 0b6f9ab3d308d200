// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/recorded_calibration.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Recorded and requested places come from the same arithmetic; this only forgives printing.
constexpr double kSameOrder_mm = 1e-6;
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
