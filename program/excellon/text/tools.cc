// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/tools.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

bool is_tool_digits(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// A whole rate with leading zeros kept: of three digits, `2` is 200 and `02` is 20.
std::optional<double> parse_rate(std::string_view text, std::size_t n_digits) {
  if (!is_tool_digits(text) || text.size() > n_digits) return std::nullopt;
  double value = *parse_count(text);
  for (std::size_t i = text.size(); i < n_digits; ++i) value *= 10;
  return value;
}

/// Thousands of revolutions a minute: `612` is 61,200, `6` is 60,000, `110.5` is 110,500.
std::optional<double> parse_speed_rpm(std::string_view text) {
  if (is_tool_digits(text) && text.size() <= 3) return *parse_rate(text, 3) * 100;
  if (text.find('.') == std::string_view::npos) return std::nullopt;
  // Millimetres are stored as they are, so that 110.5 stays exact.
  const ParsedLength thousands = parse_length(text, {.unit = LengthUnit::Millimeter});
  if (thousands.fault != NumberFault::None || thousands.value < Length()) return std::nullopt;
  return thousands.value.in_mm() * 1000;
}

/// Range that the manual allows in the program's own unit.
struct RateRange {
  double least_inch_per_min;
  double most_inch_per_min;
  double least_mm_per_s;
  double most_mm_per_s;
};
constexpr RateRange kInfeedRange = {10, 500, 4, 212};
constexpr RateRange kTableRange = {10, 150, 4, 63};
constexpr RateRange kRetractRange = {10, 1000, 5, 425};

std::string range_text(const RateRange& range) {
  return std::to_string(std::lround(range.least_inch_per_min)) + " to " +
         std::to_string(std::lround(range.most_inch_per_min)) + " in/min (" +
         std::to_string(std::lround(range.least_mm_per_s)) + " to " +
         std::to_string(std::lround(range.most_mm_per_s)) + " mm/s)";
}

class ToolReader {
 public:
  ToolReader(const Block& block,
             const NumberFormat& format,
             const std::vector<Tool>& diameter_page,
             const Reporter& reporter)
      : block_(block), format_(format), diameter_page_(diameter_page), reporter_(reporter) {}

  bool read_number(const std::map<int, Tool>* defined, ToolBlock& out) const {
    const Word& word = block_.words[0];
    const std::optional<int> number = parse_count(word.number);
    if (!number || !is_tool_digits(word.number) || word.number.size() > 4) {
      return fail(word, "a tool number of 1 to 4 digits");
    }
    out.tool.number = *number;
    const bool has_index_only = word.number.size() == 4 && word.number.front() == '0';
    if (!defined && has_index_only && *number >= 100) {
      reporter_.report(
          Code::ArgumentInvalid,
          block_.of(word),
          fmt::format(" is tool {} with a compensation index, or tool {}", *number / 100, *number),
          fmt::format("T{} or T{} in the header", *number / 100, *number));
      return false;
    }
    if (!defined || word.number.size() <= 2) return true;
    if (defined->contains(*number) && !has_index_only) return true;
    out.tool.number = *number / 100;
    // 00 means the tool's own number (CNC-7 manual, Tool Selection with Compensation Index).
    out.compensation_index = *number % 100 == 0 ? out.tool.number : *number % 100;
    return true;
  }

  bool read_datum(const Word& word, ToolBlock& out) const {
    Tool& tool = out.tool;
    switch (word.letter) {
      case 'C':  // unlike Z, which is the mean without a number
        if (word.number.empty()) return fail(word, "a number behind it");
        if (!read_length(word, tool.diameter) || !check_diameter(word, tool)) return false;
        load_page(word, tool);
        return true;
      case 'Z':
        return read_length(word, tool.depth_offset);
      case 'F':
        return read_feed(word, 3, kInfeedRange, tool.infeed);
      case 'B':
        return read_feed(word, 4, kRetractRange, tool.retract);
      case 'S':
        return read_speed(word, tool);
      case 'H':
        out.turns_hits_off = word.number.empty();
        return read_hits(word, tool);
      default:
        reporter_.report(Code::BlockNotAlone,
                         block_.of(word),
                         " in a tool block",
                         "only C, F, S, B, H and Z behind T");
        return false;
    }
  }

  bool read_feed(const Word& word,
                 std::size_t n_digits,
                 const RateRange& range,
                 std::optional<Feed>& out) const {
    const std::optional<double> rate = parse_rate(word.number, n_digits);
    if (!rate) {
      return fail(word, "1 to " + std::to_string(n_digits) + " digits without a decimal point");
    }
    out.reset();
    if (*rate == 0) return true;  // how CAM systems say that they do not know
    const bool is_inch = format_.unit == LengthUnit::Inch;
    out = is_inch ? inch_per_min(*rate) : mm_per_s(*rate);
    if (*rate < (is_inch ? range.least_inch_per_min : range.least_mm_per_s) ||
        *rate > (is_inch ? range.most_inch_per_min : range.most_mm_per_s)) {
      reporter_.report(
          Code::RateOutOfRange,
          block_.of(word),
          " is " + std::to_string(std::lround(*rate)) + (is_inch ? " in/min" : " mm/s"),
          range_text(range));
    }
    return true;
  }

 private:
  bool fail(const Word& word, std::string expected) const {
    reporter_.report(Code::ArgumentInvalid, block_.of(word), std::move(expected));
    return false;
  }

  bool read_length(const Word& word, std::optional<Length>& out) const {
    const ParsedLength parsed = parse_length(word.number, format_);
    if (parsed.fault != NumberFault::None) {
      reporter_.report_number(parsed.fault, word.number, block_.line, word.column + 1, format_);
      return false;
    }
    out = parsed.value;
    return true;
  }

  bool check_diameter(const Word& word, Tool& tool) const {
    if (*tool.diameter > Length()) return true;
    if (*tool.diameter < Length()) return fail(word, "a diameter above zero");
    tool.diameter.reset();  // C0 is how CAM systems say that they do not know
    return true;
  }

  bool read_speed(const Word& word, Tool& tool) const {
    const std::optional<double> speed_rpm = parse_speed_rpm(word.number);
    if (!speed_rpm) return fail(word, "thousands of rpm: up to 3 digits, or a decimal point");
    tool.speed.reset();
    if (*speed_rpm > 0) tool.speed = rpm(*speed_rpm);
    return true;
  }

  bool read_hits(const Word& word, Tool& tool) const {
    tool.max_hits.reset();
    if (word.number.empty()) return true;  // H alone turns the counter off
    tool.max_hits = parse_count(word.number);
    return tool.max_hits ? true : fail(word, "a whole number of hits, or nothing");
  }

  /// A diameter takes its data from the diameter page, over what stands to its left.
  void load_page(const Word& word, Tool& tool) const {
    if (!tool.diameter) return;
    constexpr double kSameDiameter_mm = 0.0005;
    const auto row = std::ranges::find_if(diameter_page_, [&](const Tool& entry) {
      return std::abs(entry.diameter->in_mm() - tool.diameter->in_mm()) < kSameDiameter_mm;
    });
    if (row == diameter_page_.end()) {
      if (diameter_page_.empty() && (tool.infeed || tool.speed || tool.retract)) {
        reporter_.report(Code::ToolOrder,
                         block_.line,
                         word.column,
                         quoted(block_.text) +
                             ": the diameter page may override what stands left "
                             "of " +
                             quoted(word.text()),
                         "C# before F, S and B");
      }
      return;
    }
    if (row->infeed) tool.infeed = row->infeed;
    if (row->retract) tool.retract = row->retract;
    if (row->speed) tool.speed = row->speed;
    if (row->max_hits) tool.max_hits = row->max_hits;
    if (row->depth_offset) tool.depth_offset = row->depth_offset;
  }

  const Block& block_;
  const NumberFormat& format_;
  const std::vector<Tool>& diameter_page_;
  const Reporter& reporter_;
};

}  // namespace

bool has_dimension(const Tool& tool) {
  return tool.diameter || tool.infeed || tool.retract || tool.depth_offset;
}

std::optional<ToolBlock> read_tool_block(const Block& block,
                                         const ToolContext& context,
                                         const Reporter& reporter) {
  if (block.argument_column != 0) {
    reporter.report(Code::BlockNotAlone,
                    block.of_argument(),
                    " in " + quoted(block.text),
                    "a tool block without a comma");
    return std::nullopt;
  }
  const ToolReader reader(block, context.format, context.diameter_page, reporter);
  ToolBlock out;
  if (!reader.read_number(context.defined, out)) return std::nullopt;
  for (const Word& word : block.all().subspan(1)) {
    if (!reader.read_datum(word, out)) return std::nullopt;
  }
  return out;
}

const Word* padded_length(const Block& block, const NumberFormat& format) {
  for (const Word& word : block.all()) {
    const bool is_length = word.letter == 'C' || word.letter == 'Z';
    if (is_length && has_extra_digits(word.number, format)) return &word;
  }
  return nullptr;
}

bool read_rate(const Block& block,
               const Word& word,
               const NumberFormat& format,
               bool routing,
               const Reporter& reporter,
               std::optional<Feed>& out) {
  const std::vector<Tool> no_page;
  const ToolReader reader(block, format, no_page, reporter);
  return word.letter == 'B' ? reader.read_feed(word, 4, kRetractRange, out)
                            : reader.read_feed(word, 3, routing ? kTableRange : kInfeedRange, out);
}

}  // namespace panelcal::excellon
