// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "surface/files/probe_readers.h"
#include "surface/files/text_fields.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr Code kCode = Code::MeasurementFile;

/// One line: the height of one Z axis, or that nothing was found.
struct Reading {
  std::int64_t probe = 0;
  Eigen::Vector2d nominal_mm = Eigen::Vector2d::Zero();
  bool is_found = false;
  std::optional<int> z_axis;  ///< empty: nothing was found
  std::optional<Length> height;
  std::optional<Length> sigma;
  std::string reason = "the probe found nothing";
  Place from;
};

std::optional<bool> found_of_word(std::string_view word) {
  if (word == "found") return true;
  return word == "not_found" ? std::optional(false) : std::nullopt;
}

#include "surface/files/formats/recorded_probes.def"

Expected<Reading> reading_of(const JsonLine& line, Place from) {
  PANELCAL_TRY(Reading out, read_line(kReading, line, kCode));
  out.from = std::move(from);
  for (const std::string_view key : {"zaxis", "height", "sigma"}) {
    if (line.has(key) == out.is_found) continue;
    if (out.is_found) return failure(line.missing(key, kCode));
    return failure(line.problem(key, kCode, "no height unless status is found"));
  }
  if (out.sigma && !(*out.sigma > Length())) {
    return failure(line.problem("sigma", Code::MeasurementInvalid, "above 0 for a map"));
  }
  return out;
}

/// The readings of each probe, in the order of their first lines.
class Probes {
 public:
  Expected<void> add(const JsonLine& line, Reading reading) {
    const auto [at, is_new] = index_.emplace(reading.probe, probes_.size());
    if (is_new) probes_.emplace_back();
    std::vector<Reading>& others = probes_[at->second];
    for (const Reading& other : others) {
      const auto again = [&](std::string_view key, std::string_view expected) {
        return failure(
            line.problem(key, kCode, fmt::format("{} in line {}", expected, other.from.line)));
      };
      if (other.nominal_mm != reading.nominal_mm) return again("nominal", "the same place as");
      if (!other.z_axis || !reading.z_axis) return again("probe", "no other reading of it, as");
      if (*other.z_axis == *reading.z_axis) return again("zaxis", "another one than");
    }
    others.push_back(std::move(reading));
    return {};
  }

  Expected<ProbeFile> finish(const std::string& file, const ProbeFileOptions& options) const;

 private:
  std::vector<std::vector<Reading>> probes_;
  std::map<std::int64_t, std::size_t> index_;
};

Expected<ProbeFile> Probes::finish(const std::string& file, const ProbeFileOptions& options) const {
  ProbeFile out;
  out.format = ProbeFormat::RecordedProbes;
  out.file = file;
  out.states_sigma = true;
  std::optional<int> z_axis = options.z_axis;  // chosen, or the only one so far
  for (const std::vector<Reading>& readings : probes_) {
    const Reading& first = readings.front();
    const auto place = position_mm<frame::Nominal>(first.nominal_mm);
    std::string name = fmt::format("probe {}", first.probe);
    if (!first.z_axis) {
      out.missing.push_back({place, std::move(name), first.reason, first.from});
      continue;
    }
    if (readings.size() > 1 && !options.z_axis) {
      return failure({kCode,
                      first.from,
                      fmt::format("probe {} has {} Z axes", first.probe, readings.size()),
                      "a choice of one of them"});
    }
    if (!z_axis) z_axis = *first.z_axis;
    const Reading* chosen = nullptr;
    for (const Reading& reading : readings) {
      if (*reading.z_axis == *z_axis) chosen = &reading;
    }
    if (chosen == nullptr) {
      return failure({kCode,
                      first.from,
                      fmt::format("probe {} has no zaxis {}", first.probe, *z_axis),
                      options.z_axis ? "the chosen one" : "that of the probes before it"});
    }
    // A machine with one Z axis calls it 0, whichever spindle that is.
    if (options.z_axis || readings.size() > 1 || *z_axis > 0) out.z_axis = z_axis;
    const HeightEstimate height = {*chosen->height, *chosen->sigma};
    out.points.push_back({place, height, std::move(name), chosen->from});
  }
  return out;
}

}  // namespace

Expected<ProbeFile> parse_recorded_probes(std::string_view text,
                                          const std::string& file,
                                          const ProbeFileOptions& options) {
  TextLines lines(text, file);
  Probes probes;
  for (std::size_t n = 0;; ++n) {
    PANELCAL_TRY(const std::optional<TextField> line, lines.next_filled());
    if (!line) break;
    const Place from{file, line->line, line->column};
    if (n == kMaxFileProbes) {
      return failure(
          {kCode, from, "the file is too long", fmt::format("at most {} lines", kMaxFileProbes)});
    }
    PANELCAL_TRY(const JsonLine parsed, JsonLine::parse(line->text, from));
    PANELCAL_TRY(Reading reading, reading_of(parsed, from));
    PANELCAL_CHECK(probes.add(parsed, std::move(reading)));
  }
  return probes.finish(file, options);
}

}  // namespace panelcal::internal
