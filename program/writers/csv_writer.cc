// SPDX-License-Identifier: Apache-2.0
#include "program/writers/csv_writer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "program/writers/description.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::size_t kColumns = kNumberOfOperationColumns;
constexpr std::size_t kSigma = Field("sigma").column;
constexpr std::size_t kRisk = Field("risk").column;

/// Takes the fields of one row in any order, and writes them by columns; others are empty.
class Row {
 public:
  void number(Field field, int n) {
    begin(field.column);
    const fmt::format_int digits(n);
    text_.append(digits.data(), digits.size());
    end(field.column);
  }
  void value(Field field, double v) { put(field.column, v); }
  void length(Field field, Length v) { put(field.column, v.in_mm()); }
  void point(Field field, const Eigen::Vector2d& p) {
    put(field.column, p.x());
    put(field.column + 1, p.y());
  }
  void risk(Field field, double v) {
    begin(field.column);
    append_risk(text_, v);
    end(field.column);
  }
  void flag(Field field) { word(field, "true"); }
  void word(Field field, std::string_view v) {
    begin(field.column);
    text_ += v;
    end(field.column);
  }
  /// Quotes a field where it needs quotes. An apostrophe before what a spreadsheet would take for
  /// a formula makes it a text there.
  void text(Field field, std::string_view v) {
    constexpr std::string_view kBeginFormulas = "=+-@\t\r";
    const bool is_formula = !v.empty() && kBeginFormulas.find(v.front()) != v.npos;
    if (!is_formula && v.find_first_of(",\"\r\n") == v.npos) return word(field, v);
    begin(field.column);
    text_ += is_formula ? "\"'" : "\"";
    for (const char c : v) {
      if (c == '"') text_ += '"';
      text_ += c;
    }
    text_ += '"';
    end(field.column);
  }
  void append_to(std::string& out) const {
    for (std::size_t column = 0; column < kColumns; ++column) {
      if (column > 0) out += ',';
      out.append(text_, begins_[column], ends_[column] - begins_[column]);
    }
    out += '\n';
  }

 private:
  void begin(std::size_t column) { begins_[column] = text_.size(); }
  void end(std::size_t column) { ends_[column] = text_.size(); }
  void put(std::size_t column, double v) {
    begin(column);
    append_fixed(text_, v, kMmDecimals);
    end(column);
  }

  std::string text_;  ///< of all fields, as they came
  std::array<std::size_t, kColumns> begins_{};
  std::array<std::size_t, kColumns> ends_{};
};

/// Fields behind sigma in the row of a hole without a risk.
constexpr auto kBehindSigma = [] {
  std::array<char, kColumns - kSigma - 1> end{};
  end.fill(',');
  end.back() = '\n';
  return end;
}();
/// The fields behind the risk.
constexpr std::size_t kHoleEnd = kColumns - kRisk;

char* write_integer(char* at, int n) {
  if (n < 0) *at++ = '-';
  return write_count(at,
                     n < 0 ? 0U - static_cast<std::uint32_t>(n) : static_cast<std::uint32_t>(n));
}

constexpr std::string_view kHoleName = "drill,";
constexpr std::size_t kMostPathLevels = 6;
constexpr std::size_t kHoleRowChars = kHoleName.size() + (kMostPathLevels + 2) * (kCountChars + 2) +
                                      3 * kCsvPointChars + kBehindSigma.size() + kRiskChars +
                                      kHoleEnd;

/// Nearly every row of a file is a hole's, so those are built at once instead of field by field.
/// Deep paths and stored patterns go the other way; null then.
const Drill* as_simple_hole(const Operation& operation) {
  const auto* drill = std::get_if<Drill>(&operation.what);
  const bool is_simple = drill != nullptr && operation.path.size() <= kMostPathLevels &&
                         operation.file.empty() && drill->cut.is_empty();
  return is_simple ? drill : nullptr;
}

char* write_path(char* at, std::span<const int> path) {
  for (const int index : path) {
    at = write_integer(at, index);
    *at++ = '.';
  }
  return path.empty() ? at : at - 1;
}

char* write_point(char* end, const Eigen::Vector2d& p_mm) {
  *end = ',';
  end = write_fixed_as<kMmDecimals>(end + 1, p_mm.x());
  *end = ',';
  return write_fixed_as<kMmDecimals>(end + 1, p_mm.y());
}

/// Copies the text of a point; gives its end. The copy may begin where the text ends.
char* copy_point(const char* text, std::size_t n_chars, char* to) {
  constexpr std::size_t kPiece = 16;  // moved by two instructions
  static_assert(kCsvPointChars % kPiece == 0);
  std::size_t i = 0;
  do {
    std::memmove(to + i, text + i, kPiece);
    i += kPiece;
  } while (i < n_chars);
  return to + n_chars;
}

}  // namespace

/// Holes under a mere offset have one sigma, and those without a correction have none: its text is
/// kept from the second hole on.
char* CsvWriter::write_sigma(char* at, const Drill& drill) {
  const double x_mm2 = drill.cov_mm2(0, 0);
  const double y_mm2 = drill.cov_mm2(1, 1);
  if (x_mm2 != sigma_.x_mm2 || y_mm2 != sigma_.y_mm2) {
    sigma_.x_mm2 = x_mm2;
    sigma_.y_mm2 = y_mm2;
    sigma_.n_chars = 0;
    return write_point(at, sigma_mm(drill));
  }
  char* const text = sigma_.text.data();
  if (sigma_.n_chars == 0) {
    sigma_.n_chars = static_cast<std::size_t>(write_point(text, sigma_mm(drill)) - text);
  }
  return copy_point(text, sigma_.n_chars, at);
}

char* CsvWriter::write_hole(char* end, const Operation& operation, const Drill& drill) {
  end = std::ranges::copy(kHoleName, end).out;
  end = write_integer(end, operation.line);
  *end++ = ',';
  if (!operation.path.empty()) end = write_path(end, operation.path);
  *end++ = ',';
  end = write_integer(end, drill.tool);
  const Eigen::Vector2d& nominal_mm = drill.nominal.in_mm();
  const Eigen::Vector2d& actual_mm = drill.actual.in_mm();
  const char* const nominal_text = end;
  end = write_point(end, nominal_mm);
  // Without a correction both are the same, and converting them is most of the work.
  end = actual_mm == nominal_mm
            ? copy_point(nominal_text, static_cast<std::size_t>(end - nominal_text), end)
            : write_point(end, actual_mm);
  end = write_sigma(end, drill);
  char* const risk = end + kBehindSigma.size() - kHoleEnd;
  end = std::ranges::copy(kBehindSigma, end).out;
  if (!drill.risk) return end;
  return std::copy_n(kBehindSigma.end() - kHoleEnd, kHoleEnd, write_risk(risk, *drill.risk));
}

void CsvWriter::begin(const ProgramInfo& info) {
  if (judge_) judge_->begin(info);
  text() += kOperationColumns;
  text() += '\n';
}

void CsvWriter::put(const Operation& operation) {
  static_assert(kHoleRowChars <= kMostRow);
  const Drill* const drill = as_simple_hole(operation);
  if (drill == nullptr) {
    // What was probed is in the strokes' depths.
    if (!std::holds_alternative<SurfaceOrder>(operation.what)) put_by_fields(operation);
    return;
  }
  end_row(write_hole(begin_row(kHoleRowChars), operation, *drill));
}

void CsvWriter::put_by_fields(const Operation& operation) {
  Row row;
  row.word("op", operation_name(operation));
  row.number("line", operation.line);
  row.word("path", fmt::format("{}", fmt::join(operation.path, ".")));
  row.text("file", operation.file);
  describe(operation, row);
  if (judge_) {
    if (const auto judged = judge_->judge(operation)) {
      row.risk("risk_shallow", judged->risk.too_shallow);
      row.risk("risk_deep", judged->risk.too_deep);
    }
  }
  row.append_to(text());
  flush_if_large();
}

}  // namespace panelcal
