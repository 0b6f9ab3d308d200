// SPDX-License-Identifier: Apache-2.0
#include "vision/template/equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/LU>

namespace panelcal::internal {
namespace {

/// The template's outermost pixels do not take part, so that small steps stay inside of it.
constexpr double kMarginPx = 2;
constexpr double kMinTemplateSigma = 1e-6;  // of the prior: what is meant to be fixed

Eigen::Matrix2d template_rotation(double angle) {
  Eigen::Matrix2d r;
  r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return r;
}

struct Box {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
};

/// Box of the template in the picture; empty if the lens model does not reach it.
std::optional<Box> template_box(const FitFrame& fit_frame,
                                const TemplateModel& model,
                                const TemplateMap& map) {
  Box box;
  for (const Eigen::Vector2d& corner : model.corners()) {
    const auto u = fit_frame.to_image(map.to_frame(corner));
    if (!u || !u->allFinite()) return std::nullopt;
    box.low = box.low.cwiseMin(*u);
    box.high = box.high.cwiseMax(*u);
  }
  return box;
}

double mean_of(const Image& image, int x0, int y0, int factor) {
  double sum = 0;
  for (int y = y0; y < y0 + factor; ++y) {
    for (int x = x0; x < x0 + factor; ++x) sum += image.at(x, y);
  }
  return sum / (factor * factor);
}

}  // namespace

TemplateMap::TemplateMap(const TemplateModel& model, const TemplateVector& p)
    : place_(p.head<2>()), reference_(model.reference) {
  const double scale = model.pitch * std::exp(p[kLogScale]);
  const Eigen::DiagonalMatrix<double, 2> flip(1, model.y_sign);
  frame_from_px_ = scale * template_rotation(p[kTurn]) * flip;
  px_from_frame_ = 1 / scale * (flip * template_rotation(-p[kTurn]));
  Eigen::Matrix2d quarter;
  quarter << 0, 1, -1, 0;
  turn_ = flip * quarter * flip;
}

Eigen::Matrix<double, 2, 4> TemplateMap::derivative(const Eigen::Vector2d& t) const {
  const Eigen::Vector2d from_reference = t - reference_;
  Eigen::Matrix<double, 2, 4> d;
  d.leftCols<2>() = -px_from_frame_;
  d.col(kTurn) = turn_ * from_reference;
  d.col(kLogScale) = -from_reference;
  return d;
}

TemplateWindow make_template_window(const Image& image,
                                    const FitFrame& fit_frame,
                                    const TemplateModel& model,
                                    const TemplateVector& pose,
                                    int level) {
  TemplateWindow window;
  window.level = level;
  const TemplateMap map(model, pose);
  window.middle = map.to_frame(model.middle());
  window.unit = 0.5 * model.pitch * std::max(model.width(), model.height());
  window.seen_share = 0;
  const auto box = template_box(fit_frame, model, map);
  if (!box) return window;

  const int factor = 1 << level;
  const auto cell = [&](double v, int end) {
    return static_cast<int>(std::clamp(std::floor(v), 0.0, static_cast<double>(end)) / factor);
  };
  const int n_columns = image.width() / factor;
  const int n_rows = image.height() / factor;
  const int i0 = cell(box->low.x(), image.width());
  const int j0 = cell(box->low.y(), image.height());
  const int i1 = std::min(cell(box->high.x() + factor, image.width()) + 1, n_columns);
  const int j1 = std::min(cell(box->high.y() + factor, image.height()) + 1, n_rows);
  const double margin = kMarginPx * factor;
  for (int j = j0; j < j1; ++j) {
    for (int i = i0; i < i1; ++i) {
      const Eigen::Vector2d u((i + 0.5) * factor - 0.5, (j + 0.5) * factor - 0.5);
      TemplatePixel pixel;
      pixel.at = fit_frame.from_image(u);
      const Eigen::Vector2d t = map.to_template(pixel.at);
      if (!(t.x() >= margin - 0.5 && t.x() <= model.width() - 0.5 - margin)) continue;
      if (!(t.y() >= margin - 0.5 && t.y() <= model.height() - 0.5 - margin)) continue;
      pixel.plane << 1, (pixel.at - window.middle) / window.unit;
      pixel.value = mean_of(image, i * factor, j * factor, factor);
      pixel.x = i;
      pixel.y = j;
      window.pixels.push_back(pixel);
    }
  }
  window.x0 = i0;
  window.y0 = j0;
  window.width = std::max(0, i1 - i0);
  window.height = std::max(0, j1 - j0);
  // As many pixels as the template without its margin has, if all of it is in the picture.
  const double cells = (model.width() - 2 * margin) * (model.height() - 2 * margin) *
                       std::pow(model.pitch * std::exp(pose[kLogScale]) / factor, 2) /
                       std::abs(fit_frame.jacobian(0.5 * (box->low + box->high)).determinant());
  window.seen_share =
      std::min(1.0, static_cast<double>(window.pixels.size()) / std::max(1.0, cells));
  return window;
}

std::optional<TemplateValue> evaluate(const TemplateModel& model,
                                      const TemplateWindow& window,
                                      const TemplateMap& map,
                                      const TemplatePixel& pixel,
                                      const TemplateVector& p,
                                      bool with_row) {
  const double factor = 1 << window.level;
  const SplineImage& smooth = model.level(window.level);
  TemplateValue value;
  const Eigen::Vector2d t = map.to_template(pixel.at);
  value.at = (t.array() + 0.5) / factor - 0.5;
  if (!smooth.covers(value.at)) return std::nullopt;
  const SplineWeights wx(value.at.x());
  const SplineWeights wy(value.at.y());
  const SplineValue s = smooth(wx, wy);
  const double plane = pixel.plane.dot(p.segment<3>(kLevel));
  value.gain = pixel.plane.dot(p.segment<3>(kGain));
  value.smooth_level = plane + value.gain * s.value;
  const Eigen::Matrix<double, 2, 4> d = map.derivative(t);
  Eigen::Vector2d of_focus = Eigen::Vector2d::Zero();
  TemplateVector& row = value.smooth_row;
  row[kFocus] = 0;
  if (window.level == 0) {
    const SplineValue c = model.curvature(wx, wy);
    value.smooth_level += p[kFocus] * c.value;
    row[kFocus] = c.value;
    of_focus = p[kFocus] * Eigen::Vector2d(c.dx, c.dy);
  }
  value.slope = value.gain / factor * Eigen::Vector2d(s.dx, s.dy) + of_focus;
  row.head<4>() = d.transpose() * value.slope;
  row.segment<3>(kLevel) = pixel.plane;
  row.segment<3>(kGain) = s.value * pixel.plane;
  value.level = value.smooth_level;
  if (window.level == 0) {
    const SplineValue r = model.raw(wx, wy);
    value.level += value.gain * (r.value - s.value);
    if (with_row) {
      value.row = row;
      value.row.head<4>() += value.gain * d.transpose() * Eigen::Vector2d(r.dx - s.dx, r.dy - s.dy);
      value.row.segment<3>(kGain) = r.value * pixel.plane;
    }
  }
  return value;
}

TemplateVector TemplatePrior::information() const {
  TemplateVector information = TemplateVector::Zero();
  information[kTurn] = std::pow(std::max(turn_sigma, kMinTemplateSigma), -2);
  information[kLogScale] = std::pow(std::max(log_scale_sigma, kMinTemplateSigma), -2);
  return information;
}

TemplateVector TemplatePrior::pull(const TemplateVector& p) const {
  TemplateVector off = TemplateVector::Zero();
  off[kTurn] = turn - p[kTurn];
  off[kLogScale] = -p[kLogScale];
  return information().cwiseProduct(off);
}

}  // namespace panelcal::internal
