// SPDX-License-Identifier: Apache-2.0
// Orders to the camera: G34 and the $uvis commands.
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "program/excellon/vision/vision.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

std::vector<std::string_view> split_at_commas(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto comma = text.find(',');
    parts.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

}  // namespace

void VisionSession::bad_argument(int line,
                                 int column,
                                 std::string_view text,
                                 std::string expected) {
  reporter_.report(Code::ArgumentInvalid, line, column, quoted(text), std::move(expected));
}

void VisionSession::select_tool(const Block& block, const NumberFormat& format) {
  const std::vector<std::string_view> parts = split_at_commas(block.argument);
  const std::size_t n = parts.size();
  const bool has_delta = n == 2 || n == 5;
  if (block.argument_column == 0 || (n != 1 && !has_delta)) {
    return bad_argument(
        block.line, block.column, block.text, "G34,v1 or G34,v1,delta or G34,v1,v2,v3,v4,delta");
  }
  const auto column_of = [&](std::string_view part) {
    return block.argument_column + static_cast<int>(part.data() - block.argument.data());
  };
  VisionSettings chosen = settings_;
  chosen.tools.clear();
  chosen.delta.reset();
  for (std::size_t i = 0; i < n - (has_delta ? 1 : 0); ++i) {
    const auto tool = parse_count(parts[i]);
    if (!tool || *tool < 1) {
      return bad_argument(block.line, column_of(parts[i]), parts[i], "a vision tool from 1");
    }
    chosen.tools.push_back(*tool);
  }
  if (has_delta) {
    const ParsedLength delta = parse_length(parts.back(), format);
    if (delta.fault != NumberFault::None || !(delta.value > Length())) {
      return bad_argument(block.line,
                          column_of(parts.back()),
                          parts.back(),
                          "the distance of the four views, above zero");
    }
    chosen.delta = delta.value;
  }
  settings_ = std::move(chosen);
}

template <class Number>
bool VisionSession::read_number(std::string_view text,
                                Number least,
                                const SourceLine& line,
                                std::optional<Number>& out) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !(value >= least) ||
      !std::isfinite(static_cast<double>(value))) {
    bad_argument(line.number,
                 static_cast<int>(text.data() - line.text.data()) + 1,
                 text,
                 fmt::format("a number from {}", least));
    return false;
  }
  out = value;
  return true;
}

void VisionSession::keyboard_order(const SourceLine& line,
                                   const NumberFormat& format,
                                   const TargetPlace& place) {
  const auto begin = line.text.find('$');
  const std::string_view text =
      line.text.substr(begin, line.text.find_last_not_of(" \t") + 1 - begin);
  const int column = static_cast<int>(begin) + 1;
  constexpr std::string_view kPrefix = "$uvis,";
  if (!text.starts_with(kPrefix)) {
    reporter_.report(Code::CommandUnknown, line.number, column, quoted(text), "$uvis,...");
    return;
  }
  const std::string_view rest = text.substr(kPrefix.size());
  const auto comma = rest.find(',');
  const std::string_view key = rest.substr(0, comma);
  const std::string_view value =
      comma == std::string_view::npos ? rest.substr(rest.size()) : rest.substr(comma + 1);
  if (set_uvis(key, value, line, format)) return;
  if (key == "focus") return focus(value, line, format, place.work_zero);
  if (key != "calib") return refuse_unknown(key, line);
  if (!value.empty()) {
    const int value_column = static_cast<int>(value.data() - line.text.data()) + 1;
    return bad_argument(line.number, value_column, value, "$uvis,calib alone");
  }
  CalibrationOrder order;
  order.line = line.number;
  order.file = place.file;
  order.file_sha256 = place.file_sha256;
  order.command = "$uvis,calib";
  order.path = place.path;
  calibrate(std::move(order), column, line.text);
}

void VisionSession::calibrate(CalibrationOrder order, int column, std::string_view text) {
  if (!measuring_.is_first_pass()) return;
  if (!options_.has_coupon || options_.structure == Structure::Kept) {
    return measuring_.report_not_calibrated(order.line, column, text);
  }
  if (refuse_unfinished(order.line, order.command)) return measuring_.stop();
  order.lamp = settings_.lamp;
  order.zoom = settings_.zoom;
  measuring_.calibrate(std::move(order), column, text);
}

bool VisionSession::set_uvis(std::string_view key,
                             std::string_view value,
                             const SourceLine& line,
                             const NumberFormat& format) {
  const int value_column = static_cast<int>(value.data() - line.text.data()) + 1;
  const auto is_switch = [&] {
    if (value == "on" || value == "off") return true;
    bad_argument(line.number, value_column, value, "on or off");
    return false;
  };
  if (key == "search") {
    if (is_switch()) settings_.search = value == "on";
  } else if (key == "auto" || key == "box" || key == "entry") {
    is_switch();
  } else if (key == "searcharea") {
    // A plain number, unlike coordinates: a keyboard order has no leading or trailing zeros to
    // keep.
    std::optional<double> radius;
    if (read_number(value, 0.0, line, radius)) settings_.search_area = *radius * format.one_unit();
  } else if (key == "lamp") {
    read_number(value, 0.0, line, settings_.lamp);
  } else if (key == "zoom") {
    read_number(value, 0.0, line, settings_.zoom);
  } else if (key == "insp") {
    std::optional<int> n;
    if (read_number(value, 1, line, n)) settings_.inspections = *n;
  } else if (key == "alg") {
    const auto comma = value.find(',');
    std::optional<int> algorithm;
    std::optional<int> n;
    if (comma == std::string_view::npos) {
      bad_argument(line.number, value_column, value, "$uvis,alg,algorithm,fiducials");
    } else if (read_number(value.substr(0, comma), 0, line, algorithm) &&
               read_number(value.substr(comma + 1), 1, line, n)) {
      settings_.algorithm = algorithm;
      series_size_ = *n;
    }
  } else {
    return false;
  }
  return true;
}

/// The place is one of the panel, relative to work zero; corrections and copies do not move it.
void VisionSession::focus(std::string_view value,
                          const SourceLine& line,
                          const NumberFormat& format,
                          const Position<frame::Machine>& work_zero) {
  // `xy`, `x1.5y2`: lower case, otherwise a coordinate like any other.
  const auto y_at = value.find('y');
  const bool has_letters = value.starts_with('x') && y_at != std::string_view::npos;
  const ParsedLength x = has_letters ? parse_length(value.substr(1, y_at - 1), format)
                                     : ParsedLength{{}, NumberFault::Malformed};
  const ParsedLength y = has_letters ? parse_length(value.substr(y_at + 1), format) : x;
  if (x.fault != NumberFault::None || y.fault != NumberFault::None) {
    const int value_column = static_cast<int>(value.data() - line.text.data()) + 1;
    return bad_argument(line.number, value_column, value, "$uvis,focus,x#y#");
  }
  if (!measuring_.is_first_pass()) return;
  if (!options_.has_focus) {
    const int column = static_cast<int>(line.text.find('$')) + 1;
    return measuring_.report_not_calibrated(line.number, column, line.text);
  }
  MeasurementRequest request;
  request.seq = -1;
  request.line = line.number;
  request.command = "$uvis,focus";
  request.settings = settings_;
  request.nominal = position_mm<frame::Nominal>(x.value.in_mm(), y.value.in_mm());
  request.expected = position_mm<frame::Actual>(x.value.in_mm(), y.value.in_mm());
  request.work_zero = work_zero;
  measuring_.focus(request);
}

void VisionSession::refuse_unknown(std::string_view key, const SourceLine& line) {
  constexpr std::array<std::string_view, 11> kKeys = {"auto",
                                                      "box",
                                                      "search",
                                                      "searcharea",
                                                      "entry",
                                                      "insp",
                                                      "focus",
                                                      "lamp",
                                                      "zoom",
                                                      "calib",
                                                      "alg"};
  const std::string_view near = nearest_word(key, kKeys);
  reporter_.report(Code::CommandUnknown,
                   line.number,
                   static_cast<int>(key.data() - line.text.data()) + 1,
                   quoted(key) + " behind $uvis",
                   near.empty() ? "auto, box, search, searcharea, entry, insp, focus, lamp, zoom, "
                                  "calib or alg"
                                : "did you mean " + quoted(near) + "?");
}

}  // namespace panelcal::excellon
