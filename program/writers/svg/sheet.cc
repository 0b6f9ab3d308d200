// SPDX-License-Identifier: Apache-2.0
#include "program/writers/svg/sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/base/append_format.h"
#include "program/text/xml_text.h"
#include "program/writers/text_writer.h"
#include <fmt/format.h>

namespace panelcal::svg {
namespace {

// Lengths of the layout, in sizes of the text.
constexpr double kTextsAcross = 52;  ///< on the longer side of the ground
constexpr double kRow = 2.3;
constexpr double kColumn = 17;
constexpr double kBelow = 2.6;  ///< for the numbers of the lower edge
constexpr double kSmall = 0.62;
constexpr double kSmallRow = 0.9;
constexpr double kCharacter = 0.56;  ///< width of an average one

/// Breaks a text into lines of at most `n` bytes, never inside a character.
void append_lines(std::vector<std::string>& lines, std::string_view text, std::size_t n) {
  while (text.size() > n) {
    std::size_t end = n;
    while (end > n - 4 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  lines.emplace_back(text);
}

void append_text(
    std::string& out, double x_mm, double y_mm, std::string_view css_class, std::string_view text) {
  out += "<text x=\"";
  append_mm(out, x_mm);
  out += "\" y=\"";
  append_mm(out, y_mm);
  internal::append_format(out, "\" class=\"{}\">", css_class);
  append_xml_text(out, text);
  out += "</text>\n";
}

}  // namespace

void append_mm(std::string& out, double value_mm) {
  append_fixed(out, value_mm, 3);
}

void append_mm(std::string& out, const Eigen::Vector2d& p_mm) {
  append_mm(out, p_mm.x());
  out += ' ';
  append_mm(out, p_mm.y());
}

std::string Color::hex() const {
  return fmt::format("#{:02x}{:02x}{:02x}", red, green, blue);
}

/// The first eight maximize the smallest CIELAB distance of any two, seen normally and with each
/// of the three kinds of colour blindness (Machado et al. 2009), at a lightness of 22 to 74.
Color tool_color(std::size_t i_tool) {
  constexpr std::array<Color, 8> kFirst = {{{0x33, 0x14, 0xb0},
                                            {0xff, 0x7f, 0x13},
                                            {0x55, 0xca, 0x92},
                                            {0xaa, 0x0a, 0x0b},
                                            {0x85, 0x78, 0xf3},
                                            {0x79, 0x31, 0x85},
                                            {0xe5, 0x93, 0xd5},
                                            {0x90, 0x1f, 0x47}}};
  if (i_tool < kFirst.size()) return kFirst[i_tool];
  // The golden angle keeps neighbours apart; three levels of lightness help.
  const double turns = std::fmod(0.4 + 0.381966 * static_cast<double>(i_tool - kFirst.size()), 1.0);
  const double lightness = 0.3 + 0.1 * static_cast<double>(i_tool % 3);
  const auto channel = [&](double offset) {
    const double k = std::fmod(offset + 12 * turns, 12.0);
    const double wave = std::max(-1.0, std::min({k - 3, 9 - k, 1.0}));
    return lightness - 0.65 * lightness * wave;
  };
  const double red = channel(0);
  const double green = channel(8);
  const double blue = channel(4);
  // Yellow would hardly be seen on white.
  const double scale = 255 * std::min(1.0, 0.5 / (0.3 * red + 0.59 * green + 0.11 * blue));
  const auto byte = [&](double part) { return static_cast<int>(std::lround(scale * part)); };
  return {byte(red), byte(green), byte(blue)};
}

double nice_below(double x) {
  if (!(x > 0) || !std::isfinite(x)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  const double first = x / power * (1 + 1e-12);
  return (first >= 5 ? 5 : first >= 2 ? 2 : 1) * power;
}

Sheet::Sheet(const Eigen::Vector2d& low_mm,
             const Eigen::Vector2d& high_mm,
             std::size_t n_legend_rows,
             std::string title,
             std::vector<std::string> provenance)
    : low_mm_(low_mm),
      high_mm_(high_mm),
      n_legend_rows_(n_legend_rows),
      title_(std::move(title)),
      provenance_(std::move(provenance)) {
  text_mm_ = side_mm() / kTextsAcross;
  const auto n_fitting = static_cast<std::size_t>(width_mm() / (kSmall * kCharacter * text_mm_));
  for (const std::string& line : provenance_) append_lines(provenance_lines_, line, n_fitting);
}

std::size_t Sheet::rows_in_column() const {
  const double n = size_mm().y() / (kRow * text_mm_);
  return std::max<std::size_t>(10, static_cast<std::size_t>(n));
}

double Sheet::width_mm() const {
  const std::size_t n_columns = (n_legend_rows_ + rows_in_column() - 1) / rows_in_column();
  const double legend = kColumn * static_cast<double>(n_columns);
  return low_mm_.x() - left_mm() + size_mm().x() + (1 + legend) * text_mm_;
}

double Sheet::height_mm() const {
  const double n_rows = static_cast<double>(std::min(n_legend_rows_, rows_in_column()));
  const double middle_mm = std::max(size_mm().y(), n_rows * kRow * text_mm_);
  const double n_lines = static_cast<double>(provenance_lines_.size());
  return -high_mm_.y() - top_mm() + middle_mm + (kBelow + kSmallRow * n_lines + 0.5) * text_mm_;
}

std::string Sheet::style() const {
  const auto em = [&](double n) {
    std::string out;
    append_mm(out, n * text_mm_);
    return out;
  };
  return fmt::format(
      "<style>\n"
      "text{{font-family:sans-serif;font-size:{0}px;fill:#222}}\n"
      ".title{{font-size:{1}px;font-weight:bold}}.detail{{font-size:{2}px;fill:#555}}\n"
      ".small{{font-size:{3}px;fill:#555}}.mid{{text-anchor:middle}}.end{{text-anchor:end}}\n"
      ".ground{{fill:#fbfbfb}}.rule{{fill:none;stroke:#e3e3e3;stroke-width:{4}px}}\n"
      ".zero{{fill:none;stroke:#b5b5b5;stroke-width:{5}px}}\n"
      ".rout{{fill:none;stroke-opacity:.4;stroke-linecap:round;stroke-linejoin:round}}\n"
      ".way{{fill:none;stroke-linecap:round;stroke-linejoin:round}}\n"
      ".rapid{{fill:none;stroke:#777;stroke-width:{5}px;stroke-dasharray:{6} {6}}}\n"
      ".instance{{fill:none;stroke:#777;stroke-width:{5}px}}\n"
      ".untooled{{fill:none;stroke:#222;stroke-width:{5}px}}\n"
      ".halo{{fill:none;stroke:#fff;stroke-width:{7}px;stroke-opacity:.8}}\n"
      ".target{{fill:none;stroke:#111;stroke-width:{8}px}}\n"
      ".label{{paint-order:stroke;stroke:#fff;stroke-width:{7}px;stroke-opacity:.8}}\n"
      ".residual{{fill:none;stroke:#d40000;stroke-width:{8}px;stroke-linecap:round}}\n"
      "</style>\n",
      em(1),
      em(1.5),
      em(0.75),
      em(kSmall),
      em(0.03),
      em(0.05),
      em(0.35),
      em(0.2),
      em(0.08));
}

/// Ground with a ruler of round lengths; the lines through work zero are darker.
std::string Sheet::rules() const {
  const double step_mm = nice_below(side_mm() / 6);
  const int n_decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step_mm) + 1e-9)));
  std::string lines;
  std::string zeros;
  std::string numbers;
  for (int axis = 0; axis < 2; ++axis) {
    const double first = std::ceil(low_mm_[axis] / step_mm);
    for (int i = 0; i <= 40 && (first + i) * step_mm <= high_mm_[axis]; ++i) {
      const double at_mm = (first + i) * step_mm;
      std::string& path = first + i == 0 ? zeros : lines;
      const std::string number = fmt::format("{:.{}f}", at_mm, n_decimals);
      path += 'M';
      if (axis == 0) {
        append_mm(path, {at_mm, -low_mm_.y()});
        path += 'V';
        append_mm(path, -high_mm_.y());
        append_text(numbers, at_mm, -low_mm_.y() + 1.1 * text_mm_, "detail mid", number);
      } else {
        append_mm(path, {low_mm_.x(), -at_mm});
        path += 'H';
        append_mm(path, high_mm_.x());
        append_text(
            numbers, low_mm_.x() - 0.4 * text_mm_, -at_mm + 0.27 * text_mm_, "detail end", number);
      }
    }
  }
  std::string out = "<path class=\"ground\" d=\"M";
  append_mm(out, {low_mm_.x(), -high_mm_.y()});
  out += 'H';
  append_mm(out, high_mm_.x());
  out += 'V';
  append_mm(out, -low_mm_.y());
  out += 'H';
  append_mm(out, low_mm_.x());
  out += "z\"/>\n<path class=\"rule\" d=\"" + lines + "\"/>\n<path class=\"zero\" d=\"" + zeros +
         "\"/>\n" + numbers;
  append_text(out,
              (low_mm_.x() + high_mm_.x()) / 2,
              -low_mm_.y() + 2.1 * text_mm_,
              "detail mid",
              "mm from work zero");
  return out;
}

std::string Sheet::open() const {
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"";
  append_mm(out, {left_mm(), top_mm()});
  out += ' ';
  append_mm(out, {width_mm(), height_mm()});
  out += "\" role=\"img\">\n<title>";
  append_xml_text(out, title_);
  out += "</title>\n<desc>";
  for (const std::string& line : provenance_) {
    append_xml_text(out, line);
    out += '\n';
  }
  out += "</desc>\n" + style() + "<rect x=\"";
  append_mm(out, left_mm());
  out += "\" y=\"";
  append_mm(out, top_mm());
  out += "\" width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  if (!title_.empty()) {
    append_text(out, low_mm_.x(), -high_mm_.y() - 0.9 * text_mm_, "title", title_);
  }
  return out + rules() + "<g transform=\"scale(1,-1)\">\n";
}

std::string Sheet::close(std::string_view labels, std::span<const LegendRow> legend) const {
  std::string out = "</g>\n";
  out += labels;
  for (std::size_t i = 0; i < legend.size(); ++i) {
    const double column = static_cast<double>(i / rows_in_column());
    const double row = static_cast<double>(i % rows_in_column());
    const double x_mm = high_mm_.x() + (1.5 + kColumn * column) * text_mm_;
    const double y_mm = -high_mm_.y() + (1 + kRow * row) * text_mm_;
    out += "<g transform=\"translate(";
    append_mm(out, {x_mm, y_mm - 0.35 * text_mm_});
    out += ") scale(";
    append_mm(out, text_mm_);
    out += ")\">" + legend[i].swatch + "</g>\n";
    append_text(out, x_mm + 1.2 * text_mm_, y_mm, "row", legend[i].text);
    if (legend[i].detail.empty()) continue;
    append_text(out, x_mm + 1.2 * text_mm_, y_mm + 0.95 * text_mm_, "detail", legend[i].detail);
  }
  double y_mm = top_mm() + height_mm();
  y_mm -= kSmallRow * text_mm_ * static_cast<double>(provenance_lines_.size());
  for (const std::string& line : provenance_lines_) {
    append_text(out, left_mm() + 0.5 * text_mm_, y_mm, "small", line);
    y_mm += kSmallRow * text_mm_;
  }
  return out + "</svg>\n";
}

}  // namespace panelcal::svg
