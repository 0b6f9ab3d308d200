// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "tools/figures/svg.h"
#include "tools/figures/text.h"
#include "tools/nightly/figures.h"
#include <fmt/format.h>

namespace panelcal::nightly {
namespace {

constexpr double kWarmUpWidth = 560;
constexpr double kWarmUpHeight = 230;
constexpr double kWarmUpLeft = 58;
constexpr double kWarmUpRight = 16;
constexpr double kWarmUpTop = 14;
constexpr double kWarmUpBottom = 34;
constexpr double kMinute_s = 60;
constexpr int kCurvePoints = 100;
constexpr double kUm = 1e3;

/// Figure of the mark's distance from its warm place over time.
class WarmUpFigure {
 public:
  explicit WarmUpFigure(const NightWarmUp& seen) : seen_(seen) {
    warm_mm_ = seen.fit ? seen.fit->warm : seen.looks.back().value;
    end_s_ = std::max(1.0, seen.looks.back().since_start.in_s());
    high_um_ = kUm * seen.limit.in_mm();
    for (const WarmUpSample& look : seen.looks) {
      for (const double off_mm : look.value - warm_mm_) {
        high_um_ = std::max(high_um_, kUm * (std::abs(off_mm) + look.sigma));
      }
    }
    high_um_ *= 1.08;
  }

  std::string draw() const {
    return fmt::format(
               "<svg class=\"drift\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" "
               "role=\"img\" aria-label=\"The mark while the machine warmed up\">\n",
               kWarmUpWidth,
               kWarmUpHeight) +
           limit() + axes() + curve(0) + curve(1) + looks(0, "dot") + looks(1, "ring") + warm() +
           "</svg>\n";
  }

 private:
  double x(double t_s) const {
    return kWarmUpLeft + (kWarmUpWidth - kWarmUpLeft - kWarmUpRight) * t_s / end_s_;
  }
  double y(double off_um) const {
    const double inside = std::clamp(off_um, -high_um_, high_um_);
    return kWarmUpTop +
           (kWarmUpHeight - kWarmUpTop - kWarmUpBottom) * 0.5 * (1 - inside / high_um_);
  }

  std::string limit() const {
    const double limit_um = kUm * seen_.limit.in_mm();
    return fmt::format(
        "<rect class=\"band\" x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.1f}\"/>\n",
        kWarmUpLeft,
        y(limit_um),
        kWarmUpWidth - kWarmUpLeft - kWarmUpRight,
        y(-limit_um) - y(limit_um));
  }

  std::string axes() const {
    const double step = report::nice_below(2 * high_um_ / 3);
    const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
    std::string out;
    const auto n = static_cast<int>(std::floor(high_um_ / step));
    for (int i = -n; i <= n; ++i) {
      out += fmt::format(
          "<path class=\"grid\" d=\"M{} {:.1f}H{}\"/><text class=\"end\" x=\"{}\" "
          "y=\"{:.1f}\">{}</text>\n",
          kWarmUpLeft,
          y(i * step),
          kWarmUpWidth - kWarmUpRight,
          kWarmUpLeft - 5,
          y(i * step) + 4,
          i == 0 ? "0" : report::fixed_signed(i * step, decimals));
    }
    return out + fmt::format(
                     "<rect class=\"frame\" x=\"{0}\" y=\"{1}\" width=\"{2}\" height=\"{3}\"/>\n"
                     "<text x=\"{0}\" y=\"{4}\">0 min</text>"
                     "<text class=\"end\" x=\"{5}\" y=\"{4}\">{6} min</text>"
                     "<text class=\"mid\" transform=\"translate(12 {7}) rotate(-90)\">from warm, "
                     "um</text>\n",
                     kWarmUpLeft,
                     kWarmUpTop,
                     kWarmUpWidth - kWarmUpLeft - kWarmUpRight,
                     kWarmUpHeight - kWarmUpTop - kWarmUpBottom,
                     kWarmUpHeight - kWarmUpBottom + 18,
                     kWarmUpWidth - kWarmUpRight,
                     report::fixed(end_s_ / kMinute_s, 1),
                     (kWarmUpTop + kWarmUpHeight - kWarmUpBottom) / 2);
  }

  std::string curve(Eigen::Index axis) const {
    if (!seen_.fit || !seen_.fit->is_seen) return {};
    std::string path;
    for (int i = 0; i <= kCurvePoints; ++i) {
      const double t_s = end_s_ * i / kCurvePoints;
      const double off_um =
          kUm * seen_.fit->cold_offset[axis] * std::exp(-t_s / seen_.fit->time_constant.in_s());
      path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", x(t_s), y(off_um));
    }
    return fmt::format("<path class=\"force\" d=\"{}\"/>\n", path);
  }

  std::string looks(Eigen::Index axis, std::string_view css) const {
    std::string out;
    for (const WarmUpSample& look : seen_.looks) {
      const double off_um = kUm * (look.value[axis] - warm_mm_[axis]);
      const double at = x(look.since_start.in_s());
      out += fmt::format(
          "<path class=\"night\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/>"
          "<circle class=\"{3}\" cx=\"{0:.1f}\" cy=\"{4:.1f}\" r=\"2.4\"/>\n",
          at,
          y(off_um - kUm * look.sigma),
          y(off_um + kUm * look.sigma),
          css,
          y(off_um));
    }
    return out;
  }

  std::string warm() const {
    if (!seen_.is_warm || !seen_.fit->is_seen) return {};
    return fmt::format("<path class=\"fresh\" d=\"M{:.1f} {}V{}\"/>\n",
                       x(seen_.fit->wait.in_s()),
                       kWarmUpTop,
                       kWarmUpHeight - kWarmUpBottom);
  }

  const NightWarmUp& seen_;
  Eigen::VectorXd warm_mm_;
  double end_s_ = 1;
  double high_um_ = 1;
};

}  // namespace

std::string warm_up_figure(const NightWarmUp& seen) {
  if (seen.looks.size() < 2) return {};
  return "<figure>\n" + WarmUpFigure(seen).draw() +
         "<figcaption><b>The mark while the machine warmed up</b>, x filled and y open, with the "
         "fit; the band is the limit, the dashed line where the fit is below it.</figcaption>"
         "</figure>\n";
}

}  // namespace panelcal::nightly
