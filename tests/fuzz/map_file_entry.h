// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "surface/map/file.h"

namespace panelcal::fuzz {

/// Of larger maps the fuzzer would make one in a second; that they are bounded a test says.
inline constexpr std::size_t kMostFuzzedMap = 6000;

/// Complaint about a refusal: it must be of the right kind and in one printable line.
inline std::optional<std::string> map_refusal_complaint(const Diagnostic& diagnostic) {
  constexpr std::array<Code, 5> kCodes = {Code::MeasurementFile,
                                          Code::JsonSyntax,
                                          Code::GridInvalid,
                                          Code::ConfigValue,
                                          Code::SurfaceOutOfTolerance};
  if (std::ranges::find(kCodes, diagnostic.code) == kCodes.end()) {
    return "refused as something else: " + diagnostic.text();
  }
  if (diagnostic.what.empty()) return "refused without a reason";
  if (diagnostic.place.file != "fuzz") return "refused elsewhere: " + diagnostic.text();
  const bool is_printable =
      std::ranges::all_of(diagnostic.text(), [](char c) { return c >= ' ' && c <= '~'; });
  if (!is_printable) return "refused in unprintable words";
  return std::nullopt;
}

/// Complaint about a map that was read; empty if all is well.
inline std::optional<std::string> map_file_complaint(const StoredZones& read) {
  const std::string text = map_file_text(read);
  const auto again = parse_zoned_map_file(text, "fuzz");
  if (!again) return "cannot be read again: " + again.error().text();
  if (map_file_text(*again) != text) return "reads back as something else";
  for (const ProbePoint& probe : read.points) {
    const auto was = read.map.height_at(probe.place), is = again->map.height_at(probe.place);
    if (was.has_value() != is.has_value()) return "refuses another place";
    if (!was) continue;
    if (!std::isfinite(was->height.height.in_mm()) || !(was->height.sigma >= mm(0))) {
      return "a height that is not finite";
    }
    if (was->height.height != is->height.height || was->height.sigma != is->height.sigma ||
        was->in_void != is->in_void) {
      return "another height at " + name_of(probe);
    }
  }
  return std::nullopt;
}

inline std::optional<std::string> run_map_file(std::string_view bytes) {
  if (bytes.size() > kMostFuzzedMap) return std::nullopt;
  const auto read = parse_zoned_map_file(bytes, "fuzz");
  return read ? map_file_complaint(*read) : map_refusal_complaint(read.error());
}

}  // namespace panelcal::fuzz
