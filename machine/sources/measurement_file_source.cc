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
#include "machine/sources/recorded_ranges.h"
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
/// Step and repeat nests at most 64 deep (nesting-too-deep), in the program and again in a stored
/// pattern; G34 takes at most four tools.
constexpr std::size_t kMaxMeasurementPath = 128;
constexpr std::size_t kMaxTools = 4;
constexpr std::size_t kMaxMeasurementLine = std::size_t{1} << 16;
constexpr internal::RecordedRange kDeviceSetting{-internal::kMostOfDevice, internal::kMostOfDevice};
/// Condition for the covariance of a place.
constexpr std::string_view kCovarianceWords = "xy^2 < xx yy, and sigmas from 1e-9 to 1000 mm";
/// Recorded and requested nominals come from the same arithmetic; this only forgives printing.
constexpr double kSameMeasured_mm = 1e-6;

Expected<Eigen::Vector2d> read_measured_point(const JsonLine& line, std::string_view key) {
  return internal::recorded_place(line, key, kMeasurementCode);
}

Expected<double> read_measured_number(const JsonLine& line,
                                      std::string_view key,
                                      const internal::RecordedRange& range) {
  return internal::recorded_number(line, key, range, kMeasurementCode);
}

Expected<void> read_vision_tools(const JsonLine& line, VisionSettings& settings) {
  PANELCAL_TRY(const auto tool, line.integer("tool", 0, kMaxMeasurementInt, kMeasurementCode));
  settings.tools = {static_cast<int>(tool)};
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
    PANELCAL_TRY(const auto algorithm,
                 line.integer("algorithm", 0, kMaxMeasurementInt, kMeasurementCode));
    settings.algorithm = static_cast<int>(algorithm);
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
  PANELCAL_TRY(const auto program_line,
               line.integer("line", 0, kMaxMeasurementInt, kMeasurementCode));
  request.line = static_cast<int>(program_line);
  PANELCAL_CHECK(read_pattern(line, kMeasurementCode, request.file, request.file_sha256));
  PANELCAL_TRY(request.command, line.text("command", kMeasurementCode));
  PANELCAL_CHECK(read_settings(line, request.settings));
  PANELCAL_TRY(const Eigen::Vector2d nominal_mm, read_measured_point(line, "nominal"));
  request.nominal = position_mm<frame::Nominal>(nominal_mm);
  PANELCAL_TRY(const Eigen::Vector2d expected_mm, read_measured_point(line, "expected"));
  request.expected = position_mm<frame::Actual>(expected_mm);
  PANELCAL_TRY(request.path,
               line.integers("path", 0, kMaxMeasurementInt, kMaxMeasurementPath, kMeasurementCode));
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
  PANELCAL_TRY(const Eigen::Vector2d measured_mm, read_measured_point(line, "measured"));
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

std::string measured_point_text(const Eigen::Vector2d& p_mm) {
  return fmt::format("[{}, {}]", p_mm.x(), p_mm.y());
}

/// In which way a recorded request is another one than the program's; empty if it is the same.
struct MeasurementDifference {
  std::string recorded;
  std::string requested;
};
std::optional<MeasurementDifference> measurement_difference(const MeasurementRequest& recorded,
                                                            const MeasurementRequest& requested) {
  const auto tool_of = [](const MeasurementRequest& request) {
    return request.settings.tools.empty() ? 0 : request.settings.tools.front();
  };
  const auto differs = [](std::string_view what, const auto& a, const auto& b) {
    return MeasurementDifference{fmt::format("{} {}", what, a), fmt::format("{} {}", what, b)};
  };
  if (recorded.command != requested.command) {
    return differs("command", quoted(recorded.command), quoted(requested.command));
  }
  if (!is_same_pattern(recorded.pattern(), requested.pattern())) {
    return differs("file", pattern_text(recorded.pattern()), pattern_text(requested.pattern()));
  }
  if (recorded.line != requested.line) return differs("line", recorded.line, requested.line);
  if (tool_of(recorded) != tool_of(requested)) {
    return differs("vision tool", tool_of(recorded), tool_of(requested));
  }
  if (recorded.path != requested.path) {
    return differs("path",
                   fmt::format("[{}]", fmt::join(recorded.path, ",")),
                   fmt::format("[{}]", fmt::join(requested.path, ",")));
  }
  const Displacement<frame::Nominal> apart = recorded.nominal - requested.nominal;
  // Written so that a NaN differs.
  if (!(apart.in_mm().norm() <= kSameMeasured_mm)) {
    return differs("nominal",
                   measured_point_text(recorded.nominal.in_mm()),
                   measured_point_text(requested.nominal.in_mm()));
  }
  return std::nullopt;
}

}  // namespace

Expected<RecordedMeasurements> parse_measurements(std::string_view text, const std::string& file) {
  RecordedMeasurements recorded{file, {}};
  std::map<std::int64_t, int> line_by_seq;
  std::map<std::int64_t, int> line_by_calibration;
  int number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const Place place{file, number, 1};
    if (line.size() > kMaxMeasurementLine) {
      return failure({Code::MeasurementFile,
                      place,
                      "the line is too long",
                      fmt::format("at most {} bytes", kMaxMeasurementLine)});
    }
    PANELCAL_TRY(const JsonLine parsed, JsonLine::parse(line, place));
    if (internal::is_calibration(parsed)) {
      PANELCAL_TRY(CalibrationAnswer answer, internal::read_calibration(parsed));
      const auto [seen, is_new] = line_by_calibration.emplace(answer.order.number, number);
      if (!is_new) {
        return failure(parsed.problem(
            "calibration",
            kMeasurementCode,
            fmt::format("each number once; line {} has this one already", seen->second)));
      }
      recorded.calibrations.push_back({std::move(answer), number});
      continue;
    }
    PANELCAL_TRY(Measurement measurement, read_measurement(parsed));
    const auto [seen, is_new] = line_by_seq.emplace(measurement.request.seq, number);
    if (!is_new) {
      return failure(
          parsed.problem("seq",
                         kMeasurementCode,
                         fmt::format("each seq once; line {} has this one already", seen->second)));
    }
    recorded.measurements.push_back({std::move(measurement), number});
  }
  return recorded;
}

Expected<RecordedMeasurements> read_measurements(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxMeasurementBytes));
  return parse_measurements(text, path.string());
}

MeasurementFileSource::MeasurementFileSource(RecordedMeasurements recorded)
    : recorded_(std::move(recorded)), calibrations_(recorded_.file, recorded_.calibrations) {
  for (std::size_t i = 0; i < recorded_.measurements.size(); ++i) {
    by_seq_.emplace(recorded_.measurements[i].measurement.request.seq, Entry{i, false});
  }
}

Expected<Measurement> MeasurementFileSource::measure(const MeasurementRequest& request) {
  const auto found = by_seq_.find(request.seq);
  if (found == by_seq_.end()) {
    return failure({Code::MeasurementMissing,
                    {recorded_.file, 0, 0},
                    "seq " + std::to_string(request.seq),
                    "a measurement for " + describe(request)});
  }
  const RecordedMeasurement& recorded = recorded_.measurements[found->second.index];
  if (const auto differs = measurement_difference(recorded.measurement.request, request)) {
    return failure({Code::MeasurementMismatch,
                    {recorded_.file, recorded.line, 1},
                    fmt::format("seq {} has {}", request.seq, differs->recorded),
                    differs->requested + ", as the program has it"});
  }
  found->second.is_used = true;
  Measurement measurement = recorded.measurement;
  measurement.request = request;
  return measurement;
}

Expected<void> MeasurementFileSource::check_all_used() const {
  for (const RecordedMeasurement& recorded : recorded_.measurements) {
    const MeasurementRequest& request = recorded.measurement.request;
    if (by_seq_.at(request.seq).is_used) continue;
    return failure({Code::MeasurementMismatch,
                    {recorded_.file, recorded.line, 1},
                    fmt::format("the program does not ask for {}", describe(request)),
                    "only what the program asks for"});
  }
  return calibrations_.check_all_used();
}

}  // namespace panelcal
