// SPDX-License-Identifier: Apache-2.0
#include "program/writers/excellon/writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/base/append_format.h"
#include "program/model/placement.h"
#include "program/model/setting_lengths.h"
#include "program/writers/rounded_arc.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Source CNC-7 manual, Inch vs. Metric: 00.0000 and 000.000
constexpr int kUsualInchDecimals = 4;
constexpr int kUsualMetricDecimals = 3;
constexpr int kUsualInchWhole = 2;
constexpr int kUsualMetricWhole = 3;
constexpr int kUsualDigits = 6;

/// The writer states format and modes itself, and has resolved what the others did.
bool is_written_anyway(std::string_view text) {
  constexpr std::array<std::string_view, 11> kOwn = {
      "FMAT", "METRIC", "INCH", "M71", "M72", "G05", "G90", "G91", "ICI", "OM48", "BLKD"};
  return std::ranges::find(kOwn, text.substr(0, text.find_first_of(", \t"))) != kOwn.end();
}

/// A decimal point in every length: it overrides whatever zeros the reader assumes.
constexpr std::string_view kPoint = ".0";

char* write_digits_with_point(char* at, double value, int n_decimals) {
  char* const end = write_fixed(at, value, n_decimals);
  return std::find(at, end, '.') != end ? end : std::ranges::copy(kPoint, end).out;
}

}  // namespace

ExcellonWriter::ExcellonWriter(ByteSink& bytes, ProgramWriterOptions options)
    : ProgramWriter(bytes, Dialect::Excellon, std::move(options)) {
}

// --- header ------------------------------------------------------------------------------------

void ExcellonWriter::begin(const ProgramInfo& info) {
  ProgramWriter::begin(info);
  const bool is_inch = info.format.unit == LengthUnit::Inch;
  const int n_usual = is_inch ? kUsualInchDecimals : kUsualMetricDecimals;
  const bool is_coarse = digits().n_decimals == 2;
  const int n_usual_whole = is_inch ? kUsualInchWhole : kUsualMetricWhole;
  // With leading zeros kept, digits count from the left.
  has_usual_digits_ =
      info.format.decimal_digits == (is_coarse ? 2 : n_usual) &&
      (info.format.zeros == Zeros::TrailingKept ||
       info.format.integer_digits == (is_coarse ? digits().n_whole : n_usual_whole));
  written_unit_mm_ = info.format.one_unit().in_mm();
  n_decimals_ = digits().n_decimals;
  n_tool_decimals_ = std::max(n_decimals_, n_usual);
  limit_ = std::pow(10.0, digits().n_whole) - 0.5 * std::pow(10.0, -n_decimals_);
  text() += "M48\n";
  for (const std::string& comment : options().comments) line(';' + printable(comment));
  const NumberFormat& format = info.format;
  text() += "FMAT,2\n";
  text() += format.unit == LengthUnit::Inch ? "INCH," : "METRIC,";
  text() += format.zeros == Zeros::LeadingKept ? "LZ" : "TZ";
  // Settings are passed on as written, with numbers in the source's digits.
  if (is_coarse) text() += ',' + digits().form();
  text() += '\n';
  if (info.body_rules) text() += "OM48,ON\n";
  if (is_foreign()) put_foreign_header();
}

/// Header settings come first; whatever else comes ends the header. Only a zero set may come
/// between: the header's own, which is written as G93 behind it.
void ExcellonWriter::put(const Operation& operation) {
  note_place(operation);
  if (is_foreign() &&
      (n_open_patterns_ > 0 || std::holds_alternative<PatternBegin>(operation.what))) {
    put_held(nullptr);
    return store(operation);
  }
  if (!is_foreign() || !hold(operation)) put_now(operation);
}

void ExcellonWriter::put_now(const Operation& operation) {
  if (in_header_) {
    if (const auto* zero = std::get_if<ZeroSet>(&operation.what)) {
      header_zero_ = *zero;
      return;
    }
    const auto* setting = std::get_if<Setting>(&operation.what);
    if (setting == nullptr || setting->kind != SettingKind::Header) {
      const auto* stop = std::get_if<Stop>(&operation.what);
      const bool stops = stop != nullptr && stop->kind == StopKind::HeaderEnd;
      close_header(stops ? "%" : "M95");
      if (stops) return flush_if_large();
    }
  }
  // Nearly all operations of a program are holes.
  if (const auto* drill = std::get_if<Drill>(&operation.what)) return write(*drill);
  std::visit([this](const auto& what) { write(what); }, operation.what);
  flush_if_large();
}

void ExcellonWriter::end() {
  put_held(nullptr);
  end_replay();
  if (in_header_) close_header("M95");
  if (!has_end_) line("M30");
}

void ExcellonWriter::close_header(std::string_view mark) {
  in_header_ = false;
  for (const auto& [number, tool] : info().tools) put_tool(tool, true);
  line(mark);
  text() += "G90\nG05\n";
  // The machine's own page must not scale what is scaled already.
  if (info().is_scaled) line("M61");
  if (header_zero_) write(*header_zero_);
}

void ExcellonWriter::put_tool(const Tool& tool,
                              bool with_data,
                              std::optional<int> compensation_index) {
  if (compensation_index) {  // four digits, so that it is no other tool's number
    internal::append_format(text(), "T{:02}{:02}", tool.number, *compensation_index);
  } else {
    internal::append_format(text(), "T{}", tool.number);
  }
  if (with_data) {
    if (tool.diameter) append_length('C', *tool.diameter);
    if (tool.infeed) append_rate('F', *tool.infeed, 3);
    if (tool.speed) append_speed(*tool.speed);
    if (tool.retract) append_rate('B', *tool.retract, 4);
    if (tool.max_hits) {
      internal::append_format(text(), "H{}", *tool.max_hits);
      limited_tools_.insert(tool.number);
    } else if (limited_tools_.erase(tool.number) > 0) {
      text() += 'H';  // alone: turned off
    }
    if (tool.depth_offset) append_length('Z', *tool.depth_offset);
  }
  text() += '\n';
}

// --- numbers -----------------------------------------------------------------------------------

/// Whole rates with leading zeros, as the manual wants them.
void ExcellonWriter::append_rate(char letter, Feed rate, int n_digits) {
  const double value =
      info().format.unit == LengthUnit::Inch ? rate / inch_per_min(1) : rate.in_mm_s();
  long whole = std::lround(value);
  if (is_foreign()) {
    constexpr double kRounding = 0.005;
    constexpr double kMostChange = 0.1;
    whole = std::max(whole, 1L);
    const long most = n_digits == 3 ? 999 : 9999;
    if (whole > most || std::abs(value - static_cast<double>(whole)) > kMostChange * value) {
      refuse(fmt::format("a rate of {:.4g} {} ({})",
                         value,
                         info().format.unit == LengthUnit::Inch ? "in/min" : "mm/s",
                         letter),
             fmt::format("whole rates of 1 to {}", most));
      whole = std::min(whole, most);
    } else if (std::abs(value - static_cast<double>(whole)) > kRounding * value) {
      lose_once(fmt::format("a fraction of the rate {:.3f}, which becomes {},", value, whole));
    }
  }
  internal::append_format(text(), "{}{:0{}}", letter, whole, n_digits);
}

void ExcellonWriter::append_speed(SpindleSpeed speed) {
  text() += 'S';
  const double thousands = speed.in_rpm() / 1000;
  const std::size_t begin = text().size();
  append_fixed(text(), thousands, 3);
  // The decimal point keeps the number from being read by counting digits; the manual wants a
  // number behind it.
  if (text().find('.', begin) == std::string::npos) text() += ".0";
}

inline char* ExcellonWriter::write_length(char* at, double value) const {
  switch (n_decimals_) {
    case kUsualMetricDecimals:
      return write_fixed_as<kUsualMetricDecimals>(at, value, kPoint);
    case kUsualInchDecimals:
      return write_fixed_as<kUsualInchDecimals>(at, value, kPoint);
    default:
      return write_digits_with_point(at, value, n_decimals_);
  }
}

void ExcellonWriter::append_length(char letter, Length length, int n_decimals) {
  std::array<char, kFixedChars + 2> chars;
  const double value = length.in_mm() / written_unit_mm_;
  const char* const end = write_digits_with_point(chars.data(), value, n_decimals);
  text() += letter;
  text().append(chars.data(), static_cast<std::size_t>(end - chars.data()));
}

inline char* ExcellonWriter::write_point(char* at,
                                         const Eigen::Vector2d& p_mm,
                                         std::string_view letters) {
  const Eigen::Vector2d written = written_from_work() * p_mm / written_unit_mm_;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    *at++ = letters[axis];
    const double value = written[static_cast<Eigen::Index>(axis)];
    const char* const begin = at;
    at = write_length(at, value);
    // NaN as well.
    if (!(std::abs(value) < limit_)) count_digits({begin, static_cast<std::size_t>(at - begin)});
  }
  return at;
}

void ExcellonWriter::append_point(const Eigen::Vector2d& p_mm, std::string_view letters) {
  std::array<char, kPointChars> chars;
  const char* const end = write_point(chars.data(), p_mm, letters);
  text().append(chars.data(), static_cast<std::size_t>(end - chars.data()));
}

// --- drilling ----------------------------------------------------------------------------------

/// A tool's data are repeated where the header does not say the same: the body had them.
void ExcellonWriter::write(const ToolChange& change) {
  table_feed_.reset();
  const auto defined = info().tools.find(change.tool.number);
  const bool is_allowed = info().body_rules || overrides_rates_;
  if (!is_allowed && defined != info().tools.end() && contradict(change.tool, defined->second)) {
    fail(
        {Code::NotSupported,
         place(),
         fmt::format("tool {} has other data in the body than in the header, which would rule over "
                     "them in a plain Excellon program",
                     change.tool.number),
         "one set of data for the tool, or another output format"});
  }
  const bool says_more = defined == info().tools.end() || defined->second != change.tool;
  const bool ends_limit = !change.tool.max_hits && limited_tools_.contains(change.tool.number);
  put_tool(change.tool, says_more || ends_limit, change.compensation_index);
}

void ExcellonWriter::go_to_drill_mode() {
  if (std::exchange(is_routing_, false)) line("G05");
}

/// In rout mode F would be the table's feed.
void ExcellonWriter::write(const ToolRate& rate) {
  go_to_drill_mode();
  if (rate.infeed) append_rate('F', *rate.infeed, 3);
  if (rate.retract) append_rate('B', *rate.retract, 4);
  text() += '\n';
}

void ExcellonWriter::write(const Autocalibration& calibration) {
  text() += "G39";
  append_point(calibration.commanded.in_mm());
  text() += '\n';
}

void ExcellonWriter::write(const Drill& drill) {
  check_cut(drill.cut);
  go_to_drill_mode();
  char* end = write_point(begin_row(kPointChars + 1), drill.commanded.in_mm(), "XY");
  *end++ = '\n';
  end_row(end);
}

void ExcellonWriter::write(const Slot& slot) {
  check_cut(slot.cut);
  go_to_drill_mode();
  append_place(slot.start);
  text() += "G85";
  append_place(slot.end);
  text() += '\n';
}

// --- routing -----------------------------------------------------------------------------------

void ExcellonWriter::write(const RapidMove& move) {
  if (!std::exchange(is_routing_, true)) table_feed_.reset();
  at_mm_ = move.commanded.in_mm();
  text() += "G00";
  append_place(move);
  text() += '\n';
}

/// F in a block of its own is the table feed while the control is in rout mode (CNC-7 manual,
/// Z-Axis Infeed). The control's own default stays unsaid: in mm/s it is no whole rate.
void ExcellonWriter::put_table_feed(Feed feed, bool is_default) {
  if (is_default && !has_table_feed_) return;
  const bool is_inch = info().format.unit == LengthUnit::Inch;
  const long rate = std::lround(is_inch ? feed / inch_per_min(1) : feed.in_mm_s());
  if (table_feed_ == rate) return;
  table_feed_ = rate;
  has_table_feed_ = true;
  append_rate('F', feed, 3);
  text() += '\n';
}

/// I and J lead from the center to the start, as the manual measures them (Arc Center Offset).
void ExcellonWriter::write(const Rout& rout) {
  check_cut(rout.cut);
  put_table_feed(rout.feed, rout.feed_is_default);
  const Eigen::Vector2d from_mm = std::exchange(at_mm_, rout.commanded.in_mm());
  const Eigen::Vector2d center_mm = rout.commanded_center.in_mm();
  const Length step = digits().step();
  const Eigen::Vector2d start_mm = on_grid(from_mm, written_from_work(), step);
  const Eigen::Vector2d end_mm = on_grid(at_mm_, written_from_work(), step);
  const Eigen::Vector2d center_to_start_mm =
      half_turn_on_grid(start_mm,
                        end_mm,
                        center_of_rounded(start_mm, end_mm, center_mm),
                        rout.kind == RoutKind::Clockwise,
                        written_from_work(),
                        step);
  if (rout.kind == RoutKind::Line || is_flat(from_mm, at_mm_, center_mm, step)) {
    text() += "G01";
    append_place(rout);
  } else {
    const bool is_clockwise = (rout.kind == RoutKind::Clockwise) != is_mirrored();
    text() += is_clockwise ? "G02" : "G03";
    append_place(rout);
    append_point(center_to_start_mm, "IJ");
  }
  text() += '\n';
}

void ExcellonWriter::write(const Plunge& plunge) {
  check_cut(plunge.cut);
  if (plunge.depth_offset) {
    fail({Code::Internal,
          place(),
          "a pass of a step slot comes by itself, and no plain Excellon block gives its depth",
          "step slots left whole"});
  }
  is_down_ = true;
  line(plunge.kind == PlungeKind::Contouring ? "M14" : "M15");
}

void ExcellonWriter::write(const Retract& retract) {
  is_down_ = false;
  line(retract.with_clamping ? "M16" : "M17");
}

void ExcellonWriter::write(const Compensation& compensation) {
  if (is_down_) {
    return refuse("another cutter compensation inside a contour", "one for each contour");
  }
  if (compensation.side == CompensationSide::Off) return line("G40");
  line((compensation.side == CompensationSide::Left) != is_mirrored() ? "G41" : "G42");
}

/// G87 leaves the control in rout mode: it routs by G00 and G01 (CNC-7 manual, Routed Step Slot).
void ExcellonWriter::write(const StepSlot& slot) {
  // F is the table's feed in rout mode only.
  const bool says_feed = !slot.feed_is_default || has_table_feed_;
  if (!std::exchange(is_routing_, true)) {
    table_feed_.reset();
    if (says_feed) line("G00");
  }
  put_table_feed(slot.feed, slot.feed_is_default);
  append_place(slot.start);
  text() += "G87";
  append_place(slot.end);
  append_length('Z', slot.increment);
  append_length('U', slot.initial_depth);
  text() += '\n';
}

// --- stops, texts, settings --------------------------------------------------------------------

void ExcellonWriter::write(const Stop& stop) {
  switch (stop.kind) {
    case StopKind::EndAccepted:
      return line(';' + std::string(kEndAcceptedComment));
    case StopKind::EndNoRewind:
      end_replay();
      has_end_ = true;
      text() += "M00";
      break;
    case StopKind::EndRewind:
      end_replay();
      has_end_ = true;
      text() += "M30";
      break;
    case StopKind::HeaderEnd:  // in the body % begins a pattern; the control waits at M09 as well
    case StopKind::Inspection:
      text() += "M09";
      break;
    case StopKind::Optional:
      text() += "M06";
      break;
  }
  if (stop.from_absolute_zero) append_point(stop.from_absolute_zero->in_mm());
  text() += '\n';
}

/// Each line of a long message but the last ends in a backslash (CNC-7 manual, Long Operator
/// Message).
void ExcellonWriter::write(const Message& message) {
  if (is_foreign()) return put_foreign_message(message.text);
  text() += message.is_long ? "M45," : "M47,";
  for (const char c : message.text) {
    if (c == '\n') text() += '\\';
    text() += c;
  }
  text() += '\n';
}

/// One millisecond an increment of the coordinates, a whole number as in the manual's examples: its
/// increments do not depend on the digits that the control has selected, as those of one with a
/// decimal point would.
/// Source CNC-7 manual, Variable Dwell
void ExcellonWriter::write(const Dwell& dwell) {
  std::string increments = std::to_string(std::llround(dwell.duration.in_s() * 1000));
  if (info().format.zeros == Zeros::LeadingKept) {
    const bool is_coarse = n_decimals_ == 2;
    const auto n_digits = static_cast<std::size_t>(is_coarse ? digits().n_whole + 2 : kUsualDigits);
    increments.insert(0, n_digits - std::min(n_digits, increments.size()), '0');
    increments.erase(increments.find_last_not_of('0') + 1);
  }
  line("G04X" + increments);
}

/// The control changes a tool that is used up by itself.
void ExcellonWriter::write(const Function& function) {
  if (function.kind == FunctionKind::ToolExpired || function.text.empty()) return;
  if (is_foreign()) return lose(fmt::format("{} ({})", quoted(function.text), name(function.kind)));
  line(function.text);
}

void ExcellonWriter::write(const Setting& setting) {
  if (is_foreign()) return put_foreign_setting(setting);
  if (setting.text == "G05") go_to_drill_mode();
  if (setting.kind == SettingKind::Vision) {
    if (options().keeps_vision) return note_vision(setting.text);
    return lose_vision(setting);
  }
  if (is_written_anyway(setting.text)) return;
  if (!has_usual_digits_ && has_bare_length(setting.text)) {
    if (const auto pointed = with_points(setting.text, info().format)) return line(*pointed);
    fail({Code::NotSupported,
          place(),
          quoted(setting.text) + " has numbers in digits that the output does not state",
          "decimal points in it, or another output format"});
  }
  overrides_rates_ |= setting.text == "G07";
  line(with_decimals(setting.text, n_decimals_));
}

void ExcellonWriter::write(const ZeroSet& zero) {
  text() += "G93";
  const Eigen::Vector2d from_absolute_mm = (zero.work_zero - options().absolute_zero).in_mm();
  append_point(is_foreign() ? from_absolute_mm - options().work_zero.in_mm()
                            : zero.zero_set.in_mm());
  text() += '\n';
}

}  // namespace panelcal
