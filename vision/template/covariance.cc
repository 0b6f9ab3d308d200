// SPDX-License-Identifier: Apache-2.0
#include "vision/template/covariance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "vision/template/noise.h"
#include "vision/texture/spectrum.h"
#include <Eigen/LU>
#include <opencv2/core.hpp>

namespace panelcal::internal {
namespace {

constexpr double kGreyRounding = 0.2887;  // sigma of rounding to whole levels
constexpr int kTestLag = 3;
constexpr int kMaxTemplateLag = 24;
constexpr int kFewPairs = 30;

using Influence = Eigen::Vector4d;

/// Mean that the template's noise adds to J_smooth J_raw^T on average: it has slopes as well, but
/// they tell nothing of the place.
TemplateMatrix noise_of_rows(const TemplateModel& model,
                             const TemplateMap& map,
                             const TemplateNoiseTable& table,
                             const TemplatePixel& pixel,
                             const TemplateValue& value) {
  const auto& x = table(value.at.x());
  const auto& y = table(value.at.y());
  const double share = model.structure.at(static_cast<int>(value.at.x() + 0.5),
                                          static_cast<int>(value.at.y() + 0.5));
  const double variance = share * model.noise * model.noise;
  const Eigen::Vector2d slopes(x.slope_slope * y.raw_smooth, x.raw_smooth * y.slope_slope);
  const Eigen::Matrix<double, 2, 4> d = value.gain * map.derivative(value.at);
  TemplateMatrix m = TemplateMatrix::Zero();
  m.topLeftCorner<4, 4>() = variance * d.transpose() * slopes.asDiagonal() * d;
  m.block<3, 3>(kGain, kGain) =
      variance * x.raw_smooth * y.raw_smooth * pixel.plane * pixel.plane.transpose();
  // The curvature is a sum of two second differences.
  m(kFocus, kFocus) =
      variance * (x.curvature_curvature * y.raw_smooth + x.raw_smooth * y.curvature_curvature +
                  2 * x.raw_curvature * y.raw_curvature);
  return m;
}

/// a_u of every pixel of the window, zero for those that do not take part.
std::vector<Influence> influences(const TemplateProblem& problem, const TemplateVector& p) {
  const TemplateMap map(problem.model, p);
  const TemplateNoiseTable table;
  TemplateMatrix m = problem.prior.information().asDiagonal();
  std::vector<TemplateVector> rows(problem.window.pixels.size(), TemplateVector::Zero());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TemplatePixel& pixel = problem.window.pixels[i];
    const auto value = evaluate(problem.model, problem.window, map, pixel, p, true);
    if (!value || !takes_part(pixel, value->smooth_level, problem.full_scale)) continue;
    rows[i] = pixel.weight * value->smooth_row;
    m += rows[i] * value->row.transpose() -
         pixel.weight * noise_of_rows(problem.model, map, table, pixel, *value);
  }
  const Eigen::Matrix<double, 4, kTemplateParameters> inverse =
      m.fullPivLu().inverse().topRows<kPoseParameters>();
  std::vector<Influence> result(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) result[i] = inverse * rows[i];
  return result;
}

/// The sum over template pixels k of b_k b_k^T.
Eigen::Matrix4d template_share(const TemplateProblem& problem,
                               const TemplateVector& p,
                               const std::vector<Influence>& influence) {
  const TemplateModel& model = problem.model;
  const TemplateMap map(model, p);
  std::array<Raster, kPoseParameters> b;
  for (Raster& raster : b) raster = Raster(model.width(), model.height());
  for (std::size_t i = 0; i < influence.size(); ++i) {
    if (influence[i].isZero(0)) continue;
    const TemplatePixel& pixel = problem.window.pixels[i];
    const Eigen::Vector2d t = map.to_template(pixel.at);
    if (!model.raw.covers(t)) continue;
    const Influence by_gain = pixel.plane.dot(p.segment<3>(kGain)) * influence[i];
    const SplineWeights wx(t.x());
    const SplineWeights wy(t.y());
    for (int j = 0; j < 4; ++j) {
      for (int k = 0; k < 4; ++k) {
        const double w =
            wy.value[static_cast<std::size_t>(j)] * wx.value[static_cast<std::size_t>(k)];
        const std::size_t at = b[0].index(wx.first + k, wy.first + j);
        for (int q = 0; q < kPoseParameters; ++q)
          b[static_cast<std::size_t>(q)].values[at] += w * by_gain[q];
      }
    }
  }
  for (Raster& raster : b) raster = spline_coefficients(raster);
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (std::size_t k = 0; k < b[0].values.size(); ++k) {
    const Influence at(b[0].values[k], b[1].values[k], b[2].values[k], b[3].values[k]);
    sum += at * at.transpose();
  }
  return sum;
}

/// Residuals and where they are, as pictures.
struct ResidualPicture {
  cv::Mat residual;
  cv::Mat mask;
  double sum_of_squares = 0;
  double n = 0;
};

ResidualPicture residual_picture(const TemplateProblem& problem, const TemplateVector& p) {
  const TemplateWindow& window = problem.window;
  const TemplateMap map(problem.model, p);
  ResidualPicture out{cv::Mat::zeros(window.height, window.width, CV_32F),
                      cv::Mat::zeros(window.height, window.width, CV_32F)};
  for (const TemplatePixel& pixel : window.pixels) {
    const auto value = evaluate(problem.model, window, map, pixel, p, false);
    if (!value || !takes_part(pixel, value->smooth_level, problem.full_scale)) continue;
    const double residual = pixel.value - value->level;
    const cv::Point at(pixel.x - window.x0, pixel.y - window.y0);
    out.residual.at<float>(at) = static_cast<float>(residual);
    out.mask.at<float>(at) = 1;
    out.sum_of_squares += residual * residual;
    ++out.n;
  }
  return out;
}

double sum_at_lag(const cv::Mat& a, int dx, int dy) {
  const int width = a.cols - std::abs(dx);
  const int height = a.rows - dy;
  if (width <= 0 || height <= 0) return 0;
  const cv::Mat first = a(cv::Rect(dx < 0 ? -dx : 0, 0, width, height));
  const cv::Mat second = a(cv::Rect(dx < 0 ? 0 : dx, dy, width, height));
  return first.dot(second);
}

/// Portmanteau test on short lags (Box and Pierce 1970), in two dimensions. The correlation of
/// neighbours that interpolating the template's noise brings may be as large as `allowed`.
bool is_textured(const ResidualPicture& picture, double allowed) {
  const double variance = picture.sum_of_squares / std::max(1.0, picture.n);
  double statistic = 0;
  int n_lags = 0;
  for (int dy = 0; dy <= kTestLag; ++dy) {
    for (int dx = dy == 0 ? 1 : -kTestLag; dx <= kTestLag; ++dx) {
      const double n_pairs = sum_at_lag(picture.mask, dx, dy);
      if (n_pairs < kFewPairs) continue;
      const double rho = std::abs(sum_at_lag(picture.residual, dx, dy)) / variance / n_pairs;
      const bool is_near = std::abs(dx) <= 1 && dy <= 1;
      const double excess = std::max(0.0, rho - (is_near ? allowed : 0.3 * allowed));
      statistic += n_pairs * excess * excess;
      ++n_lags;
    }
  }
  return statistic > n_lags + 5 * std::sqrt(2.0 * n_lags) + 5;
}

/// sum_u,v a_u R(u - v) a_v^T with the residuals' own tapered autocovariance.
Eigen::Matrix4d textured_covariance(const TemplateProblem& problem,
                                    const std::vector<Influence>& influence,
                                    const ResidualPicture& picture) {
  const TemplateWindow& window = problem.window;
  const cv::Size padded = padded_size(picture.mask, kMaxTemplateLag);
  std::array<cv::Mat, kPoseParameters> spectra;
  for (int q = 0; q < kPoseParameters; ++q) {
    cv::Mat a = cv::Mat::zeros(window.height, window.width, CV_32F);
    // Scaled to one: influences are small numbers, which float sums would lose.
    for (std::size_t i = 0; i < influence.size(); ++i) {
      const TemplatePixel& pixel = window.pixels[i];
      a.at<float>(pixel.y - window.y0, pixel.x - window.x0) = static_cast<float>(influence[i][q]);
    }
    spectra[static_cast<std::size_t>(q)] = spectrum_of(a, padded);
  }
  const cv::Mat residual = spectrum_of(picture.residual, padded);
  const cv::Mat mask = spectrum_of(picture.mask, padded);
  const cv::Mat sums = correlation_of(residual, residual);
  const cv::Mat pairs = correlation_of(mask, mask);
  Eigen::Matrix4d cov = Eigen::Matrix4d::Zero();
  for (int q = 0; q < kPoseParameters; ++q) {
    for (int r = 0; r <= q; ++r) {
      const cv::Mat lags = correlation_of(spectra[static_cast<std::size_t>(q)],
                                          spectra[static_cast<std::size_t>(r)]);
      for (int dy = -kMaxTemplateLag; dy <= kMaxTemplateLag; ++dy) {
        for (int dx = -kMaxTemplateLag; dx <= kMaxTemplateLag; ++dx) {
          const double n = at_lag(pairs, dx, dy);
          const double lag = std::hypot(dx, dy) / kMaxTemplateLag;
          if (lag >= 1 || n < 0.02 * picture.n + kFewPairs) continue;
          const double taper = 0.5 * (1 + std::cos(CV_PI * lag));
          cov(q, r) += taper * at_lag(sums, dx, dy) / n * at_lag(lags, dx, dy);
        }
      }
      cov(r, q) = cov(q, r);
    }
  }
  return cov;
}

bool is_covariance(const Eigen::Matrix4d& cov) {
  return cov.allFinite() && cov.diagonal().minCoeff() > 0 &&
         cov.topLeftCorner<2, 2>().determinant() > 0;
}

}  // namespace

TemplateNoise template_noise(const TemplateProblem& problem,
                             const TemplateVector& p,
                             double white_noise) {
  const TemplateNoiseTable kept;
  const TemplateMap map(problem.model, p);
  double sum = 0;
  double sum_template = 0;
  double n = 0;
  for (const TemplatePixel& pixel : problem.window.pixels) {
    const auto value = evaluate(problem.model, problem.window, map, pixel, p, false);
    if (!value || !takes_part(pixel, value->smooth_level, problem.full_scale)) continue;
    const double residual = pixel.value - value->level;
    sum += residual * residual;
    sum_template += std::pow(value->gain * problem.model.noise, 2) * kept(value->at.x()).raw_raw *
                    kept(value->at.y()).raw_raw;
    ++n;
  }
  const double variance = sum / std::max(1.0, n - int(kTemplateParameters));
  const double of_template = sum_template / std::max(1.0, n);
  TemplateNoise noise;
  noise.all = std::max(kGreyRounding, std::sqrt(variance));
  // The difference of two large numbers may come out as nearly nothing.
  constexpr double kOfWhite = 0.8;
  const double least =
      std::max(kGreyRounding * kGreyRounding, kOfWhite * white_noise * white_noise);
  noise.picture = std::sqrt(std::max(variance - of_template, least));
  return noise;
}

Eigen::Matrix4d template_covariance(const TemplateProblem& problem,
                                    const TemplateVector& p,
                                    const TemplateNoise& noise) {
  const std::vector<Influence> influence = influences(problem, p);
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const Influence& a : influence) sum += a * a.transpose();
  const double sigma = problem.model.noise;
  const Eigen::Matrix4d white =
      noise.picture * noise.picture * sum + sigma * sigma * template_share(problem, p, influence);
  const ResidualPicture picture = residual_picture(problem, p);
  const double share = 1 - std::pow(noise.picture / noise.all, 2);
  if (!is_textured(picture, 0.5 * std::max(0.0, share))) return white;
  const Eigen::Matrix4d textured = textured_covariance(problem, influence, picture);
  if (!is_covariance(textured)) return white;
  const bool is_larger =
      textured.topLeftCorner<2, 2>().trace() > white.topLeftCorner<2, 2>().trace();
  return is_larger ? textured : white;
}

}  // namespace panelcal::internal
