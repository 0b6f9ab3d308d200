// SPDX-License-Identifier: Apache-2.0
#include "tools/history/plot.h"

#include <algorithm>
#include <cmath>

#include "calib/base/clock.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

constexpr double kHistoryWidth_px = 900;
constexpr double kHistoryHeight_px = 360;
constexpr double kHistoryLeft_px = 110;
constexpr double kRight_px = 24;
constexpr double kHistoryTop_px = 48;
constexpr double kBottom_px = 48;
constexpr double kMark_px = 4;
constexpr int kTimeTicks = 5;

/// From the least to the greatest value, never empty.
struct PlotRange {
  double low = 0;
  double high = 0;

  /// At least so much that the ticks of equal values can be told apart.
  void widen(double part) {
    const double margin =
        std::max({part * (high - low), 1e-9 * std::max(std::abs(low), std::abs(high)), 1e-12});
    low -= margin;
    high += margin;
  }
};

/// A step of 1, 2 or 5 times a power of ten that makes about five of the range.
double step_of(const PlotRange& range) {
  const double rough = (range.high - range.low) / 5;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10 * power;
}

/// Digits behind the point, so that neighbouring ticks differ.
int decimals_of(double step) {
  return std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 12);
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

bool is_refused(const LedgerSeries::Point& point) {
  return point.verdict == LedgerVerdict::Refused;
}

class Plot {
 public:
  explicit Plot(const LedgerSeries& series) : series_(series) {
    const auto seconds = [](const LedgerSeries::Point& p) {
      return static_cast<double>(p.time.time_since_epoch().count());
    };
    time_s_ = {seconds(series.points.front()), seconds(series.points.front())};
    // A refused point may be anywhere; the others are what the picture is for.
    const bool all_refused = std::all_of(series.points.begin(), series.points.end(), is_refused);
    bool is_first = true;
    for (const LedgerSeries::Point& point : series.points) {
      time_s_ = {std::min(time_s_.low, seconds(point)), std::max(time_s_.high, seconds(point))};
      if (is_refused(point) && !all_refused) continue;
      const double low = point.value - point.sigma.value_or(0);
      const double high = point.value + point.sigma.value_or(0);
      value_ = is_first ? PlotRange{low, high}
                        : PlotRange{std::min(value_.low, low), std::max(value_.high, high)};
      is_first = false;
    }
    if (time_s_.low == time_s_.high) time_s_ = {time_s_.low - 43200, time_s_.high + 43200};
    value_.widen(0.08);
  }

  std::string axes() const {
    std::string out = fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#888\"/>\n",
        kHistoryLeft_px,
        kHistoryTop_px,
        kHistoryWidth_px - kHistoryLeft_px - kRight_px,
        kHistoryHeight_px - kHistoryTop_px - kBottom_px);
    const double step = step_of(value_);
    const int decimals = decimals_of(step);
    for (double k = std::ceil(value_.low / step); k * step <= value_.high; k += 1) {
      const double y = y_px(k * step);
      out += fmt::format(
          "<path d=\"M{} {:.2f}H{}\" stroke=\"#ddd\"/>"
          "<text x=\"{}\" y=\"{:.2f}\" text-anchor=\"end\">{:.{}f}</text>\n",
          kHistoryLeft_px,
          y,
          kHistoryWidth_px - kRight_px,
          kHistoryLeft_px - 6,
          y + 4,
          k * step + 0.0,
          decimals);
    }
    for (int i = 0; i < kTimeTicks; ++i) {
      const double time_s =
          time_s_.low + (time_s_.high - time_s_.low) * i / static_cast<double>(kTimeTicks - 1);
      const std::string text = iso_8601(
          std::chrono::sys_seconds(std::chrono::seconds(static_cast<std::int64_t>(time_s))));
      const char* anchor = i == 0 ? "start" : i == kTimeTicks - 1 ? "end" : "middle";
      out += fmt::format("<text x=\"{:.2f}\" y=\"{}\" text-anchor=\"{}\">{} {}</text>\n",
                         x_px(time_s),
                         kHistoryHeight_px - kBottom_px + 18,
                         anchor,
                         text.substr(0, 10),
                         text.substr(11, 5));
    }
    return out;
  }

  std::string points() const {
    std::string out;
    for (const LedgerSeries::Point& point : series_.points) {
      const double x = x_px(static_cast<double>(point.time.time_since_epoch().count()));
      const double y = y_px(point.value);
      if (point.sigma) {
        out += fmt::format("<path d=\"M{:.2f} {:.2f}V{:.2f}\" stroke=\"#0072b2\"/>",
                           x,
                           y_px(point.value - *point.sigma),
                           y_px(point.value + *point.sigma));
      }
      if (is_refused(point)) {
        out += fmt::format(
            "<path d=\"M{0:.2f} {2:.2f}L{1:.2f} {3:.2f}M{0:.2f} {3:.2f}L{1:.2f} {2:.2f}\" "
            "stroke=\"#d55e00\" stroke-width=\"2\"/>\n",
            x - kMark_px,
            x + kMark_px,
            y - kMark_px,
            y + kMark_px);
        continue;
      }
      const bool is_installed = point.verdict == LedgerVerdict::Installed;
      out += fmt::format(
          "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" fill=\"{}\" stroke=\"#0072b2\"/>\n",
          x,
          y,
          kMark_px,
          is_installed ? "#0072b2" : "#fff");
    }
    return out;
  }

 private:
  double x_px(double time_s) const {
    return kHistoryLeft_px + (kHistoryWidth_px - kHistoryLeft_px - kRight_px) *
                                 (time_s - time_s_.low) / (time_s_.high - time_s_.low);
  }
  /// Values beyond the frame stand on its edge.
  double y_px(double value) const {
    const double inside = std::clamp(value, value_.low, value_.high);
    return kHistoryHeight_px - kBottom_px -
           (kHistoryHeight_px - kHistoryTop_px - kBottom_px) * (inside - value_.low) /
               (value_.high - value_.low);
  }

  const LedgerSeries& series_;
  PlotRange time_s_;
  PlotRange value_;
};

}  // namespace

Expected<std::string> series_svg(const LedgerSeries& series,
                                 const LedgerKey& key,
                                 const std::string& parameter,
                                 const std::string& file) {
  if (series.points.empty()) {
    return failure({Code::LedgerEntryUnknown,
                    {file, 0, 0},
                    fmt::format("{} {} of {} with {}",
                                word(key.kind),
                                quoted(key.subject),
                                quoted(key.machine),
                                quoted(parameter)),
                    "the name of one of its parameters"});
  }
  const Plot plot(series);
  const std::string title = escaped(fmt::format(
      "{} of {} {}, {} [{}]", parameter, word(key.kind), key.subject, key.machine, series.unit));
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"sans-serif\" font-size=\"12\" role=\"img\" "
      "aria-label=\"{2}\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n"
      "<text x=\"{3}\" y=\"22\" font-size=\"15\">{2}</text>\n"
      "<text x=\"{3}\" y=\"40\" fill=\"#555\">filled: installed; hollow: measured only; cross: "
      "refused, on the edge if beyond it; bars: one sigma; times UTC</text>\n{4}{5}</svg>\n",
      kHistoryWidth_px,
      kHistoryHeight_px,
      title,
      kHistoryLeft_px,
      plot.axes(),
      plot.points());
}

}  // namespace panelcal::history
