// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/probe_file_source.h"

#include <limits>
#include <optional>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/json_line.h"
#include "machine/sources/recorded_lines.h"
#include "surface/files/formats/probe_keys.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::JsonLine;

constexpr Code kProbeCode = Code::MeasurementFile;

constexpr std::int64_t kMaxProbeSeq = std::numeric_limits<std::int64_t>::max();
/// More spindles than a machine has.
constexpr int kMaxAxis = 63;

/// One line: the height of one Z axis, or that nothing was found.
struct ProbeLine {
  ProbeReading reading;  // without heights
  int axis = 0;
  std::optional<HeightEstimate> height;
};

Expected<Length> read_probed_height(const JsonLine& line, std::string_view key) {
  PANELCAL_TRY(const double height_mm,
               internal::recorded_number(line, key, internal::kRecordedPlace, kProbeCode));
  return mm(height_mm);
}

Expected<ProbeRequest> read_probe_request(const JsonLine& line) {
  ProbeRequest request;
  PANELCAL_TRY(request.seq, line.integer("probe", 0, kMaxProbeSeq, kProbeCode));
  PANELCAL_CHECK(internal::read_origin(line, request));
  PANELCAL_TRY(request.tool, internal::recorded_int(line, "tool"));
  PANELCAL_CHECK(internal::read_places(line, request));
  if (line.has("L")) {
    PANELCAL_TRY(request.memory, internal::recorded_int(line, "L"));
  }
  if (line.has("depth")) {
    PANELCAL_TRY(request.depth, read_probed_height(line, "depth"));
  }
  PANELCAL_TRY(request.reference, read_probed_height(line, "reference"));
  return request;
}

Expected<HeightEstimate> read_height(const JsonLine& line) {
  PANELCAL_TRY(const Length height, read_probed_height(line, "height"));
  PANELCAL_TRY(
      const double sigma_mm,
      internal::recorded_number(line, "sigma", internal::kRecordedSigma, Code::MeasurementInvalid));
  return HeightEstimate{height, mm(sigma_mm)};
}

Expected<ProbeLine> read_line(const JsonLine& line) {
  PANELCAL_CHECK(line.check_keys(internal::kProbeKeys, kProbeCode));
  ProbeLine read;
  PANELCAL_TRY(read.reading.request, read_probe_request(line));
  PANELCAL_TRY(const std::string status, line.text("status", kProbeCode));
  const auto known = probe_status_from_name(status);
  if (!known) return failure(line.problem("status", kProbeCode, "found or not_found"));
  read.reading.status = *known;
  if (*known == ProbeStatus::Found) {
    PANELCAL_TRY(read.axis, internal::recorded_int(line, "zaxis", kMaxAxis));
    PANELCAL_TRY(read.height, read_height(line));
  } else {
    for (const std::string_view key : {"zaxis", "height", "sigma"}) {
      if (!line.has(key)) continue;
      return failure(line.problem(key, kProbeCode, "no height unless status is found"));
    }
  }
  if (line.has("reason")) {
    PANELCAL_TRY(read.reading.reason, line.text("reason", kProbeCode));
  }
  return read;
}

/// Puts the lines of each probe together.
class ProbeCollector {
 public:
  explicit ProbeCollector(const std::string& file) : recorded_{file, {}} {}

  Expected<void> add(const JsonLine& parsed, ProbeLine line, int number) {
    const auto [at, is_new] =
        index_by_seq_.emplace(line.reading.request.seq, recorded_.probes.size());
    if (is_new) {
      recorded_.probes.push_back({std::move(line.reading), number});
      heights_.emplace_back();
    } else {
      PANELCAL_CHECK(check_same(parsed, line.reading, recorded_.probes[at->second]));
    }
    if (!line.height) return {};
    if (heights_[at->second].emplace(line.axis, *line.height).second) return {};
    return failure(parsed.problem(
        "zaxis", kProbeCode, fmt::format("each Z axis of probe {} once", at->first)));
  }

  Expected<RecordedProbes> finish() {
    for (std::size_t i = 0; i < recorded_.probes.size(); ++i) {
      RecordedProbe& probe = recorded_.probes[i];
      for (const auto& [axis, height] : heights_[i]) {
        const std::size_t next = probe.answer.heights.size();
        if (static_cast<std::size_t>(axis) != next) {
          return failure(
              wrong_axes(probe,
                         fmt::format("has no zaxis {}", next),
                         fmt::format("every one from 0 to {}", heights_[i].rbegin()->first)));
        }
        probe.answer.heights.push_back(height);
      }
      if (probe.answer.status != ProbeStatus::Found) continue;
      const std::size_t n_axes = probe.answer.heights.size();
      if (n_axes_ == 0) n_axes_ = n_axes;
      if (n_axes == n_axes_) continue;
      return failure(wrong_axes(
          probe, fmt::format("has {} Z axes", n_axes), fmt::format("{} as before", n_axes_)));
    }
    return std::move(recorded_);
  }

 private:
  static Expected<void> check_same(const JsonLine& parsed,
                                   const ProbeReading& reading,
                                   const RecordedProbe& first) {
    const bool is_one_of_several =
        reading.status == ProbeStatus::Found && first.answer.status == ProbeStatus::Found;
    if (!is_one_of_several) {
      return failure(parsed.problem(
          "probe",
          kProbeCode,
          fmt::format("each number once if it is not found; line {} has this one already",
                      first.line)));
    }
    if (to_json(reading.request) == to_json(first.answer.request) &&
        reading.reason == first.answer.reason) {
      return {};
    }
    return failure(parsed.problem(
        "probe",
        kProbeCode,
        fmt::format("the same request as in line {}, which has this number already", first.line)));
  }

  Diagnostic wrong_axes(const RecordedProbe& probe, std::string_view what, std::string expected) {
    return {kProbeCode,
            {recorded_.file, probe.line, 1},
            fmt::format("probe {} {}", probe.answer.request.seq, what),
            std::move(expected)};
  }

  RecordedProbes recorded_;
  std::vector<std::map<int, HeightEstimate>> heights_;  // by probe and Z axis
  std::map<std::int64_t, std::size_t> index_by_seq_;
  std::size_t n_axes_ = 0;
};

}  // namespace

Expected<RecordedProbes> parse_probes(std::string_view text, const std::string& file) {
  ProbeCollector collector(file);
  PANELCAL_CHECK(internal::read_recorded_lines(
      text, file, [&](const JsonLine& line, int number) -> Expected<void> {
        PANELCAL_TRY(ProbeLine read, read_line(line));
        return collector.add(line, std::move(read), number);
      }));
  return collector.finish();
}

Expected<RecordedProbes> read_probes(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxProbeBytes));
  return parse_probes(text, path.string());
}

ProbeFileSource::ProbeFileSource(RecordedProbes recorded)
    : answers_(std::move(recorded.file), "probe", std::move(recorded.probes)) {
}

Expected<ProbeReading> ProbeFileSource::probe(const ProbeRequest& request) {
  return answers_.answer(request, "a reading");
}

}  // namespace panelcal
