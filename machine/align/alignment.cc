// SPDX-License-Identifier: Apache-2.0
#include "machine/align/alignment.h"

#include <algorithm>
#include <array>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/strict_json.h"
#include "machine/align/json_file.h"
#include "machine/align/pads.h"
#include "program/model/recorded.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Beyond any machine.
constexpr Range kAlignmentPlace = {-1e5, 1e5};
constexpr std::size_t kMostAlignmentBytes = std::size_t{1} << 26;
constexpr const char* kMeasurementsKey = "measurements";

/// Measurements are no members of a table: alignment_text() and parse_alignment() have them.
bool put_apart(const void* /*alignment*/, FieldValue& /*value*/) {
  return false;
}

#include "machine/align/alignment.def"

Diagnostic invalid_alignment(const std::string& file, std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

/// Takes the measurements out of a parsed alignment.
Expected<std::vector<Measurement>> take_measurements(nlohmann::json& document,
                                                     const std::string& file) {
  const bool has_list = document.is_object() && document.contains(kMeasurementsKey) &&
                        document[kMeasurementsKey].is_array();
  if (!has_list) {
    return failure(
        invalid_alignment(file, "missing key \"measurements\"", "a list of measurements"));
  }
  const nlohmann::json list = std::exchange(document[kMeasurementsKey], nlohmann::json());
  document.erase(kMeasurementsKey);
  std::vector<Measurement> measurements;
  for (const nlohmann::json& one : list) {
    const std::string text = one.dump();
    PANELCAL_TRY(const JsonLine line, JsonLine::parse(text, {file, 0, 0}));
    PANELCAL_TRY(Measurement measurement, measurement_of(line));
    measurements.push_back(std::move(measurement));
  }
  return measurements;
}

/// A failed check may lack the place of a pad, which was not found then.
bool has_places(const AlignmentCheck& check) {
  if (check.pads.empty() || check.seen.size() > check.pads.size()) return false;
  return check.seen.size() == check.pads.size() || !check.is_accepted;
}

/// What the tables cannot express.
Expected<void> check_alignment(const Alignment& alignment) {
  const std::size_t n = alignment.measurements.size();
  if (n == 0 || n > kMostPads || alignment.names.size() != n) {
    return failure(
        invalid_alignment(alignment.file,
                          fmt::format("{} names of {} pads", alignment.names.size(), n),
                          fmt::format("as many as there are measurements, 1 to {}", kMostPads)));
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (alignment.measurements[i].request.seq == static_cast<std::int64_t>(i)) continue;
    return failure(invalid_alignment(
        alignment.file,
        fmt::format("seq {} of measurement {}", alignment.measurements[i].request.seq, i + 1),
        fmt::format("{}: they count from 0", i)));
  }
  std::chrono::sys_seconds last = alignment.time;
  for (const AlignmentCheck& check : alignment.checks) {
    const bool is_of_pads = has_places(check) && std::ranges::all_of(check.pads, [&](int pad) {
                              return static_cast<std::size_t>(pad) <= n;
                            });
    if (!is_of_pads || check.time < last) {
      return failure(invalid_alignment(alignment.file,
                                       "the check of " + iso_8601(check.time),
                                       "pads of the alignment, at a time after all before it"));
    }
    last = check.time;
  }
  return {};
}

}  // namespace

JsonFile alignment_file() {
  return {"align.json",
          "A panel that was measured once for all of its programs: `panelcal align` writes it, "
          "`panelcal align verify` adds to it, `run --align` reads it.",
          {&kAlignment}};
}

}  // namespace panelcal::internal

namespace panelcal {

std::chrono::sys_seconds Alignment::last_seen() const {
  return checks.empty() ? time : checks.back().time;
}

Expected<Alignment> parse_alignment(std::string_view text, const std::string& file) {
  PANELCAL_TRY(nlohmann::json document, internal::parse_strict_json(text, file));
  PANELCAL_TRY(std::vector<Measurement> measurements, internal::take_measurements(document, file));
  PANELCAL_TRY(Alignment alignment,
               internal::read_json(internal::kAlignment, document, Code::CalibrationInvalid, file));
  alignment.file = file;
  alignment.measurements = std::move(measurements);
  PANELCAL_CHECK(internal::check_alignment(alignment));
  return alignment;
}

Expected<Alignment> read_alignment(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, internal::kMostAlignmentBytes));
  return parse_alignment(text, path.string());
}

std::string alignment_text(const Alignment& alignment) {
  std::string text =
      internal::json_text(internal::kAlignment, alignment, internal::JsonStyle::File);
  text.resize(text.rfind('}'));
  text.resize(text.find_last_not_of("\n ") + 1);
  text += fmt::format(",\n  \"{}\": [", internal::kMeasurementsKey);
  std::string_view separator = "\n    ";
  for (const Measurement& measurement : alignment.measurements) {
    text += separator;
    text += to_json(measurement);
    separator = ",\n    ";
  }
  return text + "\n  ]\n}\n";
}

}  // namespace panelcal
