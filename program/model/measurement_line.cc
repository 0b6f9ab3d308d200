// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/fields/json.h"
#include "program/model/line_fields.h"
#include "program/model/recorded.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// A request or a measurement as a line has it.
struct MeasurementLine {
  MeasurementRequest request;
  Measurement answer;
  std::optional<bool> focus;
  std::optional<std::int64_t> seq;
  std::optional<int> tool;
  std::vector<int> tools;
  std::optional<Position<frame::Actual>> measured;
  std::optional<std::array<double, 3>> cov;
  std::vector<double> candidates;
  std::vector<double> candidates_by_camera;
  std::optional<std::array<double, 8>> listed_area;
  std::optional<Length> search_radius;
};

/// Of G34.
constexpr std::size_t kMaxTools = 4;
/// Numbers of one candidate: place, covariance, score, whether it counts.
constexpr std::size_t kCandidateNumbers = 7;
constexpr std::size_t kMaxMeasurementCandidates = 200;
constexpr std::size_t kJacobianNumbers = 10;
/// Far beyond any camera; squares of larger ones would leave no covariance.
constexpr Range kRecordedSlope{-1e15, 1e15};
/// Condition for the covariance of a place.
constexpr std::string_view kCovarianceWords = "xy^2 < xx yy, and sigmas from 1e-9 to 1000 mm";

std::string_view status_name(MeasurementStatus status) {
  return name(status);
}

std::string_view decider_word(Decider decider) {
  return name(decider);
}

std::string_view axes_word(ObservedAxes axes) {
  if (axes == ObservedAxes::Both) return "";
  return axes == ObservedAxes::X ? "x" : "y";
}

std::optional<ObservedAxes> axes_of_word(std::string_view word) {
  if (word == "x") return ObservedAxes::X;
  return word == "y" ? std::optional(ObservedAxes::Y) : std::nullopt;
}

#include "program/model/measurement.def"

/// Focusing has no seq, and needs no vision tool.
MeasurementLine written_request(const MeasurementRequest& request) {
  MeasurementLine line;
  line.request = request;
  line.request.file = without_folders(request.file);
  const std::vector<int>& tools = request.settings.tools;
  if (tools.size() > 1) line.tools = tools;
  if (request.seq < 0) {
    line.focus = true;
  } else {
    line.seq = request.seq;
    line.tool = tools.empty() ? 0 : tools.front();
  }
  return line;
}

std::array<double, 3> written_covariance(const Eigen::Matrix2d& cov) {
  return {cov(0, 0), cov(0, 1), cov(1, 1)};
}

/// A lone candidate that was found is the measured place.
bool lists_more_than_found(const Measurement& measurement) {
  const std::vector<MeasuredCandidate>& all = measurement.candidates;
  return measurement.status == MeasurementStatus::Found ? all.size() > 1 : !all.empty();
}

void write_candidates(const Measurement& measurement, MeasurementLine& line) {
  for (const MeasuredCandidate& c : measurement.candidates) {
    const Eigen::Vector2d& at_mm = c.place.position.in_mm();
    const auto [xx, xy, yy] = written_covariance(c.place.cov);
    line.candidates.insert(line.candidates.end(),
                           {at_mm.x(), at_mm.y(), xx, xy, yy, c.score, c.counts ? 1.0 : 0.0});
    get_matrix(c.by_camera, line.candidates_by_camera);
  }
}

Expected<void> read_tools(const JsonLine& line, const MeasurementLine& read, Measurement& out) {
  std::vector<int>& tools = out.request.settings.tools;
  tools = {*read.tool};
  if (!line.has("tools")) return {};
  tools = read.tools;
  if (tools.size() > 1 && tools.size() <= kMaxTools && tools.front() == *read.tool) return {};
  return failure(line.problem(
      "tools",
      kLineCode,
      fmt::format("two to {} vision tools, \"tool\" = {} first", kMaxTools, *read.tool)));
}

Expected<void> read_measured(const JsonLine& line, const MeasurementLine& read, Measurement& out) {
  if (out.status != MeasurementStatus::Found) {
    for (const std::string_view key : {"measured", "cov", "by_camera"}) {
      if (!line.has(key)) continue;
      return failure(line.problem(key, kLineCode, "no measured place unless status is found"));
    }
    return {};
  }
  if (!read.measured) return failure(line.missing("measured", kLineCode));
  if (!read.cov) return failure(line.missing("cov", kLineCode));
  out.measured = {*read.measured, recorded_covariance(*read.cov)};
  if (is_measured_covariance(out.measured.cov)) return {};
  return failure(line.problem(
      "cov", Code::MeasurementInvalid, fmt::format("[xx, xy, yy] with {}", kCovarianceWords)));
}

Expected<void> read_candidates(const JsonLine& line, MeasurementLine read, Measurement& out) {
  const std::size_t n = read.candidates.size() / kCandidateNumbers;
  if (read.candidates.size() != n * kCandidateNumbers || n > kMaxMeasurementCandidates) {
    return failure(line.problem("candidates",
                                kLineCode,
                                fmt::format("an array of {} numbers each, at most {}",
                                            kCandidateNumbers,
                                            kMaxMeasurementCandidates)));
  }
  std::vector<double>& by_camera = read.candidates_by_camera;
  if (!line.has("candidates_by_camera")) by_camera.resize(kJacobianNumbers * n);
  if (by_camera.size() != kJacobianNumbers * n) {
    return failure(line.problem("candidates_by_camera",
                                kLineCode,
                                fmt::format("an array of {} numbers", kJacobianNumbers * n)));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double* const c = &read.candidates[kCandidateNumbers * i];
    const bool is_near = std::max(std::abs(c[0]), std::abs(c[1])) <= kMostRecorded_mm;
    const bool has_score = c[5] >= 0 && c[5] <= 1;
    MeasuredCandidate& candidate = out.candidates.emplace_back();
    candidate.place = {position_mm<frame::Actual>(c[0], c[1]),
                       recorded_covariance({c[2], c[3], c[4]})};
    if (!is_near || !is_measured_covariance(candidate.place.cov) || !has_score ||
        !(c[6] == 0 || c[6] == 1)) {
      return failure(line.problem(
          "candidates",
          Code::MeasurementInvalid,
          fmt::format("x, y within {:g} mm of 0, xx, xy, yy with {}, score from 0 to 1, and 0 or 1",
                      kMostRecorded_mm,
                      kCovarianceWords)));
    }
    candidate.score = c[5];
    candidate.counts = c[6] == 1;
    candidate.by_camera = Eigen::Map<const Eigen::Matrix<double, 2, 5, Eigen::RowMajor>>(
        &by_camera[kJacobianNumbers * i]);
  }
  return {};
}

}  // namespace

Eigen::Matrix2d recorded_covariance(const std::array<double, 3>& cov) {
  Eigen::Matrix2d out;
  out << cov[0], cov[1], cov[1], cov[2];
  return out;
}

Expected<void> check_pattern(const JsonLine& line, const std::string& file) {
  if (!line.has("file_sha256") || !file.empty()) return {};
  return failure(line.problem("file_sha256", kLineCode, "the pattern's name, \"file\", beside it"));
}

Expected<Measurement> measurement_of(const JsonLine& line) {
  PANELCAL_TRY(MeasurementLine read, read_line(kMeasurementLine, line, kLineCode));
  PANELCAL_CHECK(check_pattern(line, read.request.file));
  Measurement out = std::move(read.answer);
  out.request = std::move(read.request);
  out.request.seq = *read.seq;
  PANELCAL_CHECK(read_tools(line, read, out));
  PANELCAL_CHECK(read_measured(line, read, out));
  if (read.listed_area) {
    ListedArea& area = out.listed.emplace();
    for (std::size_t k = 0; k < area.corners.size(); ++k) {
      const double* const xy_mm = &(*read.listed_area)[2 * k];
      area.corners[k] = position_mm<frame::Actual>(xy_mm[0], xy_mm[1]);
    }
    area.radius = read.search_radius;
  }
  PANELCAL_CHECK(read_candidates(line, std::move(read), out));
  return out;
}

JsonFile measurements_file() {
  return {"measurements.jsonl",
          "One object a line: `panelcal survey` prints requests, the first form, `run "
          "--save-measurements` writes measurements, and `run --measurements` reads them. A key "
          "whose value is null is as good as absent. See docs/formats/measurements.md.",
          {&kRequestLine, &kMeasurementLine}};
}

}  // namespace panelcal::internal

namespace panelcal {

std::string to_json(const MeasurementRequest& request) {
  return internal::json_text(
      internal::kRequestLine, internal::written_request(request), internal::JsonStyle::Line);
}

std::string to_json(const Measurement& measurement) {
  internal::MeasurementLine line = internal::written_request(measurement.request);
  line.answer = measurement;
  if (measurement.status == MeasurementStatus::Found) {
    line.measured = measurement.measured.position;
    line.cov = internal::written_covariance(measurement.measured.cov);
  } else {
    line.answer.by_camera.reset();
  }
  if (internal::lists_more_than_found(measurement)) internal::write_candidates(measurement, line);
  if (measurement.listed) {
    std::array<double, 8>& xy_mm = line.listed_area.emplace();
    for (std::size_t i = 0; i < xy_mm.size(); ++i) {
      xy_mm[i] = measurement.listed->corners[i / 2].in_mm()[static_cast<Eigen::Index>(i % 2)];
    }
    line.search_radius = measurement.listed->radius;
  }
  return internal::json_text(internal::kMeasurementLine, line, internal::JsonStyle::Line);
}

}  // namespace panelcal
