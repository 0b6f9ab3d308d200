// SPDX-License-Identifier: Apache-2.0
#include "surface/files/probe_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "surface/files/probe_readers.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Reader = Expected<ProbeFile> (*)(std::string_view text,
                                       const std::string& file,
                                       const ProbeFileOptions& options);

struct FormatRow {
  ProbeFormat format;
  std::string_view name;
  std::string_view extension;  ///< empty: none of its own
  std::string_view beginning;  ///< of its text; empty: none that is sure
  Reader read;
};

/// In the order of ProbeFormat.
constexpr std::array<FormatRow, 5> kFormats = {
    {{ProbeFormat::HeightMapCsv,
      "heightmap",
      ".csv",
      "RepRapFirmware height map",
      internal::parse_height_map_csv},
     {ProbeFormat::LinuxCncLog, "linuxcnc", "", "", internal::parse_linuxcnc_log},
     {ProbeFormat::BcncProbe, "bcnc", ".probe", "", internal::parse_bcnc_probe},
     {ProbeFormat::OpenCncPilotMap, "opencncpilot", ".hmap", "<", internal::parse_opencncpilot_map},
     {ProbeFormat::RecordedProbes, "probes", ".jsonl", "{", internal::parse_recorded_probes}}};

const FormatRow& row_of(ProbeFormat format) {
  return kFormats[static_cast<std::size_t>(format)];
}

std::string lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

ProbeFormat format_of(std::string_view text, const std::string& file) {
  const std::string extension = lower(std::filesystem::path(file).extension().string());
  for (const FormatRow& row : kFormats) {
    if (!row.extension.empty() && row.extension == extension) return row.format;
  }
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  if (text.starts_with(kUtf8Mark)) text.remove_prefix(kUtf8Mark.size());
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  for (const FormatRow& row : kFormats) {
    if (!row.beginning.empty() && text.starts_with(row.beginning)) return row.format;
  }
  return ProbeFormat::LinuxCncLog;
}

}  // namespace

std::string_view name_of(ProbeFormat format) {
  return row_of(format).name;
}

std::optional<ProbeFormat> probe_format_from_name(std::string_view name) {
  const auto found = std::ranges::find(kFormats, name, &FormatRow::name);
  if (found == kFormats.end()) return std::nullopt;
  return found->format;
}

Expected<void> ProbeFileOptions::validate() const {
  const auto bad = [](const char* field, double value, const char* expected) {
    return failure({Code::ConfigValue, {}, fmt::format("{} is {}", field, value), expected});
  };
  if (!(scatter().in_mm() > 0 && std::isfinite(scatter().in_mm()))) {
    return bad("sigma_mm", scatter().in_mm(), "above 0 mm");
  }
  if (!(unit >= um(1) && unit <= mm(1000))) return bad("unit_mm", unit.in_mm(), "0.001 to 1000 mm");
  if (z_axis && *z_axis < 0) return bad("zaxis", *z_axis, "0 or more");
  return {};
}

Expected<ProbeFile> parse_probe_file(std::string_view text,
                                     const std::string& file,
                                     const ProbeFileOptions& options) {
  PANELCAL_CHECK(options.validate());
  const ProbeFormat format = options.format.value_or(format_of(text, file));
  PANELCAL_TRY(ProbeFile out, row_of(format).read(text, file, options));
  if (out.points.empty()) {
    return failure({Code::MeasurementFile, {file, 0, 0}, "no height at all", "probed heights"});
  }
  const bool is_assumed = !options.sigma && format != ProbeFormat::RecordedProbes;
  for (ProbePoint& point : out.points) point.is_sigma_assumed = is_assumed;
  return out;
}

Expected<ProbeFile> read_probe_file(const std::filesystem::path& path,
                                    const ProbeFileOptions& options) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxProbeFileBytes));
  return parse_probe_file(text, path.string(), options);
}

}  // namespace panelcal
