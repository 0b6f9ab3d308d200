// SPDX-License-Identifier: Apache-2.0
#include "machine/job/output/output_format.h"

#include <algorithm>
#include <array>
#include <utility>

#include "program/writers/csv_writer.h"
#include "program/writers/excellon/writer.h"
#include "program/writers/gcode/writer.h"
#include "program/writers/jsonl_writer.h"
#include "program/writers/sieb_meyer/writer.h"
#include "program/writers/svg/writer.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr auto kFormatNames = std::to_array<std::pair<OutputFormat, std::string_view>>(
    {{OutputFormat::Jsonl, "jsonl"},
     {OutputFormat::Csv, "csv"},
     {OutputFormat::Excellon, "excellon"},
     {OutputFormat::SiebMeyer, "sieb-meyer"},
     {OutputFormat::Gcode, "gcode"},
     {OutputFormat::Svg, "svg"}});

constexpr auto kExtensions =
    std::to_array<std::pair<std::string_view, OutputFormat>>({{".jsonl", OutputFormat::Jsonl},
                                                              {".csv", OutputFormat::Csv},
                                                              {".drl", OutputFormat::Excellon},
                                                              {".exc", OutputFormat::Excellon},
                                                              {".s5", OutputFormat::SiebMeyer},
                                                              {".sm", OutputFormat::SiebMeyer},
                                                              {".ngc", OutputFormat::Gcode},
                                                              {".svg", OutputFormat::Svg}});

std::unique_ptr<TextWriter> make_program_writer(OutputFormat format,
                                                ByteSink& bytes,
                                                const MachineConfig& machine,
                                                WriterInput input) {
  const ProgramWriterOptions writing{.comments = std::move(input.comments),
                                     .allow_losses = true,  // all of them are to be named
                                     .resolution = input.resolution,
                                     .absolute_zero = machine.walk.absolute_zero,
                                     .work_zero = machine.walk.work_zero};
  if (format == OutputFormat::SiebMeyer) return std::make_unique<SiebMeyerWriter>(bytes, writing);
  if (format == OutputFormat::Gcode) {
    GcodeSetting setting = *machine.gcode;
    setting.flavour = gcode_flavour(machine);
    return std::make_unique<GcodeWriter>(bytes, writing, std::move(setting));
  }
  return std::make_unique<ExcellonWriter>(bytes, writing);
}

}  // namespace

std::string_view name(OutputFormat format) {
  return std::ranges::find(kFormatNames, format, &decltype(kFormatNames)::value_type::first)
      ->second;
}

std::optional<OutputFormat> output_format_from_name(std::string_view name) {
  const auto found =
      std::ranges::find(kFormatNames, name, &decltype(kFormatNames)::value_type::second);
  return found == kFormatNames.end() ? std::nullopt : std::optional(found->first);
}

std::optional<OutputFormat> output_format_of_extension(std::string_view extension) {
  const auto found =
      std::ranges::find(kExtensions, extension, &decltype(kExtensions)::value_type::first);
  return found == kExtensions.end() ? std::nullopt : std::optional(found->second);
}

bool is_program(OutputFormat format) {
  return format == OutputFormat::Excellon || format == OutputFormat::SiebMeyer;
}

bool has_comments(OutputFormat format) {
  return format != OutputFormat::Jsonl && format != OutputFormat::Csv;
}

GcodeFlavour gcode_flavour(const MachineConfig& machine) {
  if (machine.gcode && machine.gcode->flavour) return *machine.gcode->flavour;
  return machine.control.driver == ControlKind::Grbl ? GcodeFlavour::Grbl : GcodeFlavour::LinuxCnc;
}

Expected<void> check_output_format(OutputFormat format, const MachineConfig& machine) {
  if (format != OutputFormat::Gcode) return {};
  const auto problem = [&](std::string what, std::string expected) {
    return failure(
        {Code::ConfigValue, {machine.file.string(), 0, 0}, std::move(what), std::move(expected)});
  };
  if (!machine.gcode) {
    return problem("[gcode] is missing, which states how high and how deep tools go in G-code",
                   "[gcode] with safe_z_mm, drill_z_mm and others (docs/formats/gcode.md)");
  }
  const GcodeFlavour flavour = gcode_flavour(machine);
  const GcodeWording wording = wording_of(flavour);
  if (machine.gcode->has_length_offset && !wording.has_length_offset) {
    return problem(
        fmt::format("length_offset of [gcode] asks for G43, which flavour {} lacks", name(flavour)),
        "length_offset = false: the operator sets Z at each change of tool");
  }
  if (wording.rapids_need_a_feed && !machine.gcode->rapid) {
    return problem(fmt::format("[gcode] states no rapid_mm_s, and G0 of flavour {} goes with the "
                               "feed that was said last",
                               name(flavour)),
                   "rapid_mm_s, the feed of moves above the board");
  }
  return {};
}

std::unique_ptr<TextWriter> make_writer(OutputFormat format,
                                        ByteSink& bytes,
                                        const MachineConfig& machine,
                                        WriterInput input) {
  if (format == OutputFormat::Jsonl) {
    return std::make_unique<JsonlWriter>(bytes, std::move(input.depths));
  }
  if (format == OutputFormat::Csv) {
    return std::make_unique<CsvWriter>(bytes, std::move(input.depths));
  }
  if (format == OutputFormat::Svg) {
    return std::make_unique<SvgWriter>(bytes,
                                       SvgScene{.targets = picture_targets(*input.survey),
                                                .title = std::move(input.title),
                                                .provenance = std::move(input.comments)});
  }
  return make_program_writer(format, bytes, machine, std::move(input));
}

std::vector<SvgTarget> picture_targets(const Survey& survey) {
  std::vector<SvgTarget> targets;
  for (const Measurement& measurement : survey.measurements) {
    const bool is_found = measurement.status == MeasurementStatus::Found;
    targets.push_back({is_found ? measurement.measured.position : measurement.request.expected,
                       std::to_string(measurement.request.seq),
                       std::nullopt});
  }
  for (const SeriesResult& series : survey.series) {
    for (std::size_t i = 0; i < series.points.size() && series.is_fitted(); ++i) {
      targets[series.points[i]].residual = displacement_mm<frame::Actual>(series.residuals_mm[i]);
    }
  }
  return targets;
}

}  // namespace panelcal
