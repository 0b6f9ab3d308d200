// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/files/byte_sink.h"
#include "machine/config/machine_config.h"
#include "program/judge/depth_errors.h"
#include "program/walk/survey.h"
#include "program/writers/svg/targets.h"
#include "program/writers/text_writer.h"

namespace panelcal {

/// The format of a corrected program.
enum class OutputFormat : std::uint8_t { Jsonl, Csv, Excellon, SiebMeyer, Gcode, Svg };

/// "jsonl", "csv", "excellon", "sieb-meyer", "gcode", "svg".
std::string_view name(OutputFormat format);
std::optional<OutputFormat> output_format_from_name(std::string_view name);
/// By a file's extension in small letters, with its point: .jsonl, .csv, .drl, .exc, .s5, .sm,
/// .ngc, .svg.
std::optional<OutputFormat> output_format_of_extension(std::string_view extension);

/// A language that a drilling machine's control reads by itself: cycles may be left to it.
bool is_program(OutputFormat format);

/// The output says where it comes from (WriterInput::comments); records have no place for that.
bool has_comments(OutputFormat format);

/// The flavour of G-code that the machine reads: [gcode] flavour, or by [machine] driver, or
/// LinuxCNC's. Without [gcode] none is written.
GcodeFlavour gcode_flavour(const MachineConfig& machine);

/// Checks that the machine's file states all that the format needs.
///
/// Fails  config-value (G-code without [gcode]; length_offset for a control that knows no G43; no
///        rapid_mm_s where the control needs it)
Expected<void> check_output_format(OutputFormat format, const MachineConfig& machine);

/// The input of a writer besides the operations.
struct WriterInput {
  std::string title;                  ///< of a picture
  std::vector<std::string> comments;  ///< origin of the output, one line each
  std::optional<DepthJudge>
      depths;                      ///< for columns about depths; empty if nothing is asked of them
  const Survey* survey = nullptr;  ///< the survey whose targets a picture shows
  std::optional<Length> resolution = std::nullopt;  ///< of coordinates in a program
};

/// Precondition: check_output_format(); a picture has a survey; `bytes` outlives the writer
std::unique_ptr<TextWriter> make_writer(OutputFormat format,
                                        ByteSink& bytes,
                                        const MachineConfig& machine,
                                        WriterInput input);

/// Every target where it was found, labelled by its number, with the residual of its fit.
std::vector<SvgTarget> picture_targets(const Survey& survey);

}  // namespace panelcal
