// SPDX-License-Identifier: Apache-2.0
#include "vision/texture/lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Cholesky>
#include <opencv2/core.hpp>

namespace panelcal::internal {
namespace {

constexpr int kCell = 4;  // px: waves shorter than two or three cells are no lines
constexpr std::size_t kMaxLines = 4;
/// A wave has to explain this part of what is left.
constexpr double kNoticeable = 0.15;
/// The spectrum is padded to at least this many times the window.
constexpr double kPadding = 2;
/// Waves longer than the window over this are the light's slope.
constexpr double kLongest = 1.2;

struct Cells {
  int width = 0;
  int height = 0;
  std::vector<float> mean;    ///< 0 where empty
  std::vector<float> weight;  ///< pixels
};

Cells cells_of(const FlatResiduals& r) {
  const int height = static_cast<int>(r.values.size()) / r.width;
  Cells cells{(r.width + kCell - 1) / kCell, (height + kCell - 1) / kCell, {}, {}};
  const auto n = static_cast<std::size_t>(cells.width) * static_cast<std::size_t>(cells.height);
  cells.mean.assign(n, 0);
  cells.weight.assign(n, 0);
  for (int y = 0; y < height; ++y) {
    const auto cell_row =
        static_cast<std::size_t>(y / kCell) * static_cast<std::size_t>(cells.width);
    for (int x = 0; x < r.width; ++x) {
      const float v = r.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(r.width) +
                               static_cast<std::size_t>(x)];
      if (v == 0) continue;
      const std::size_t i = cell_row + static_cast<std::size_t>(x / kCell);
      cells.mean[i] += v;
      ++cells.weight[i];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (cells.weight[i] > 0) cells.mean[i] /= cells.weight[i];
  }
  return cells;
}

Eigen::Vector2d cell_place(const Cells& cells, std::size_t i) {
  const auto x = static_cast<int>(i) % cells.width;
  const auto y = static_cast<int>(i) / cells.width;
  return {kCell * (x + 0.5) - 0.5, kCell * (y + 0.5) - 0.5};
}

double parabola_top(double left, double middle, double right) {
  const double curvature = left - 2 * middle + right;
  return curvature < 0 ? std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5) : 0;
}

/// The strongest wave of a picture of cells, rad per px; zero if there is none.
Eigen::Vector2d strongest_wave(const Cells& cells, const std::vector<float>& values) {
  const int width = cv::getOptimalDFTSize(static_cast<int>(kPadding * cells.width));
  const int height = cv::getOptimalDFTSize(static_cast<int>(kPadding * cells.height));
  cv::Mat padded = cv::Mat::zeros(height, width, CV_32F);
  for (int y = 0; y < cells.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(cells.width);
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t i = row + static_cast<std::size_t>(x);
      padded.at<float>(y, x) = values[i] * cells.weight[i];
    }
  }
  cv::Mat spectrum;
  cv::dft(padded, spectrum, cv::DFT_COMPLEX_OUTPUT, cells.height);
  const auto power = [&](int fx, int fy) {
    const auto c = spectrum.at<cv::Vec2f>((fy + height) % height, (fx + width) % width);
    return static_cast<double>(c[0]) * c[0] + static_cast<double>(c[1]) * c[1];
  };
  double best = 0;
  int best_x = 0;
  int best_y = 0;
  for (int fy = -height / 2 + 1; fy < height / 2; ++fy) {
    for (int fx = 0; fx < width / 2; ++fx) {
      if (fx == 0 && fy <= 0) continue;
      const double cycles = std::hypot(fx * static_cast<double>(cells.width) / width,
                                       fy * static_cast<double>(cells.height) / height);
      if (cycles < kLongest) continue;
      const double p = power(fx, fy);
      if (p > best) {
        best = p;
        best_x = fx;
        best_y = fy;
      }
    }
  }
  if (best == 0) return Eigen::Vector2d::Zero();
  const double x =
      best_x + parabola_top(power(best_x - 1, best_y), best, power(best_x + 1, best_y));
  const double y =
      best_y + parabola_top(power(best_x, best_y - 1), best, power(best_x, best_y + 1));
  return 2 * std::numbers::pi / kCell * Eigen::Vector2d(x / width, y / height);
}

/// Amplitudes of cos and sin of every wave, by least squares.
struct WaveFit {
  Eigen::VectorXd amplitudes;

  double amplitude(std::size_t k) const {
    return amplitudes.segment<2>(static_cast<Eigen::Index>(2 * k)).norm();
  }
};

WaveFit fit_waves(const Cells& cells, const std::vector<Eigen::Vector2d>& waves) {
  const auto n = static_cast<Eigen::Index>(2 * waves.size());
  Eigen::MatrixXd h = 1e-9 * Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd row(n);
  for (std::size_t i = 0; i < cells.mean.size(); ++i) {
    if (cells.weight[i] == 0) continue;
    const Eigen::Vector2d at = cell_place(cells, i);
    for (std::size_t k = 0; k < waves.size(); ++k) {
      const double phase = waves[k].dot(at);
      row[static_cast<Eigen::Index>(2 * k)] = std::cos(phase);
      row[static_cast<Eigen::Index>(2 * k + 1)] = std::sin(phase);
    }
    const double w = static_cast<double>(cells.weight[i]);
    h.selfadjointView<Eigen::Lower>().rankUpdate(row, w);
    g += w * static_cast<double>(cells.mean[i]) * row;
  }
  return {h.selfadjointView<Eigen::Lower>().ldlt().solve(g)};
}

double energy_of(const Cells& cells, const std::vector<float>& values) {
  double energy = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    energy += static_cast<double>(cells.weight[i] * values[i] * values[i]);
  }
  return energy;
}

std::vector<float> without_waves(const Cells& cells,
                                 const std::vector<Eigen::Vector2d>& waves,
                                 const Eigen::VectorXd& amplitudes) {
  std::vector<float> left = cells.mean;
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (cells.weight[i] == 0) continue;
    const Eigen::Vector2d at = cell_place(cells, i);
    for (std::size_t k = 0; k < waves.size(); ++k) {
      const double phase = waves[k].dot(at);
      left[i] -=
          static_cast<float>(amplitudes[static_cast<Eigen::Index>(2 * k)] * std::cos(phase) +
                             amplitudes[static_cast<Eigen::Index>(2 * k + 1)] * std::sin(phase));
    }
  }
  return left;
}

/// The waves by rows with a recurrence: a cosine for each pixel would cost more than the fit.
void subtract_waves(const std::vector<Eigen::Vector2d>& waves,
                    const Eigen::VectorXd& amplitudes,
                    const FlatResiduals& residuals,
                    std::vector<float>& left) {
  left.assign(residuals.values.begin(), residuals.values.end());
  const auto width = static_cast<std::size_t>(residuals.width);
  for (std::size_t k = 0; k < waves.size(); ++k) {
    const double a = amplitudes[static_cast<Eigen::Index>(2 * k)];
    const double b = amplitudes[static_cast<Eigen::Index>(2 * k + 1)];
    const double turn_c = std::cos(waves[k].x());
    const double turn_s = std::sin(waves[k].x());
    for (std::size_t y = 0; y * width < left.size(); ++y) {
      double c = std::cos(waves[k].y() * static_cast<double>(y));
      double s = std::sin(waves[k].y() * static_cast<double>(y));
      for (std::size_t x = 0; x < width; ++x) {
        float& v = left[y * width + x];
        if (v != 0) v -= static_cast<float>(a * c + b * s);
        const double next = c * turn_c - s * turn_s;
        s = s * turn_c + c * turn_s;
        c = next;
      }
    }
  }
}

}  // namespace

std::vector<TextureLine> texture_lines(const FlatResiduals& residuals, std::vector<float>& left) {
  const Cells cells = cells_of(residuals);
  std::vector<Eigen::Vector2d> waves;
  std::vector<float> values = cells.mean;
  double energy = energy_of(cells, values);
  while (waves.size() < kMaxLines) {
    const Eigen::Vector2d wave = strongest_wave(cells, values);
    if (wave.isZero()) break;
    waves.push_back(wave);
    const WaveFit next = fit_waves(cells, waves);
    std::vector<float> next_values = without_waves(cells, waves, next.amplitudes);
    const double next_energy = energy_of(cells, next_values);
    if (!(next_energy < (1 - kNoticeable) * energy)) {
      waves.pop_back();
      break;
    }
    values = std::move(next_values);
    energy = next_energy;
  }
  if (waves.empty()) {
    left.assign(residuals.values.begin(), residuals.values.end());
    return {};
  }
  const WaveFit fit = fit_waves(cells, waves);
  subtract_waves(waves, fit.amplitudes, residuals, left);
  std::vector<TextureLine> lines;
  for (std::size_t k = 0; k < waves.size(); ++k) lines.push_back({waves[k], fit.amplitude(k)});
  return lines;
}

}  // namespace panelcal::internal
