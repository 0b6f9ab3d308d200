// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "surface/files/text_fields.h"

// Not installed: part of surface/files/probe_file.h.
namespace panelcal::internal {

bool are_numbers(std::span<const TextField> words);

// By these a text shows whose file it is; each takes a text without the blanks ahead of it. Whether
// it is whole is the reader's question.

bool is_height_map_csv(std::string_view text);
bool is_linuxcnc_log(std::string_view text);
/// As a log of three numbers a line, but for its head, which says how many lines it has.
bool is_bcnc_probe(std::string_view text);
bool is_opencncpilot_map(std::string_view text);
bool is_recorded_probes(std::string_view text);
bool is_klipper_config(std::string_view text);
bool is_moonraker_json(std::string_view text);
bool is_marlin_console(std::string_view text);
bool is_grbl_console(std::string_view text);
bool is_candle_map(std::string_view text);
/// Lines of as many cells as the first one, of which all but the first are numbers or empty.
bool is_plain_csv(std::string_view text);

}  // namespace panelcal::internal
