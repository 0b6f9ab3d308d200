// SPDX-License-Identifier: Apache-2.0
#include "surface/files/probe_signs.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <optional>
#include <vector>

#include "surface/files/probe_format.h"
#include "surface/files/text_fields.h"

namespace panelcal::internal {
namespace {

constexpr std::size_t kBcncHead = 3;

std::optional<std::size_t> node_count(const std::vector<TextField>& words) {
  if (words.size() != 3) return std::nullopt;
  std::size_t n = 0;
  const char* const end = words[2].text.data() + words[2].text.size();
  const auto [stop, error] = std::from_chars(words[2].text.data(), end, n);
  const bool is_count = error == std::errc() && stop == end && n >= 2 && n <= kMaxFileProbes;
  return is_count ? std::optional(n) : std::nullopt;
}

}  // namespace

bool are_numbers(std::span<const TextField> words) {
  return std::ranges::all_of(words, [](const TextField& word) { return is_number(word.text); });
}

bool is_height_map_csv(std::string_view text) {
  return text.starts_with("RepRapFirmware height map");
}

bool is_linuxcnc_log(std::string_view text) {
  const auto lines = first_lines(text, 1);
  if (lines.empty()) return false;
  const auto words = words_of(lines[0]);
  return words.size() >= 3 && are_numbers(words) && !is_bcnc_probe(text);
}

bool is_bcnc_probe(std::string_view text) {
  std::vector<std::vector<TextField>> head;
  for (const TextField& line : first_lines(text, kBcncHead)) {
    head.push_back(words_of(line));
    if (head.back().size() != 3 || !are_numbers(head.back())) return false;
  }
  if (head.size() < kBcncHead) return false;
  const auto n_columns = node_count(head[0]), n_rows = node_count(head[1]);
  if (!n_columns || !n_rows || *n_columns > kMaxFileProbes / *n_rows) return false;
  const std::size_t n_lines = kBcncHead + *n_columns * *n_rows;
  return first_lines(text, n_lines + 1).size() == n_lines;
}

bool is_opencncpilot_map(std::string_view text) {
  return text.starts_with('<') && text.find("<heightmap") != std::string_view::npos;
}

bool is_recorded_probes(std::string_view text) {
  const auto lines = first_lines(text, 1);
  return text.starts_with('{') && !lines.empty() &&
         lines[0].text.find("\"probe\"") != std::string_view::npos;
}

bool is_grbl_console(std::string_view text) {
  return text.find("[PRB:") != std::string_view::npos;
}

}  // namespace panelcal::internal
