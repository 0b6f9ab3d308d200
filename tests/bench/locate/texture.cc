// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <opencv2/core.hpp>

namespace panelcal::bench {
namespace {

constexpr int kBoardWidth = 640;
constexpr int kBoardHeight = 480;

/// Grey levels of 255 about the background.
cv::Mat bare_board(const Condition& condition, Random& random) {
  Condition texture = condition;
  texture.light_gradient = 0;
  Scene scene = draw_background(texture, Polarity::Bright, random);
  scene.weave.seed = static_cast<std::uint64_t>(random.uniform(0, 1e9));
  const Camera camera = make_camera(kBoardWidth, kBoardHeight, condition.blur_px, 0);
  const std::vector<double> levels = render_levels(scene, camera);
  cv::Mat board(kBoardHeight, kBoardWidth, CV_64F);
  std::copy(levels.begin(), levels.end(), board.begin<double>());
  board -= 255 * scene.background;
  return board;
}

cv::Mat transformed(const cv::Mat& padded) {
  cv::Mat spectrum;
  cv::dft(padded, spectrum, cv::DFT_COMPLEX_OUTPUT);
  return spectrum;
}

cv::Mat transformed_back(const cv::Mat& spectrum) {
  cv::Mat out;
  cv::dft(spectrum, out, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return out;
}

}  // namespace

Texture::Texture(const Condition& condition, int max_lag_px, int n, std::uint64_t seed)
    : max_lag_px_(max_lag_px) {
  const int side = 2 * max_lag_px + 1;
  covariance_.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0);
  const int rows = cv::getOptimalDFTSize(kBoardHeight + max_lag_px);
  const int columns = cv::getOptimalDFTSize(kBoardWidth + max_lag_px);
  cv::Mat power = cv::Mat::zeros(rows, columns, CV_64F);
  for (int i = 0; i < n; ++i) {
    Random random = Random(seed).fork(static_cast<std::uint64_t>(i));
    cv::Mat padded = cv::Mat::zeros(rows, columns, CV_64F);
    bare_board(condition, random).copyTo(padded(cv::Rect(0, 0, kBoardWidth, kBoardHeight)));
    const cv::Mat spectrum = transformed(padded);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        const auto& c = spectrum.at<cv::Vec2d>(y, x);
        power.at<double>(y, x) += (c[0] * c[0] + c[1] * c[1]) / n;
      }
    }
  }
  cv::Mat complex_power;
  const std::vector<cv::Mat> parts = {power, cv::Mat::zeros(rows, columns, CV_64F)};
  cv::merge(parts, complex_power);
  const cv::Mat sums = transformed_back(complex_power);
  for (int dy = -max_lag_px; dy <= max_lag_px; ++dy) {
    for (int dx = -max_lag_px; dx <= max_lag_px; ++dx) {
      const double overlap =
          static_cast<double>(kBoardWidth - std::abs(dx)) * (kBoardHeight - std::abs(dy));
      covariance_[index(dx, dy)] =
          sums.at<double>((dy + rows) % rows, (dx + columns) % columns) / overlap;
    }
  }
  embed();
}

Texture Texture::white(double sigma, int max_lag_px) {
  Texture texture;
  texture.max_lag_px_ = max_lag_px;
  const int side = 2 * max_lag_px + 1;
  texture.covariance_.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0);
  texture.covariance_[texture.index(0, 0)] = sigma * sigma;
  texture.embed();
  return texture;
}

double Texture::sigma() const {
  return std::sqrt(covariance(0, 0));
}

double Texture::covariance(int dx, int dy) const {
  return covariance_[index(dx, dy)];
}

std::size_t Texture::index(int dx, int dy) const {
  const auto side = static_cast<std::size_t>(2 * max_lag_px_ + 1);
  return static_cast<std::size_t>(dy + max_lag_px_) * side +
         static_cast<std::size_t>(dx + max_lag_px_);
}

void Texture::embed() {
  padded_ = cv::getOptimalDFTSize(2 * max_lag_px_ + 2);
  cv::Mat circulant = cv::Mat::zeros(padded_, padded_, CV_64F);
  for (int dy = -max_lag_px_; dy <= max_lag_px_; ++dy) {
    for (int dx = -max_lag_px_; dx <= max_lag_px_; ++dx) {
      circulant.at<double>((dy + padded_) % padded_, (dx + padded_) % padded_) = covariance(dx, dy);
    }
  }
  const cv::Mat eigenvalues = transformed(circulant);
  spectrum_.clear();
  for (int y = 0; y < padded_; ++y) {
    for (int x = 0; x < padded_; ++x) spectrum_.push_back(eigenvalues.at<cv::Vec2d>(y, x)[0]);
  }
}

Eigen::VectorXd Texture::times(const Eigen::VectorXd& v, int side_px) const {
  cv::Mat padded = cv::Mat::zeros(padded_, padded_, CV_64F);
  Eigen::Index i = 0;
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x, ++i) padded.at<double>(y, x) = v[i];
  }
  cv::Mat spectrum = transformed(padded);
  for (int y = 0; y < padded_; ++y) {
    for (int x = 0; x < padded_; ++x) {
      spectrum.at<cv::Vec2d>(y, x) *=
          spectrum_[static_cast<std::size_t>(y) * static_cast<std::size_t>(padded_) +
                    static_cast<std::size_t>(x)];
    }
  }
  const cv::Mat product = transformed_back(spectrum);
  Eigen::VectorXd out(v.size());
  i = 0;
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x, ++i) out[i] = product.at<double>(y, x);
  }
  return out;
}

}  // namespace panelcal::bench
