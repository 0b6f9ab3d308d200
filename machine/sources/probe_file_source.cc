// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/probe_file_source.h"

#include <limits>
#include <optional>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/json_line.h"
#include "machine/sources/recorded_ranges.h"
#include "surface/files/formats/probe_keys.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::JsonLine;

constexpr Code kProbeCode = Code::MeasurementFile;

constexpr int kMaxProbeInt = std::numeric_limits<int>::max();
constexpr std::int64_t kMaxProbeSeq = std::numeric_limits<std::int64_t>::max();
/// More levels than any nesting limit of a program, subprogram calls counted.
constexpr std::size_t kMaxProbePath = 128;
/// More spindles than a machine has.
constexpr int kMaxAxis = 63;
constexpr std::size_t kMaxProbeLine = std::size_t{1} << 16;

/// Recorded and requested nominals come from the same arithmetic; this only forgives printing.
constexpr double kSameProbed_mm = 1e-6;

/// One line: the height of one Z axis, or that nothing was found.
struct ProbeLine {
  ProbeReading reading;  // without heights
  int axis = 0;
  std::optional<HeightEstimate> height;
};

Expected<Eigen::Vector2d> read_probed_point(const JsonLine& line, std::string_view key) {
  return internal::recorded_place(line, key, kProbeCode);
}

Expected<Length> read_probed_height(const JsonLine& line, std::string_view key) {
  PANELCAL_TRY(const double height_mm,
               internal::recorded_number(line, key, internal::kRecordedPlace, kProbeCode));
  return mm(height_mm);
}

Expected<int> read_int(const JsonLine& line, std::string_view key, int high = kMaxProbeInt) {
  PANELCAL_TRY(const std::int64_t value, line.integer(key, 0, high, kProbeCode));
  return static_cast<int>(value);
}

Expected<ProbeRequest> read_probe_request(const JsonLine& line) {
  ProbeRequest request;
  PANELCAL_TRY(request.seq, line.integer("probe", 0, kMaxProbeSeq, kProbeCode));
  PANELCAL_TRY(request.line, read_int(line, "line"));
  PANELCAL_CHECK(read_pattern(line, kProbeCode, request.file, request.file_sha256));
  PANELCAL_TRY(request.command, line.text("command", kProbeCode));
  PANELCAL_TRY(request.tool, read_int(line, "tool"));
  PANELCAL_TRY(const Eigen::Vector2d nominal_mm, read_probed_point(line, "nominal"));
  request.nominal = position_mm<frame::Nominal>(nominal_mm);
  PANELCAL_TRY(const Eigen::Vector2d expected_mm, read_probed_point(line, "expected"));
  request.expected = position_mm<frame::Actual>(expected_mm);
  PANELCAL_TRY(request.path, line.integers("path", 0, kMaxProbeInt, kMaxProbePath, kProbeCode));
  if (line.has("L")) {
    PANELCAL_TRY(request.memory, read_int(line, "L"));
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
    PANELCAL_TRY(read.axis, read_int(line, "zaxis", kMaxAxis));
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
        const std::size_t next = probe.reading.heights.size();
        if (static_cast<std::size_t>(axis) != next) {
          return failure(
              wrong_axes(probe,
                         fmt::format("has no zaxis {}", next),
                         fmt::format("every one from 0 to {}", heights_[i].rbegin()->first)));
        }
        probe.reading.heights.push_back(height);
      }
      if (probe.reading.status != ProbeStatus::Found) continue;
      const std::size_t n_axes = probe.reading.heights.size();
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
        reading.status == ProbeStatus::Found && first.reading.status == ProbeStatus::Found;
    if (!is_one_of_several) {
      return failure(parsed.problem(
          "probe",
          kProbeCode,
          fmt::format("each number once if it is not found; line {} has this one already",
                      first.line)));
    }
    if (to_json(reading.request) == to_json(first.reading.request) &&
        reading.reason == first.reading.reason) {
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
            fmt::format("probe {} {}", probe.reading.request.seq, what),
            std::move(expected)};
  }

  RecordedProbes recorded_;
  std::vector<std::map<int, HeightEstimate>> heights_;  // by probe and Z axis
  std::map<std::int64_t, std::size_t> index_by_seq_;
  std::size_t n_axes_ = 0;
};

std::string probed_point_text(const Eigen::Vector2d& p_mm) {
  return fmt::format("[{}, {}]", p_mm.x(), p_mm.y());
}

/// In which way a recorded request is another one than the program's; empty if it is the same.
struct ProbeDifference {
  std::string recorded;
  std::string requested;
};
std::optional<ProbeDifference> probe_difference(const ProbeRequest& recorded,
                                                const ProbeRequest& requested) {
  const auto differs = [](std::string_view what, const auto& a, const auto& b) {
    return ProbeDifference{fmt::format("{} {}", what, a), fmt::format("{} {}", what, b)};
  };
  if (recorded.command != requested.command) {
    return differs("command", quoted(recorded.command), quoted(requested.command));
  }
  if (!is_same_pattern(recorded.pattern(), requested.pattern())) {
    return differs("file", pattern_text(recorded.pattern()), pattern_text(requested.pattern()));
  }
  if (recorded.line != requested.line) return differs("line", recorded.line, requested.line);
  if (recorded.tool != requested.tool) return differs("tool", recorded.tool, requested.tool);
  if (recorded.path != requested.path) {
    return differs("path",
                   fmt::format("[{}]", fmt::join(recorded.path, ",")),
                   fmt::format("[{}]", fmt::join(requested.path, ",")));
  }
  const Displacement<frame::Nominal> apart = recorded.nominal - requested.nominal;
  // Written so that a NaN differs.
  if (!(apart.in_mm().norm() <= kSameProbed_mm)) {
    return differs("nominal",
                   probed_point_text(recorded.nominal.in_mm()),
                   probed_point_text(requested.nominal.in_mm()));
  }
  return std::nullopt;
}

}  // namespace

Expected<RecordedProbes> parse_probes(std::string_view text, const std::string& file) {
  ProbeCollector collector(file);
  int number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const Place place{file, number, 1};
    if (line.size() > kMaxProbeLine) {
      return failure({kProbeCode,
                      place,
                      "the line is too long",
                      fmt::format("at most {} bytes", kMaxProbeLine)});
    }
    PANELCAL_TRY(const JsonLine parsed, JsonLine::parse(line, place));
    PANELCAL_TRY(ProbeLine read, read_line(parsed));
    PANELCAL_CHECK(collector.add(parsed, std::move(read), number));
  }
  return collector.finish();
}

Expected<RecordedProbes> read_probes(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxProbeBytes));
  return parse_probes(text, path.string());
}

ProbeFileSource::ProbeFileSource(RecordedProbes recorded) : recorded_(std::move(recorded)) {
  for (std::size_t i = 0; i < recorded_.probes.size(); ++i) {
    by_seq_.emplace(recorded_.probes[i].reading.request.seq, Entry{i, false});
  }
}

Expected<ProbeReading> ProbeFileSource::probe(const ProbeRequest& request) {
  const auto found = by_seq_.find(request.seq);
  if (found == by_seq_.end()) {
    return failure({Code::MeasurementMissing,
                    {recorded_.file, 0, 0},
                    "there is no probe " + std::to_string(request.seq),
                    "a reading for " + describe(request)});
  }
  const RecordedProbe& recorded = recorded_.probes[found->second.index];
  if (const auto differs = probe_difference(recorded.reading.request, request)) {
    return failure({Code::MeasurementMismatch,
                    {recorded_.file, recorded.line, 1},
                    fmt::format("probe {} has {}", request.seq, differs->recorded),
                    differs->requested + ", as the program has it"});
  }
  found->second.is_used = true;
  ProbeReading reading = recorded.reading;
  reading.request = request;
  return reading;
}

Expected<void> ProbeFileSource::check_all_used() const {
  for (const RecordedProbe& recorded : recorded_.probes) {
    const ProbeRequest& request = recorded.reading.request;
    if (by_seq_.at(request.seq).is_used) continue;
    return failure({Code::MeasurementMismatch,
                    {recorded_.file, recorded.line, 1},
                    fmt::format("the program does not ask for {}", describe(request)),
                    "only what the program asks for"});
  }
  return {};
}

}  // namespace panelcal
