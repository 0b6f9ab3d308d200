// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/measurement_file_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/json_line.h"
#include "machine/look/picture_locator.h"
#include "machine/sources/recorded_lines.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::JsonLine;

constexpr Code kMeasurementCode = Code::MeasurementFile;
constexpr std::array<std::string_view, 30> kMeasurementKeys = {
    "algorithm",   "axes",     "by_camera",   "candidates",  "candidates_by_camera",
    "command",     "cov",      "delta",       "expected",    "file",
    "file_sha256", "image",    "inspections", "lamp",        "line",
    "listed_area", "measured", "nominal",     "path",        "reason",
    "scatter",     "score",    "search",      "search_area", "search_radius",
    "seq",         "status",   "tool",        "tools",       "zoom"};

constexpr int kMaxMeasurementInt = std::numeric_limits<int>::max();
constexpr std::int64_t kMaxMeasurementSeq = std::numeric_limits<std::int64_t>::max();
/// Of G34.
constexpr std::size_t kMaxTools = 4;
constexpr internal::RecordedRange kDeviceSetting{-internal::kMostOfDevice, internal::kMostOfDevice};
/// Condition for the covariance of a place.
constexpr std::string_view kCovarianceWords = "xy^2 < xx yy, and sigmas from 1e-9 to 1000 mm";

Expected<double> read_measured_number(const JsonLine& line,
                                      std::string_view key,
                                      const internal::RecordedRange& range) {
  return internal::recorded_number(line, key, range, kMeasurementCode);
}

Expected<void> read_vision_tools(const JsonLine& line, VisionSettings& settings) {
  PANELCAL_TRY(const int tool, internal::recorded_int(line, "tool"));
  settings.tools = {tool};
  if (!line.has("tools")) return {};
  PANELCAL_TRY(settings.tools,
               line.integers("tools", 0, kMaxMeasurementInt, kMaxTools, kMeasurementCode));
  if (settings.tools.size() > 1 && settings.tools.front() == tool) return {};
  return failure(line.problem("tools",
                              kMeasurementCode,
                              fmt::format("two or more vision tools, \"tool\" = {} first", tool)));
}

Expected<void> read_settings(const JsonLine& line, VisionSettings& settings) {
  PANELCAL_CHECK(read_vision_tools(line, settings));
  if (line.has("delta")) {
    PANELCAL_TRY(const double delta_mm,
                 read_measured_number(line, "delta", internal::kRecordedLength));
    settings.delta = mm(delta_mm);
  }
  if (line.has("inspections")) {
    PANELCAL_TRY(const auto n,
                 line.integer("inspections", 1, kMaxMeasurementInt, kMeasurementCode));
    settings.inspections = static_cast<int>(n);
  }
  if (line.has("search")) {
    PANELCAL_TRY(settings.search, line.truth_value("search", kMeasurementCode));
  }
  if (line.has("algorithm")) {
    PANELCAL_TRY(settings.algorithm, internal::recorded_int(line, "algorithm"));
  }
  if (line.has("search_area")) {
    PANELCAL_TRY(const double radius_mm,
                 read_measured_number(line, "search_area", internal::kRecordedLength));
    settings.search_area = mm(radius_mm);
  }
  if (line.has("lamp")) {
    PANELCAL_TRY(settings.lamp, read_measured_number(line, "lamp", kDeviceSetting));
  }
  if (line.has("zoom")) {
    PANELCAL_TRY(settings.zoom, read_measured_number(line, "zoom", kDeviceSetting));
  }
  return {};
}

Expected<MeasurementRequest> read_measurement_request(const JsonLine& line) {
  MeasurementRequest request;
  PANELCAL_TRY(request.seq, line.integer("seq", 0, kMaxMeasurementSeq, kMeasurementCode));
  PANELCAL_CHECK(internal::read_origin(line, request));
  PANELCAL_CHECK(read_settings(line, request.settings));
  PANELCAL_CHECK(internal::read_places(line, request));
  if (line.has("axes")) {
    PANELCAL_TRY(const std::string axes, line.text("axes", kMeasurementCode));
    const std::string_view word = axes;
    if (word != "x" && word != "y")
      return failure(line.problem("axes", kMeasurementCode, "\"x\" or \"y\""));
    request.axes = word == "x" ? ObservedAxes::X : ObservedAxes::Y;
  }
  return request;
}

Expected<PositionEstimate<frame::Actual>> read_measured(const JsonLine& line) {
  PANELCAL_TRY(const Eigen::Vector2d measured_mm,
               internal::recorded_place(line, "measured", kMeasurementCode));
  PANELCAL_TRY(const std::vector<double> cov, line.numbers("cov", 3, kMeasurementCode));
  PositionEstimate<frame::Actual> measured{position_mm<frame::Actual>(measured_mm), {}};
  measured.cov << cov[0], cov[1], cov[1], cov[2];
  if (!internal::is_measured_covariance(measured.cov)) {
    return failure(line.problem(
        "cov", Code::MeasurementInvalid, fmt::format("[xx, xy, yy] with {}", kCovarianceWords)));
  }
  return measured;
}

/// Derivatives by the camera's parameters, 10 of each place.
Expected<std::vector<double>> read_jacobians(const JsonLine& line,
                                             std::string_view key,
                                             std::size_t n_places) {
  // Far beyond any camera; squares of larger ones would leave no covariance.
  constexpr double kMost = 1e15;
  PANELCAL_TRY(std::vector<double> rows, line.numbers(key, 10 * n_places, kMeasurementCode));
  for (const double number : rows) {
    if (std::abs(number) <= kMost) continue;
    return failure(
        line.problem(key, kMeasurementCode, fmt::format("numbers of at most {:.0e}", kMost)));
  }
  return rows;
}

Expected<std::optional<CameraJacobian>> read_by_camera(const JsonLine& line) {
  if (!line.has("by_camera")) return std::nullopt;
  PANELCAL_TRY(const std::vector<double> rows, read_jacobians(line, "by_camera", 1));
  return Eigen::Map<const Eigen::Matrix<double, 2, 5, Eigen::RowMajor>>(rows.data());
}

/// Numbers of one candidate: place, covariance, score, whether it counts.
constexpr std::size_t kCandidateNumbers = 7;
constexpr std::size_t kMaxMeasurementCandidates = 200;

Expected<void> read_candidates(const JsonLine& line, Measurement& measurement) {
  if (!line.has("candidates")) return {};
  PANELCAL_TRY(const std::vector<double> numbers,
               line.numbers_of(
                   "candidates", kCandidateNumbers, kMaxMeasurementCandidates, kMeasurementCode));
  const std::size_t n = numbers.size() / kCandidateNumbers;
  std::vector<double> by_camera(10 * n, 0);
  if (line.has("candidates_by_camera")) {
    PANELCAL_TRY(by_camera, read_jacobians(line, "candidates_by_camera", n));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double* const c = &numbers[kCandidateNumbers * i];
    const bool is_near = std::max(std::abs(c[0]), std::abs(c[1])) <= internal::kMostRecorded_mm;
    const bool has_score = c[5] >= 0 && c[5] <= 1;
    MeasuredCandidate candidate;
    candidate.place.cov << c[2], c[3], c[3], c[4];
    if (!is_near || !internal::is_measured_covariance(candidate.place.cov) || !has_score ||
        !(c[6] == 0 || c[6] == 1)) {
      return failure(line.problem(
          "candidates",
          Code::MeasurementInvalid,
          fmt::format("x, y within {:g} mm of 0, xx, xy, yy with {}, score from 0 to 1, and 0 or 1",
                      internal::kMostRecorded_mm,
                      kCovarianceWords)));
    }
    candidate.place.position = position_mm<frame::Actual>(c[0], c[1]);
    candidate.score = c[5];
    candidate.counts = c[6] == 1;
    candidate.by_camera =
        Eigen::Map<const Eigen::Matrix<double, 2, 5, Eigen::RowMajor>>(&by_camera[10 * i]);
    measurement.candidates.push_back(candidate);
  }
  return {};
}

Expected<void> read_listed_area(const JsonLine& line, Measurement& measurement) {
  if (!line.has("listed_area")) return {};
  PANELCAL_TRY(const std::vector<double> xy_mm,
               internal::recorded_numbers(
                   line, "listed_area", 8, internal::kRecordedPlace, kMeasurementCode));
  ListedArea area;
  for (std::size_t k = 0; k < 4; ++k) {
    area.corners[k] = position_mm<frame::Actual>(xy_mm[2 * k], xy_mm[2 * k + 1]);
  }
  if (line.has("search_radius")) {
    PANELCAL_TRY(const double radius_mm,
                 read_measured_number(line, "search_radius", internal::kRecordedLength));
    if (!(radius_mm > 0)) {
      return failure(line.problem("search_radius", kMeasurementCode, "more than 0"));
    }
    area.radius = mm(radius_mm);
  }
  measurement.listed = area;
  return {};
}

Expected<Measurement> read_measurement(const JsonLine& line) {
  PANELCAL_CHECK(line.check_keys(kMeasurementKeys, kMeasurementCode));
  Measurement measurement;
  PANELCAL_TRY(measurement.request, read_measurement_request(line));
  PANELCAL_TRY(const std::string status, line.text("status", kMeasurementCode));
  const auto known = measurement_status_from_name(status);
  if (!known) {
    return failure(
        line.problem("status", kMeasurementCode, "found, not_found, ambiguous or rejected"));
  }
  measurement.status = *known;
  if (*known == MeasurementStatus::Found) {
    PANELCAL_TRY(measurement.measured, read_measured(line));
    PANELCAL_TRY(measurement.by_camera, read_by_camera(line));
  } else {
    for (const std::string_view key : {"measured", "cov", "by_camera"}) {
      if (!line.has(key)) continue;
      return failure(
          line.problem(key, kMeasurementCode, "no measured place unless status is found"));
    }
  }
  if (line.has("scatter")) {
    PANELCAL_TRY(
        const std::vector<double> scatter_mm,
        internal::recorded_numbers(line, "scatter", 2, internal::kRecordedSigma, kMeasurementCode));
    measurement.scatter = displacement_mm<frame::Actual>(scatter_mm[0], scatter_mm[1]);
  }
  if (line.has("score")) {
    PANELCAL_TRY(measurement.score, read_measured_number(line, "score", internal::kRecordedScore));
  }
  if (line.has("image")) {
    PANELCAL_TRY(measurement.image, line.text("image", kMeasurementCode));
  }
  if (line.has("reason")) {
    PANELCAL_TRY(measurement.reason, line.text("reason", kMeasurementCode));
  }
  PANELCAL_CHECK(read_candidates(line, measurement));
  PANELCAL_CHECK(read_listed_area(line, measurement));
  return measurement;
}

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
    if (internal::is_calibration(line)) {
      PANELCAL_TRY(CalibrationAnswer answer, internal::read_calibration(line));
      PANELCAL_CHECK(
          check_first(line, "calibration", answer.order.number, number, line_by_calibration));
      recorded.calibrations.push_back({std::move(answer), number});
      return {};
    }
    PANELCAL_TRY(Measurement measurement, read_measurement(line));
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
