// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/calibration_file.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/fields/json.h"
#include "calib/base/fields/noted_head.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "calib/camera/calibration/calibration_file.h"
#include "calib/json_files.h"
#include <Eigen/Core>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// One spindle as the file has it.
struct SpindleRow {
  SpindleAt at;
  SpindleOffsetRecord record;
  SpindleCameraOffset offset;
};

struct SpindleFile {
  SpindleCalibration calibration;  ///< date and provenance
  std::vector<SpindleRow> offsets;
};

/// As machine.toml has it: what is larger has the wrong unit.
constexpr Range kSpindlePlace = {-1e5, 1e5};
constexpr double kMaxSigma_mm = 1e3;
constexpr WholeRange kSpindleCount = {0, 1'000'000};

#include "calib/spindle/calibration.def"

Diagnostic invalid_spindle_file(const std::string& file, std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

std::string words(SpindleAt at) {
  return fmt::format("spindle {} station {}", at.spindle, at.station);
}

Expected<void> check_spindle_offset(SpindleAt at,
                                    const SpindleCameraOffset& offset,
                                    const std::string& file) {
  // Whatever it does not take has no covariance: its place has been looked at.
  SpindleOffsets taker;
  if (taker.set(at, offset) &&
      offset.cov_mm2.diagonal().maxCoeff() <= kMaxSigma_mm * kMaxSigma_mm) {
    return {};
  }
  return failure(invalid_spindle_file(
      file,
      fmt::format("the covariance of {} is not positive semidefinite", words(at)),
      fmt::format("a symmetric, positive semidefinite one with sigmas up to {} mm", kMaxSigma_mm)));
}

/// Puts the rows together, and checks what they cannot express.
Expected<SpindleCalibration> calibration_of(SpindleFile read, const std::string& file) {
  SpindleCalibration& c = read.calibration;
  if (read.offsets.empty()) {
    return failure(invalid_spindle_file(file, "there is no offset", "one spindle or more"));
  }
  for (SpindleRow& row : read.offsets) {
    if (c.offsets.find(row.at) != nullptr) {
      return failure(invalid_spindle_file(
          file, words(row.at) + " is there twice", "each spindle and station once"));
    }
    PANELCAL_CHECK(check_spindle_offset(row.at, row.offset, file));
    if (row.record.date > c.date) {
      return failure(
          invalid_spindle_file(file,
                               fmt::format("{} was calibrated {}, after the file's own date",
                                           words(row.at),
                                           iso_8601(row.record.date)),
                               "the newest offset's date"));
    }
    c.offsets.set(row.at, row.offset);
    c.records.emplace(row.at, std::move(row.record));
  }
  return std::move(c);
}

}  // namespace

JsonFile spindle_file() {
  return {"spindle.cal.json",
          "The offsets of spindles and camera: `panelcal calibrate spindle-camera` and nights "
          "write it, `[spindle] calibration` of machine.toml names it.",
          {&kSpindle},
          true};
}

}  // namespace panelcal::internal

namespace panelcal {

std::chrono::sys_seconds SpindleCalibration::date_of(SpindleAt at) const {
  const auto record = records.find(at);
  return record == records.end() ? date : record->second.date;
}

Expected<SpindleCalibration> parse_spindle_calibration(std::string_view text,
                                                       const std::string& file) {
  PANELCAL_TRY(const nlohmann::json document, internal::parse_calibration_json(text, file));
  PANELCAL_TRY(auto read,
               internal::read_json(internal::kSpindle, document, Code::CalibrationInvalid, file));
  return internal::calibration_of(std::move(read), file);
}

Expected<SpindleCalibration> read_spindle_calibration(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxCalibrationBytes));
  return parse_spindle_calibration(text, path.string());
}

std::string spindle_calibration_text(const SpindleCalibration& calibration) {
  internal::SpindleFile file = {calibration, {}};
  for (const auto& [at, offset] : calibration.offsets.all()) {
    const auto record = calibration.records.find(at);
    file.offsets.push_back({at,
                            record == calibration.records.end()
                                ? SpindleOffsetRecord{calibration.date, {}}
                                : record->second,
                            offset});
  }
  return internal::json_text(internal::kSpindle, file, internal::JsonStyle::File);
}

Expected<void> write_spindle_calibration(const std::filesystem::path& path,
                                         const SpindleCalibration& calibration) {
  for (const auto& [at, record] : calibration.records) {
    if (calibration.offsets.find(at) != nullptr) continue;
    return failure(internal::invalid_spindle_file(
        path.string(), fmt::format("{} has no offset", internal::words(at)), "one for each"));
  }
  const std::string text = spindle_calibration_text(calibration);
  PANELCAL_CHECK(parse_spindle_calibration(text, path.string()));
  return write_file(path, text);
}

}  // namespace panelcal
