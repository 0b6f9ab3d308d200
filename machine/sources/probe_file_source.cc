// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/probe_file_source.h"

#include <map>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/json_line.h"
#include "machine/sources/recorded_lines.h"
#include "program/walk/probe_line.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::JsonLine;

constexpr Code kProbeCode = Code::MeasurementFile;

using internal::ProbeLine;

/// Puts the lines of each probe together.
class ProbeCollector {
 public:
  explicit ProbeCollector(const std::string& file) : recorded_{file, {}} {}

  Expected<void> add(const JsonLine& parsed, ProbeLine line, int number) {
    const auto [at, is_new] = index_by_seq_.emplace(line.request.seq, recorded_.probes.size());
    ProbeReading reading = {std::move(line.request), line.status, {}, std::move(line.reason)};
    if (is_new) {
      recorded_.probes.push_back({std::move(reading), number});
      heights_.emplace_back();
    } else {
      PANELCAL_CHECK(check_same(parsed, reading, recorded_.probes[at->second]));
    }
    if (!line.height) return {};
    const HeightEstimate height = {*line.height, *line.sigma};
    if (heights_[at->second].emplace(*line.axis, height).second) return {};
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
        PANELCAL_TRY(ProbeLine read, internal::probe_line_of(line));
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
