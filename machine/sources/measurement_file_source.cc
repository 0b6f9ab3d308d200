// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/measurement_file_source.h"

#include <map>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/json_line.h"
#include "machine/look/picture_locator.h"
#include "machine/sources/recorded_lines.h"
#include "program/model/recorded.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::JsonLine;

constexpr Code kMeasurementCode = Code::MeasurementFile;
/// Holds a number that counts once against those that were there before.
Expected<void> check_first(const JsonLine& line,
                           std::string_view key,
                           std::int64_t value,
                           int number,
                           std::map<std::int64_t, int>& line_of) {
  const auto [seen, is_new] = line_of.emplace(value, number);
  if (is_new) return {};
  const std::string_view kind = key == "seq" ? "seq" : "number";
  return failure(
      line.problem(key,
                   kMeasurementCode,
                   fmt::format("each {} once; line {} has this one already", kind, seen->second)));
}

}  // namespace

Expected<RecordedMeasurements> parse_measurements(std::string_view text, const std::string& file) {
  RecordedMeasurements recorded{file, {}};
  std::map<std::int64_t, int> line_by_seq;
  std::map<std::int64_t, int> line_by_calibration;
  const auto take = [&](const JsonLine& line, int number) -> Expected<void> {
    if (line.has("calibration")) {
      PANELCAL_TRY(CalibrationAnswer answer, internal::calibration_of(line));
      PANELCAL_CHECK(
          check_first(line, "calibration", answer.order.number, number, line_by_calibration));
      recorded.calibrations.push_back({std::move(answer), number});
      return {};
    }
    PANELCAL_TRY(Measurement measurement, internal::measurement_of(line));
    PANELCAL_CHECK(check_first(line, "seq", measurement.request.seq, number, line_by_seq));
    recorded.measurements.push_back({std::move(measurement), number});
    return {};
  };
  PANELCAL_CHECK(internal::read_recorded_lines(text, file, take));
  return recorded;
}

Expected<RecordedMeasurements> read_measurements(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxMeasurementBytes));
  return parse_measurements(text, path.string());
}

MeasurementFileSource::MeasurementFileSource(RecordedMeasurements recorded)
    : calibrations_(recorded.file, std::move(recorded.calibrations)),
      answers_(recorded.file, "seq", std::move(recorded.measurements)) {
}

Expected<Measurement> MeasurementFileSource::measure(const MeasurementRequest& request) {
  return answers_.answer(request, "a measurement");
}

Expected<void> MeasurementFileSource::check_all_used() const {
  PANELCAL_CHECK(answers_.check_all_used());
  return calibrations_.check_all_used();
}

}  // namespace panelcal
