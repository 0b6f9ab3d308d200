// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/writers/excellon_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// 2.5 nm in inches, to match the nanometre in millimetres.
constexpr int kInchDecimals = 7;

/// The writer states the format itself, and switches to drilling itself.
bool is_written_anyway(std::string_view text) {
  constexpr std::array<std::string_view, 2> kOwn = {"G05", "FMAT,2"};
  return std::ranges::find(kOwn, text) != kOwn.end();
}

}  // namespace

ExcellonWriter::ExcellonWriter(ByteSink& bytes, std::vector<std::string> comments)
    : TextWriter(bytes), comments_(std::move(comments)) {
}

void ExcellonWriter::begin(const ProgramInfo& info) {
  info_ = info;
  text() += "M48\n";
  for (const std::string& comment : comments_) {
    text() += ';';
    // A line end or control byte inside a comment would become a command.
    std::ranges::replace_copy_if(
        comment, std::back_inserter(text()), [](char c) { return c < ' ' || c > '~'; }, '?');
    text() += '\n';
  }
  text() += "FMAT,2\n";
  text() += info.format.unit == LengthUnit::Inch ? "INCH," : "METRIC,";
  text() += info.format.zeros == Zeros::LeadingKept ? "LZ\n" : "TZ\n";
}

/// Header settings come first; whatever else comes ends the header.
void ExcellonWriter::put(const Operation& operation) {
  const Setting* setting = std::get_if<Setting>(&operation.what);
  const bool is_header_setting = setting != nullptr && setting->kind == SettingKind::Header;
  if (in_header_ && !is_header_setting) close_header();
  std::visit([this](const auto& what) { write(what); }, operation.what);
  flush_if_large();
}

void ExcellonWriter::close_header() {
  in_header_ = false;
  for (const auto& [number, tool] : info_.tools) put_tool(tool, true);
  text() += "%\nG90\nG05\n";
}

void ExcellonWriter::put_tool(const Tool& tool,
                              bool with_data,
                              std::optional<int> compensation_index) {
  fmt::format_to(std::back_inserter(text()), "T{}", tool.number);
  if (compensation_index) fmt::format_to(std::back_inserter(text()), "{:02}", *compensation_index);
  if (with_data) {
    if (tool.diameter) {
      text() += 'C';
      append_length(*tool.diameter);
    }
    if (tool.infeed) append_rate('F', *tool.infeed, 3);
    if (tool.speed) append_speed(*tool.speed);
    if (tool.retract) append_rate('B', *tool.retract, 4);
    if (tool.max_hits) fmt::format_to(std::back_inserter(text()), "H{}", *tool.max_hits);
    if (tool.depth_offset) {
      text() += 'Z';
      append_length(*tool.depth_offset);
    }
  }
  text() += '\n';
}

/// Whole rates with leading zeros, as the manual wants them.
void ExcellonWriter::append_rate(char letter, Feed rate, int n_digits) {
  const double value =
      info_.format.unit == LengthUnit::Inch ? rate / inch_per_min(1) : rate.in_mm_s();
  fmt::format_to(std::back_inserter(text()), "{}{:0{}}", letter, std::lround(value), n_digits);
}

void ExcellonWriter::append_speed(SpindleSpeed speed) {
  text() += 'S';
  const double thousands = speed.in_rpm() / 1000;
  const std::size_t begin = text().size();
  append_fixed(text(), thousands, 6);
  // The decimal point keeps the number from being read by counting digits.
  if (text().find('.', begin) == std::string::npos) text() += '.';
}

/// A decimal point in every length: it overrides whatever zeros the reader assumes.
void ExcellonWriter::append_length(Length length) {
  const bool is_inch = info_.format.unit == LengthUnit::Inch;
  const std::size_t begin = text().size();
  append_fixed(text(), length / (is_inch ? inch(1) : mm(1)), is_inch ? kInchDecimals : kMmDecimals);
  if (text().find('.', begin) == std::string::npos) text() += ".0";
}

void ExcellonWriter::append_point(const Eigen::Vector2d& p_mm) {
  text() += 'X';
  append_length(mm(p_mm.x()));
  text() += 'Y';
  append_length(mm(p_mm.y()));
}

/// A tool's data are repeated where the header does not say the same: the body had them.
void ExcellonWriter::write(const ToolChange& change) {
  const auto defined = info_.tools.find(change.tool.number);
  const bool says_more = defined == info_.tools.end() || defined->second != change.tool;
  put_tool(change.tool, says_more, change.compensation_index);
}

void ExcellonWriter::write(const Drill& drill) {
  append_point(drill.corrected.in_mm());
  text() += '\n';
}

void ExcellonWriter::write(const Stop& stop) {
  text() += stop.kind == StopKind::EndRewind ? "M30" : "M00";
  if (stop.from_absolute_zero) append_point(stop.from_absolute_zero->in_mm());
  text() += '\n';
}

void ExcellonWriter::write(const Message& message) {
  text() += "M47,";
  text() += message.text;
  text() += '\n';
}

void ExcellonWriter::write(const Setting& setting) {
  if (setting.kind == SettingKind::Vision || is_written_anyway(setting.text)) return;
  text() += setting.text;
  text() += '\n';
}

void ExcellonWriter::write(const ZeroSet& zero) {
  text() += "G93";
  append_point(zero.zero_set.in_mm());
  text() += '\n';
}

}  // namespace panelcal
