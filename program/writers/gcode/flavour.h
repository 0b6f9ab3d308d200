// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace panelcal {

/// The control that reads a G-code program.
enum class GcodeFlavour : std::uint8_t { LinuxCnc, Grbl, Marlin };

constexpr std::string_view name(GcodeFlavour flavour) {
  switch (flavour) {
    case GcodeFlavour::LinuxCnc:
      return "linuxcnc";
    case GcodeFlavour::Grbl:
      return "grbl";
    case GcodeFlavour::Marlin:
      return "marlin";
  }
  return {};
}

constexpr std::optional<GcodeFlavour> gcode_flavour_from_name(std::string_view word) {
  for (const auto flavour : {GcodeFlavour::LinuxCnc, GcodeFlavour::Grbl, GcodeFlavour::Marlin}) {
    if (word == name(flavour)) return flavour;
  }
  return std::nullopt;
}

/// The words of one flavour, where flavours differ.
///
/// Source LinuxCNC G-code reference; GRBL 1.1, "Supported G-codes" and "Interface"; Marlin G-code
///        index (M0, M3, M117, G0, G4)
struct GcodeWording {
  /// Modes at the beginning, in as many lines as the control needs.
  std::string_view head;
  bool has_cycles = false;         ///< G81, G83, G73
  bool changes_tools = false;      ///< T and M6
  bool has_length_offset = false;  ///< G43
  /// One word of G or M in a line, behind which its parameters stand.
  bool is_one_command_a_line = false;
  bool rapids_need_a_feed = false;  ///< G0 goes with the F that was said last
  std::string_view dwell;           ///< before the seconds
  std::string_view message;         ///< before the words of a message
  std::string_view message_end;
  std::string_view optional_stop;
  std::string_view end;            ///< empty: a program ends with its last line
  std::size_t max_characters = 0;  ///< of a line, without its end
  std::size_t max_text = 0;        ///< of the words of a comment or a message in a line
  /// Characters that the control takes for itself, wherever they stand in a line.
  std::string_view reserved;
};

/// GRBL ends a line at 80 characters. It takes ! ? ~ out of comments as well: they hold, ask, and
/// go on behind M0. It knows no optional stop: M1 would not stop.
constexpr GcodeWording wording_of(GcodeFlavour flavour) {
  switch (flavour) {
    case GcodeFlavour::LinuxCnc:
      return {.head = "G17 G21 G40 G54 G61 G80 G90 G91.1 G94 G98",
              .has_cycles = true,
              .changes_tools = true,
              .has_length_offset = true,
              .dwell = "G4 P",
              .message = "(MSG, ",
              .message_end = ")",
              .optional_stop = "M1",
              .end = "M2",
              .max_characters = 252,
              .max_text = 200};
    case GcodeFlavour::Grbl:
      return {.head = "G17 G21 G40 G54 G61 G80 G90 G91.1 G94",
              .dwell = "G4 P",
              .message = "(MSG, ",
              .message_end = ")",
              .optional_stop = "M0",
              .end = "M2",
              .max_characters = 79,
              .max_text = 70,
              .reserved = "!?~"};
    case GcodeFlavour::Marlin:
      return {.head = "G21\nG90",
              .is_one_command_a_line = true,
              .rapids_need_a_feed = true,
              .dwell = "G4 S",
              .message = "M117 ",
              .optional_stop = "M1",
              .max_characters = 95,
              .max_text = 80,
              .reserved = ";*"};
  }
  return {};
}

}  // namespace panelcal
