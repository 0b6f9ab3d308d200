// SPDX-License-Identifier: Apache-2.0
#include "vision/show/overlay_panel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontScale = 0.4;
constexpr int kLineHeight = 16;
constexpr int kAscent = 11;
constexpr int kPanelMargin = 8;
constexpr int kInsetSide = 144;
/// From here on an ellipse is shown as the strip that it looks like from near.
constexpr double kStrip = 20;

const cv::Scalar kPaper(248, 248, 248);
const cv::Scalar kLine(205, 205, 205);

cv::Scalar paper_color(Ink ink) {
  switch (ink) {
    case Ink::Plain:
      return {30, 30, 30};
    case Ink::Quiet:
      return {115, 115, 115};
    case Ink::Good:
      return {30, 120, 20};
    case Ink::Bad:
      return {35, 35, 190};
    case Ink::Other:
      return {0, 105, 160};
  }
  return {};
}

int width_of(const std::string& text) {
  int baseline = 0;
  return cv::getTextSize(text, kFont, kFontScale, 1, &baseline).width;
}

/// The first part of a text that fits: up to a blank if there is one, and always one letter.
std::size_t fitting(const std::string& text, int width) {
  std::size_t n = text.size();
  // Widths only grow with the text.
  if (width_of(text) > width) {
    std::size_t low = 1;
    while (low + 1 < n) {
      const std::size_t middle = (low + n) / 2;
      (width_of(text.substr(0, middle)) <= width ? low : n) = middle;
    }
    n = low;
    if (const auto blank = text.rfind(' ', n); blank != std::string::npos && blank > 0) n = blank;
  }
  return n;
}

using Lines = std::vector<LegendLine>;

/// Lines that fit into a width; what does not fit goes on in the next line, indented.
Lines wrapped_lines(const Lines& lines, int width) {
  Lines out;
  for (const LegendLine& line : lines) {
    // File names may be of any length.
    constexpr std::size_t kMaxLetters = 1000;
    std::string rest = line.text.substr(0, kMaxLetters);
    std::string indent;
    while (!rest.empty()) {
      const std::size_t n = fitting(rest, width - width_of(indent));
      out.push_back({indent + rest.substr(0, n), line.ink});
      rest.erase(0, std::min(rest.size(), n + (n < rest.size() && rest[n] == ' ' ? 1 : 0)));
      indent = "   ";
    }
  }
  return out;
}

int height_of(const Lines& lines) {
  return kLineHeight * static_cast<int>(lines.size());
}

void write(cv::Mat& paper, const Lines& lines, cv::Point top_left) {
  top_left.y += kAscent;
  for (const LegendLine& line : lines) {
    cv::putText(
        paper, line.text, top_left, kFont, kFontScale, paper_color(line.ink), 1, cv::LINE_AA);
    top_left.y += kLineHeight;
  }
}

/// Scale of the shown uncertainty: `scale` pixels of the inset are one of the picture.
struct Magnified {
  UncertaintyEllipse ellipse;
  double scale = 1;
  bool is_strip = false;
};

std::optional<Magnified> magnified(const TargetFit& fit) {
  if (!fit.center.cov.allFinite()) return std::nullopt;
  Magnified m{uncertainty_ellipse(fit.center.cov)};
  const double major_px = m.ellipse.major_px.norm();
  const double minor_px = m.ellipse.minor_px.norm();
  if (!(minor_px > 1e-9) || !(major_px < 1e9)) return std::nullopt;
  m.is_strip = major_px > kStrip * minor_px;
  m.scale = m.is_strip ? 0.2 * kInsetSide / minor_px : 0.36 * kInsetSide / major_px;
  return m;
}

void draw_uncertainty(cv::Mat& inset, const Magnified& m, const cv::Scalar& color) {
  const double middle = 0.5 * (kInsetSide - 1);
  const auto at = [&](const Eigen::Vector2d& v) {
    return fixed_point(middle + m.scale * v.x(), middle + m.scale * v.y());
  };
  const auto line = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    cv::line(inset, at(from), at(to), color, 1, cv::LINE_AA, kFractionBits);
  };
  const Eigen::Vector2d reach = 2 * kInsetSide / m.scale * m.ellipse.major_px.normalized();
  if (m.is_strip) {
    line(m.ellipse.minor_px - reach, m.ellipse.minor_px + reach);
    line(-m.ellipse.minor_px - reach, -m.ellipse.minor_px + reach);
    line(-reach, reach);
    return;
  }
  constexpr int kNodes = 96;
  std::vector<cv::Point> nodes;
  for (int i = 0; i < kNodes; ++i) {
    const double t = 2 * std::numbers::pi * i / kNodes;
    nodes.push_back(
        at(Eigen::Vector2d(std::cos(t) * m.ellipse.major_px + std::sin(t) * m.ellipse.minor_px)));
  }
  cv::polylines(inset, nodes, true, color, 1, cv::LINE_AA, kFractionBits);
  const double arm = 5 / m.scale;
  line({-arm, 0}, {arm, 0});
  line({0, -arm}, {0, arm});
}

/// The inset with its scale: a bar, and in words.
cv::Mat inset_of(const Magnified& m, Ink ink) {
  const Lines words =
      wrapped_lines({{m.is_strip ? "95 % in this strip;" : "95 % in this ellipse;", Ink::Quiet},
                     {fmt::format("{:g} px = {:.0f} px here",
                                  round_length(0.45 * kInsetSide / m.scale),
                                  m.scale * round_length(0.45 * kInsetSide / m.scale)),
                      Ink::Quiet}},
                    kInsetSide);
  cv::Mat inset(kInsetSide + height_of(words) + 4, kInsetSide, CV_8UC3, kPaper);
  cv::Mat square = inset(cv::Rect(0, 0, kInsetSide, kInsetSide));
  square.setTo(cv::Scalar(255, 255, 255));
  draw_uncertainty(square, m, paper_color(ink));
  const int bar =
      static_cast<int>(std::lround(m.scale * round_length(0.45 * kInsetSide / m.scale)));
  const cv::Scalar dark = paper_color(Ink::Plain);
  const int bar_y = kInsetSide - 8;
  cv::line(square, {6, bar_y}, {6 + bar, bar_y}, dark);
  cv::line(square, {6, bar_y - 3}, {6, bar_y + 3}, dark);
  cv::line(square, {6 + bar, bar_y - 3}, {6 + bar, bar_y + 3}, dark);
  cv::rectangle(square, {0, 0}, {kInsetSide - 1, kInsetSide - 1}, kLine);
  write(inset, words, {0, kInsetSide + 4});
  return inset;
}

}  // namespace

cv::Point fixed_point(double x, double y) {
  const auto fixed = [](double v) {
    if (std::isnan(v)) v = -1e5;
    return static_cast<int>(std::lround(std::clamp(v, -1e5, 1e5) * (1 << kFractionBits)));
  };
  return {fixed(x), fixed(y)};
}

cv::Scalar picture_color(Ink ink) {
  switch (ink) {
    case Ink::Plain:
      return {255, 255, 255};
    case Ink::Quiet:
      return {220, 160, 90};
    case Ink::Good:
      return {60, 200, 60};
    case Ink::Bad:
      return {70, 70, 245};
    case Ink::Other:
      return {0, 200, 230};
  }
  return {};
}

cv::Mat legend_panel(const Detection& detection, const Legend& legend, int width) {
  const int text_width = width - 2 * kPanelMargin;
  const auto uncertainty = detection.best ? magnified(*detection.best) : std::nullopt;
  cv::Mat inset;
  if (uncertainty) inset = inset_of(*uncertainty, ink_of(detection.status));
  const int facts_x = kPanelMargin + (uncertainty ? kInsetSide + kPanelMargin : 0);

  const Lines verdict = wrapped_lines(legend.verdict, text_width);
  const Lines facts = wrapped_lines(legend.facts, std::max(40, width - kPanelMargin - facts_x));
  const Lines candidates = wrapped_lines(legend.candidates, text_width);
  const int middle_y = kPanelMargin + height_of(verdict) + kPanelMargin / 2;
  const int middle_height = std::max(height_of(facts), inset.rows);
  const int candidates_y = middle_y + (middle_height > 0 ? middle_height + kPanelMargin / 2 : 0);

  cv::Mat paper(candidates_y + height_of(candidates) + kPanelMargin, width, CV_8UC3, kPaper);
  write(paper, verdict, {kPanelMargin, kPanelMargin});
  if (uncertainty && facts_x < width) {
    inset.copyTo(paper(cv::Rect(kPanelMargin, middle_y, inset.cols, inset.rows)));
  }
  write(paper, facts, {facts_x, middle_y});
  write(paper, candidates, {kPanelMargin, candidates_y});
  return paper;
}

}  // namespace panelcal::internal
