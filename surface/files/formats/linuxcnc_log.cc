// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstddef>

#include "surface/files/probe_readers.h"
#include "surface/files/text_fields.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// X Y Z A B C U V W.
constexpr std::size_t kAxes = 9;
constexpr std::array<std::string_view, kAxes> kAxisNames = {
    "X", "Y", "Z", "A", "B", "C", "U", "V", "W"};

}  // namespace

Expected<ProbeFile> parse_linuxcnc_log(std::string_view text,
                                       const std::string& file,
                                       const ProbeFileOptions& options) {
  const double unit_mm = options.unit_mm();
  ProbeFile out;
  out.format = ProbeFormat::LinuxCncLog;
  out.file = file;
  TextLines lines(text, file);
  while (true) {
    PANELCAL_TRY(const std::optional<TextField> line, lines.next_filled());
    if (!line) break;
    const std::vector<TextField> words = words_of(*line);
    if (words.size() < 3 || words.size() > kAxes) {
      return failure({Code::MeasurementFile,
                      {file, line->line, words.front().column},
                      fmt::format("a line of {} words", words.size()),
                      "3 to 9 numbers: X Y Z A B C U V W"});
    }
    if (out.points.size() == kMaxFileProbes) {
      return failure({Code::MeasurementFile,
                      {file, line->line, 1},
                      "the log is too long",
                      fmt::format("at most {} probes", kMaxFileProbes)});
    }
    std::array<double, kAxes> axes = {};
    for (std::size_t i = 0; i < words.size(); ++i) {
      PANELCAL_TRY(axes[i], number_of(file, words[i]));
      const bool must_rest = i > 2 && i + 1 < kAxes;
      if (must_rest && axes[i] != 0) {
        return failure(unexpected_field(
            file, words[i], fmt::format("{} at 0, where the probe hangs plumb", kAxisNames[i])));
      }
    }
    out.points.push_back({position_mm<frame::Nominal>(axes[0] * unit_mm, axes[1] * unit_mm),
                          {mm((axes[2] + axes[8]) * unit_mm), options.scatter()},
                          fmt::format("probe of line {}", line->line),
                          {file, line->line, words.front().column}});
  }
  return out;
}

}  // namespace panelcal::internal
