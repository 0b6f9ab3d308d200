// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/calibration_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/noted_head.h"
#include "calib/base/json/strict_json.h"
#include "calib/camera/calibration/calibration_file.h"
#include <Eigen/Core>
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::StrictObject;

constexpr std::string_view kSpindleKind = "spindle-camera";
constexpr int kSpindleVersion = 1;
/// As machine.toml has it: what is larger has the wrong unit.
constexpr double kMaxPlace_mm = 1e5;
constexpr double kMaxSigma_mm = 1e3;
constexpr double kMaxScatter_um = 1e6;
constexpr int kMaxCount = 1'000'000;

Diagnostic invalid_spindle_file(const std::string& file, std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

std::string words(SpindleAt at) {
  return fmt::format("spindle {} station {}", at.spindle, at.station);
}

Expected<void> check_spindle_offset(SpindleAt at,
                                    const SpindleCameraOffset& offset,
                                    const std::string& file) {
  const Eigen::Vector2d& d_mm = offset.offset.in_mm();
  if (!(d_mm.cwiseAbs().maxCoeff() <= kMaxPlace_mm) || !d_mm.allFinite()) {
    return failure(invalid_spindle_file(
        file,
        fmt::format("the offset of {} is ({}, {}) mm", words(at), d_mm.x(), d_mm.y()),
        fmt::format("at most {} mm", kMaxPlace_mm)));
  }
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

Expected<void> check_spindle_offset(const SpindleQuality& quality,
                                    SpindleAt at,
                                    const std::string& file) {
  const auto is_count = [](int n) { return n >= 0 && n <= kMaxCount; };
  bool is_sound =
      is_count(quality.n_holes) && is_count(quality.n_looks) && is_count(quality.n_left_out);
  constexpr std::array<double, 2> kNone = {};
  for (const auto& scatter_um : {quality.wander_um, quality.repeatability_um.value_or(kNone)}) {
    for (const double along_um : scatter_um) {
      is_sound = is_sound && along_um >= 0 && along_um <= kMaxScatter_um;
    }
  }
  for (const std::optional<double>& backlash_um : quality.backlash_um) {
    is_sound = is_sound && std::abs(backlash_um.value_or(0)) <= kMaxScatter_um;
  }
  if (is_sound) return {};
  return failure(invalid_spindle_file(file,
                                      fmt::format("the quality of {} is not valid", words(at)),
                                      "counts and scatters from 0, and finite numbers"));
}

/// Checks what the types cannot express.
Expected<void> check_spindle_offset(const SpindleCalibration& calibration,
                                    const std::string& file) {
  if (calibration.offsets.empty()) {
    return failure(invalid_spindle_file(file, "there is no offset", "one spindle or more"));
  }
  for (const auto& [at, offset] : calibration.offsets.all()) {
    PANELCAL_CHECK(check_spindle_offset(at, offset, file));
  }
  for (const auto& [at, record] : calibration.records) {
    if (calibration.offsets.find(at) == nullptr) {
      return failure(
          invalid_spindle_file(file, fmt::format("{} has no offset", words(at)), "one for each"));
    }
    if (record.date > calibration.date) {
      return failure(invalid_spindle_file(
          file,
          fmt::format(
              "{} was calibrated {}, after the file's own date", words(at), iso_8601(record.date)),
          "the newest offset's date"));
    }
    if (record.quality) PANELCAL_CHECK(check_spindle_offset(*record.quality, at, file));
  }
  return {};
}

Expected<std::chrono::sys_seconds> read_spindle_date(const StrictObject& object,
                                                     const std::string& file) {
  PANELCAL_TRY(const std::string text, object.text("date"));
  if (const std::optional<std::chrono::sys_seconds> date = from_iso_8601(text)) return *date;
  return failure(invalid_spindle_file(
      file, "\"date\" is " + quoted(text), "a time such as 2026-11-21T08:37:38Z"));
}

Expected<std::array<double, 2>> read_pair(const StrictObject& object, std::string_view key) {
  PANELCAL_TRY(const std::vector<double> numbers, object.numbers(key, 2));
  return std::array<double, 2>{numbers[0], numbers[1]};
}

Expected<std::array<std::optional<double>, 2>> read_backlash(const StrictObject& quality,
                                                             const std::string& file) {
  const nlohmann::json& value = quality.member("backlash_um");
  std::array<std::optional<double>, 2> backlash_um;
  const auto is_fit = [](const nlohmann::json& v) { return v.is_null() || v.is_number(); };
  if (!value.is_array() || value.size() != 2 || !is_fit(value[0]) || !is_fit(value[1])) {
    return failure(invalid_spindle_file(
        file, "\"backlash_um\" in quality is wrong", "two of: a number or null"));
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (value[i].is_number()) backlash_um[i] = value[i].get<double>();
  }
  return backlash_um;
}

Expected<std::optional<SpindleQuality>> read_quality(const StrictObject& offset,
                                                     const std::string& file) {
  constexpr std::array<std::string_view, 6> kKeys = {
      "holes", "looks", "left_out", "wander_um", "repeatability_um", "backlash_um"};
  if (offset.member("quality").is_null()) return std::nullopt;
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(
                   offset.member("quality"), "quality", kKeys, Code::CalibrationInvalid, file));
  SpindleQuality quality;
  PANELCAL_TRY(quality.n_holes, object.integer("holes", 0, kMaxCount));
  PANELCAL_TRY(quality.n_looks, object.integer("looks", 0, kMaxCount));
  PANELCAL_TRY(quality.n_left_out, object.integer("left_out", 0, kMaxCount));
  PANELCAL_TRY(quality.wander_um, read_pair(object, "wander_um"));
  if (!object.member("repeatability_um").is_null()) {
    PANELCAL_TRY(quality.repeatability_um, read_pair(object, "repeatability_um"));
  }
  PANELCAL_TRY(quality.backlash_um, read_backlash(object, file));
  return quality;
}

Expected<void> read_offset(const nlohmann::json& value,
                           const std::string& file,
                           SpindleCalibration& calibration) {
  constexpr std::array<std::string_view, 6> kKeys = {
      "spindle", "station", "date", "offset_mm", "covariance_mm2", "quality"};
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(value, "offsets", kKeys, Code::CalibrationInvalid, file));
  SpindleAt at;
  PANELCAL_TRY(at.spindle, object.integer("spindle", 1, kMostSpindles));
  PANELCAL_TRY(at.station, object.integer("station", 1, kMostStations));
  if (calibration.offsets.find(at) != nullptr) {
    return failure(
        invalid_spindle_file(file, words(at) + " is there twice", "each spindle and station once"));
  }
  SpindleOffsetRecord record;
  PANELCAL_TRY(record.date, read_spindle_date(object, file));
  PANELCAL_TRY(record.quality, read_quality(object, file));
  PANELCAL_TRY(const auto offset_mm, read_pair(object, "offset_mm"));
  PANELCAL_TRY(const std::vector<double> cov, object.matrix("covariance_mm2", 2, 2));
  SpindleCameraOffset offset;
  offset.offset = displacement_mm<frame::Machine>(offset_mm[0], offset_mm[1]);
  offset.cov_mm2 << cov[0], cov[1], cov[2], cov[3];
  PANELCAL_CHECK(check_spindle_offset(at, offset, file));
  calibration.offsets.set(at, offset);
  calibration.records.emplace(at, std::move(record));
  return {};
}

/// A negative zero would not read back.
std::string pair_text(double x, double y) {
  x += 0.0;
  y += 0.0;
  return fmt::format("[{}, {}]", x, y);
}
std::string pair_text(const std::array<double, 2>& v) {
  return pair_text(v[0], v[1]);
}

std::string number_text(const std::optional<double>& number) {
  return number ? fmt::format("{}", *number + 0.0) : "null";
}

std::string quality_text(const std::optional<SpindleQuality>& quality) {
  if (!quality) return "null";
  return fmt::format(
      R"({{"holes": {}, "looks": {}, "left_out": {}, "wander_um": {},
       "repeatability_um": {}, "backlash_um": [{}, {}]}})",
      quality->n_holes,
      quality->n_looks,
      quality->n_left_out,
      pair_text(quality->wander_um),
      quality->repeatability_um ? pair_text(*quality->repeatability_um) : "null",
      number_text(quality->backlash_um[0]),
      number_text(quality->backlash_um[1]));
}

std::string offset_text(SpindleAt at,
                        const SpindleCameraOffset& offset,
                        const SpindleCalibration& calibration) {
  const auto record = calibration.records.find(at);
  const Eigen::Matrix2d& cov = offset.cov_mm2;
  return fmt::format(
      R"(    {{"spindle": {}, "station": {}, "date": "{}",
     "offset_mm": {},
     "covariance_mm2": [{}, {}],
     "quality": {}}})",
      at.spindle,
      at.station,
      iso_8601(calibration.date_of(at)),
      pair_text(offset.offset.in_mm().x(), offset.offset.in_mm().y()),
      pair_text(cov(0, 0), cov(0, 1)),
      pair_text(cov(1, 0), cov(1, 1)),
      quality_text(record == calibration.records.end() ? std::nullopt : record->second.quality));
}

}  // namespace

std::chrono::sys_seconds SpindleCalibration::date_of(SpindleAt at) const {
  const auto record = records.find(at);
  return record == records.end() ? date : record->second.date;
}

Expected<SpindleCalibration> parse_spindle_calibration(std::string_view text,
                                                       const std::string& file) {
  constexpr std::array<std::string_view, 6> kKeys = {
      "kind", "version", "date", "provenance", "units", "offsets"};
  constexpr std::array<std::string_view, 1> kUnitKeys = {"length"};
  PANELCAL_TRY(const nlohmann::json document, internal::parse_calibration_json(text, file));
  PANELCAL_TRY(
      const StrictObject top,
      StrictObject::make(document, "the calibration", kKeys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(top.constant("kind", kSpindleKind));
  PANELCAL_TRY(const int version, top.integer("version", kSpindleVersion, kSpindleVersion));
  static_cast<void>(version);
  PANELCAL_TRY(
      const StrictObject units,
      StrictObject::make(top.member("units"), "units", kUnitKeys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(units.constant("length", "mm"));
  SpindleCalibration calibration;
  PANELCAL_TRY(calibration.date, read_spindle_date(top, file));
  PANELCAL_TRY(calibration.provenance, top.text("provenance"));
  const nlohmann::json& offsets = top.member("offsets");
  if (!offsets.is_array()) {
    return failure(invalid_spindle_file(file, "\"offsets\" is no array", "an array of objects"));
  }
  for (const nlohmann::json& offset : offsets) {
    PANELCAL_CHECK(read_offset(offset, file, calibration));
  }
  PANELCAL_CHECK(check_spindle_offset(calibration, file));
  return calibration;
}

Expected<SpindleCalibration> read_spindle_calibration(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxCalibrationBytes));
  return parse_spindle_calibration(text, path.string());
}

std::string spindle_calibration_text(const SpindleCalibration& calibration) {
  const std::string provenance = nlohmann::json(calibration.provenance)
                                     .dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::string text = fmt::format(R"({{
  "kind": "{}",
  "version": {},
  "date": "{}",
  "provenance": {},
  "units": {{"length": "mm"}},
  "offsets": [
)",
                                 kSpindleKind,
                                 kSpindleVersion,
                                 iso_8601(calibration.date),
                                 provenance);
  std::string_view between;
  for (const auto& [at, offset] : calibration.offsets.all()) {
    text += between;
    text += offset_text(at, offset, calibration);
    between = ",\n";
  }
  return text + "\n  ]\n}\n";
}

Expected<void> write_spindle_calibration(const std::filesystem::path& path,
                                         const SpindleCalibration& calibration) {
  PANELCAL_CHECK(check_spindle_offset(calibration, path.string()));
  return write_file(path, spindle_calibration_text(calibration));
}

}  // namespace panelcal
