// SPDX-License-Identifier: Apache-2.0
#include "surface/files/probe_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "surface/files/probe_readers.h"
#include "surface/files/probe_signs.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Reader = Expected<ProbeFile> (*)(std::string_view text,
                                       const std::string& file,
                                       const ProbeFileOptions& options);

/// Options that only some formats take.
enum TakenOptions : unsigned { kTakesNone = 0, kTakesUnit = 1, kTakesProfile = 2, kTakesMesh = 4 };

struct FormatRow {
  ProbeFormat format;
  std::string_view name;
  std::string_view extension;  ///< empty: none of its own
  std::string_view what;       ///< as the list of what is read has it
  std::string_view zero;       ///< of ProbeFile, where its reader says none
  unsigned takes;
  bool (*is_it)(std::string_view text);
  bool is_weak;  ///< lines of numbers: other signs count before these
  Reader read;
};

/// In the order of ProbeFormat.
constexpr std::array<FormatRow, 11> kFormats = {
    {{ProbeFormat::HeightMapCsv,
      "heightmap",
      "",
      "RepRapFirmware's heightmap.csv",
      "the machine's zero",
      kTakesUnit,
      internal::is_height_map_csv,
      false,
      internal::parse_height_map_csv},
     {ProbeFormat::LinuxCncLog,
      "linuxcnc",
      "",
      "LinuxCNC's log of PROBEOPEN",
      "the work zero of the program that probed",
      kTakesUnit,
      internal::is_linuxcnc_log,
      true,
      internal::parse_linuxcnc_log},
     {ProbeFormat::BcncProbe,
      "bcnc",
      ".probe",
      "bCNC's .probe",
      "the work zero of bCNC",
      kTakesUnit,
      internal::is_bcnc_probe,
      false,
      internal::parse_bcnc_probe},
     {ProbeFormat::OpenCncPilotMap,
      "opencncpilot",
      ".hmap",
      "OpenCNCPilot's .hmap",
      "the work zero of OpenCNCPilot",
      kTakesUnit,
      internal::is_opencncpilot_map,
      false,
      internal::parse_opencncpilot_map},
     {ProbeFormat::RecordedProbes,
      "probes",
      ".jsonl",
      "panelcal's readings (.jsonl)",
      "the work zero of the program, heights from the table plane",
      kTakesNone,
      internal::is_recorded_probes,
      false,
      internal::parse_recorded_probes},
     {ProbeFormat::KlipperConfig,
      "klipper",
      "",
      "Klipper's printer.cfg with a saved [bed_mesh NAME]",
      "",
      kTakesProfile,
      internal::is_klipper_config,
      false,
      internal::parse_klipper_config},
     {ProbeFormat::MoonrakerJson,
      "moonraker",
      "",
      "Moonraker's bed_mesh (JSON)",
      "",
      kTakesProfile,
      internal::is_moonraker_json,
      false,
      internal::parse_moonraker_json},
     {ProbeFormat::MarlinConsole,
      "marlin",
      "",
      "Marlin's console of G29 T0, G29 V4 or M420 V",
      "the printer's zero",
      kTakesMesh,
      internal::is_marlin_console,
      false,
      internal::parse_marlin_console},
     {ProbeFormat::GrblConsole,
      "grbl",
      "",
      "GRBL's console with [PRB:x,y,z:1]",
      "",
      kTakesUnit,
      internal::is_grbl_console,
      false,
      internal::parse_grbl_console},
     {ProbeFormat::CandleMap,
      "candle",
      ".map",
      "Candle's .map",
      "the work zero of Candle, heights from its first probe",
      kTakesNone,
      internal::is_candle_map,
      false,
      internal::parse_candle_map},
     {ProbeFormat::PlainCsv,
      "csv",
      ".csv",
      "a table of x, y and z",
      "the file's own zero, which it does not state",
      kTakesUnit,
      internal::is_plain_csv,
      true,
      internal::parse_plain_csv}}};

const FormatRow& row_of(ProbeFormat format) {
  return kFormats[static_cast<std::size_t>(format)];
}

std::string lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

/// The format whose signs the text has. The name decides on a text without any, and on lines of
/// numbers that are not yet, or no longer, what it says.
Expected<ProbeFormat> format_of(std::string_view text, const std::string& file) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  const std::string extension = lower(std::filesystem::path(file).extension().string());
  std::vector<std::string_view> strong, all;
  std::optional<ProbeFormat> found, weak, named;
  for (const FormatRow& row : kFormats) {
    all.push_back(row.what);
    if (!row.extension.empty() && row.extension == extension) named = row.format;
    if (!row.is_it(text.substr(begin))) continue;
    (row.is_weak ? weak : found) = row.format;
    if (!row.is_weak) strong.push_back(row.name);
  }
  if (strong.size() > 1) {
    return failure({Code::MeasurementFile,
                    {file, 0, 0},
                    fmt::format("signs of {}", fmt::join(strong, " and ")),
                    "one kind of probes a file, or --format to say which"});
  }
  if (found) return *found;
  if (weak && (!named || *named == ProbeFormat::PlainCsv)) return *weak;
  if (named) return *named;
  const auto lines = internal::first_lines(text, 1);
  return failure({Code::MeasurementFile,
                  {file, lines.empty() ? 1 : lines[0].line, 1},
                  lines.empty() ? std::string("nothing") : quoted(lines[0].text),
                  fmt::format("one of: {}", fmt::join(all, "; "))});
}

/// An option that the file's format has no use for.
Expected<void> check_use(const FormatRow& row,
                         const std::string& file,
                         const ProbeFileOptions& options) {
  const auto refused = [&](std::string_view option, std::string_view of) {
    return failure({Code::MeasurementFile,
                    {file, 0, 0},
                    fmt::format("{} for a file of format {}", option, row.name),
                    std::string(of)});
  };
  const bool is_mm = !options.unit || *options.unit == mm(1);
  if (!is_mm && (row.takes & kTakesUnit) == 0)
    return refused("--unit inch", "mm, as such files are");
  if (!options.profile.empty() && (row.takes & kTakesProfile) == 0) {
    return refused("--profile", "a file of Klipper or Moonraker");
  }
  if (options.mesh && (row.takes & kTakesMesh) == 0)
    return refused("--mesh-mm", "a mesh of Marlin");
  return {};
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
  if (!(unit_mm() >= 0.001 && unit_mm() <= 1000)) {
    return bad("unit_mm", unit_mm(), "0.001 to 1000 mm");
  }
  if (z_axis && *z_axis < 0) return bad("zaxis", *z_axis, "0 or more");
  return {};
}

Expected<ProbeFile> parse_probe_file(std::string_view text,
                                     const std::string& file,
                                     const ProbeFileOptions& options) {
  PANELCAL_CHECK(options.validate());
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  if (text.starts_with(kUtf8Mark)) text.remove_prefix(kUtf8Mark.size());
  std::optional<ProbeFormat> format = options.format;
  if (!format) {
    PANELCAL_TRY(format, format_of(text, file));
  }
  const FormatRow& row = row_of(*format);
  PANELCAL_CHECK(check_use(row, file, options));
  PANELCAL_TRY(ProbeFile out, row.read(text, file, options));
  if (out.points.empty()) {
    return failure({Code::MeasurementFile, {file, 0, 0}, "no height at all", "probed heights"});
  }
  if (out.zero.empty()) out.zero = row.zero;
  if (out.unit.empty()) {
    out.unit = (row.takes & kTakesUnit) == 0 ? "mm"
               : !options.unit               ? "mm, as none is stated"
               : *options.unit == inch(1)    ? "inch, by --unit"
                                             : fmt::format("{:g} mm, by --unit", options.unit_mm());
  }
  const bool is_assumed = !options.sigma && !out.states_sigma;
  for (ProbePoint& point : out.points) point.is_sigma_assumed = is_assumed;
  return out;
}

Expected<ProbeFile> read_probe_file(const std::filesystem::path& path,
                                    const ProbeFileOptions& options) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxProbeFileBytes));
  return parse_probe_file(text, path.string(), options);
}

}  // namespace panelcal
