// SPDX-License-Identifier: Apache-2.0
#include "vision/template/search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vision/fit/frame.h"
#include "vision/fit/local_maxima.h"
#include "vision/picture/cv_bridge.h"
#include "vision/template/equations.h"
#include "vision/texture/spectrum.h"
#include <Eigen/LU>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

constexpr double kFewCells = 16;
constexpr double kMinTemplateCorrelation = 0.4;
constexpr double kOfBest = 0.6;        // sightings this much worse than the best do not matter
constexpr double kSameTemplate = 0.3;  // of the template's smaller side
constexpr double kStepCells = 1.5;     // move of the template's corner from step to step
constexpr double kBeyond = 0.35;   // of the template's larger side may be outside of the picture
constexpr double kFaintest = 0.5;  // grey levels of 255: flatter is flat
constexpr int kMaxSteps = 4000;    // of turn times scale

/// The template turned and scaled, on the cells of the averaged picture.
struct Stencil {
  cv::Mat level;  ///< mean 0, sum of squares 1
  cv::Mat mask;
  double n = 0;
  Eigen::Vector2d middle;     ///< of the template, cells from the first one
  Eigen::Vector2d reference;  ///< the same of the reference
  double turn = 0;
  double log_scale = 0;
};

cv::Mat averaged_picture(const Image& image, const PixelBox& box, int factor) {
  const cv::Size size(box.width / factor, box.height / factor);
  if (size.empty()) return {};
  const cv::Rect part(box.x0, box.y0, size.width * factor, size.height * factor);
  cv::Mat cells;
  cv::resize(pixels_of(image)(part), cells, size, 0, 0, cv::INTER_AREA);
  return cells;
}

/// In     px_from_frame: the frame's local scale; factor: px per cell
Stencil make_stencil(const TemplateModel& model,
                     const Eigen::Matrix2d& px_from_frame,
                     int level,
                     double turn,
                     double log_scale) {
  const int factor = 1 << level;
  TemplateVector p = TemplateVector::Zero();
  p[kTurn] = turn;
  p[kLogScale] = log_scale;
  const TemplateMap map(model, p);
  const Eigen::Vector2d half(0.5 * model.width(), 0.5 * model.height());
  const Eigen::Vector2d middle_t = model.middle();
  const Eigen::Vector2d middle = px_from_frame * map.to_frame(middle_t);
  Eigen::Vector2d reach = Eigen::Vector2d::Zero();
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector2d corner = middle_t + Eigen::Vector2d(half.x(), side * half.y());
    reach = reach.cwiseMax((px_from_frame * map.to_frame(corner) - middle).cwiseAbs());
  }
  const int columns = 2 * static_cast<int>(std::ceil(reach.x() / factor)) + 1;
  const int rows = 2 * static_cast<int>(std::ceil(reach.y() / factor)) + 1;
  Stencil s{cv::Mat::zeros(rows, columns, CV_32F),
            cv::Mat::zeros(rows, columns, CV_32F),
            0,
            {},
            {},
            turn,
            log_scale};
  s.middle << columns / 2, rows / 2;
  s.reference = s.middle - middle / factor;
  const Eigen::Matrix2d frame_from_px = px_from_frame.inverse();
  const SplineImage& spline = model.level(level);
  double sum = 0;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const Eigen::Vector2d offset_px = factor * (Eigen::Vector2d(x, y) - s.middle);
      const Eigen::Vector2d t = map.to_template(frame_from_px * (middle + offset_px));
      if (!(((t - middle_t).cwiseAbs() - half).maxCoeff() < -0.5 * factor)) continue;
      const double value = spline((t.array() + 0.5) / factor - 0.5).value;
      s.level.at<float>(y, x) = static_cast<float>(value);
      s.mask.at<float>(y, x) = 1;
      sum += value;
      ++s.n;
    }
  }
  s.level -= sum / std::max(1.0, s.n) * s.mask;
  const double norm = cv::norm(s.level);
  if (norm > 0) s.level /= norm;
  return s;
}

/// The picture's cells with a margin, and the spectra that all stencils need.
struct SearchPicture {
  cv::Size padded;
  cv::Mat value;   ///< spectrum
  cv::Mat square;  ///< spectrum of the squared values
  int margin_x = 0;
  int margin_y = 0;
  int columns = 0;  ///< with margins
  int rows = 0;

  SearchPicture(const cv::Mat& cells, int stencil_columns, int stencil_rows) {
    margin_x = static_cast<int>(kBeyond * stencil_columns);
    margin_y = static_cast<int>(kBeyond * stencil_rows);
    cv::Mat padded_cells;
    cv::copyMakeBorder(
        cells, padded_cells, margin_y, margin_y, margin_x, margin_x, cv::BORDER_REPLICATE);
    // Numbers near zero lose less in the variances' differences.
    padded_cells -= cv::mean(padded_cells)[0];
    columns = padded_cells.cols;
    rows = padded_cells.rows;
    padded = {cv::getOptimalDFTSize(columns + stencil_columns),
              cv::getOptimalDFTSize(rows + stencil_rows)};
    value = spectrum_of(padded_cells, padded);
    square = spectrum_of(padded_cells.mul(padded_cells), padded);
  }
};

/// Correlation at every place of the stencil's first cell.
cv::Mat correlate(const SearchPicture& picture,
                  const Stencil& stencil,
                  double sign,
                  double faintest) {
  const cv::Mat level = spectrum_of(stencil.level, picture.padded);
  const cv::Mat mask = spectrum_of(stencil.mask, picture.padded);
  const cv::Mat products = correlation_of(level, picture.value);
  const cv::Mat sums = correlation_of(mask, picture.value);
  const cv::Mat squares = correlation_of(mask, picture.square);
  const int columns = picture.columns - stencil.level.cols + 1;
  const int rows = picture.rows - stencil.level.rows + 1;
  if (columns <= 0 || rows <= 0) return {};
  cv::Mat result(rows, columns, CV_32F);
  const float n = static_cast<float>(stencil.n);
  const float least = static_cast<float>(stencil.n * faintest * faintest);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const float sum = sums.at<float>(y, x);
      const float spread = std::max(least, squares.at<float>(y, x) - sum * sum / n);
      result.at<float>(y, x) =
          static_cast<float>(sign) * products.at<float>(y, x) / std::sqrt(spread);
    }
  }
  return result;
}

struct Peak {
  TemplateSighting sighting;
  Eigen::Vector2d middle_px;
};

/// Adds a map's local maxima; all of them, since other turns may beat them.
void collect_peaks(const cv::Mat& map,
                   const Stencil& stencil,
                   const SearchPicture& picture,
                   const PixelBox& box,
                   int factor,
                   std::vector<Peak>& peaks) {
  const auto to_px = [&](const Eigen::Vector2d& cell) -> Eigen::Vector2d {
    return Eigen::Vector2d(box.x0, box.y0) + (factor * (cell.array() + 0.5) - 0.5).matrix();
  };
  for (const cv::Point& at : local_maxima(map, kMinTemplateCorrelation)) {
    const Eigen::Vector2d first(at.x - picture.margin_x, at.y - picture.margin_y);
    peaks.push_back(
        {{to_px(first + stencil.reference), stencil.turn, stencil.log_scale, map.at<float>(at)},
         to_px(first + stencil.middle)});
  }
}

/// The best peaks that are not the same mark; `same`: px.
std::vector<TemplateSighting> distinct(std::vector<Peak> peaks, double same, int max_sightings) {
  std::stable_sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) {
    return a.sighting.correlation > b.sighting.correlation;
  });
  std::vector<Peak> best;
  for (const Peak& peak : peaks) {
    if (peak.sighting.correlation < kOfBest * peaks.front().sighting.correlation) break;
    // The same mark turned otherwise is another candidate if that moves its reference.
    const bool is_new = std::ranges::none_of(best, [&](const Peak& other) {
      return (other.middle_px - peak.middle_px).norm() < same &&
             (other.sighting.at_px - peak.sighting.at_px).norm() < same;
    });
    if (is_new) best.push_back(peak);
    if (static_cast<int>(best.size()) >= max_sightings) break;
  }
  std::vector<TemplateSighting> sightings;
  for (const Peak& peak : best) sightings.push_back(peak.sighting);
  return sightings;
}

/// n middles of equal parts of -tolerance .. tolerance.
std::vector<double> steps(double tolerance, double step) {
  const int n = std::max(1, static_cast<int>(std::ceil(2 * tolerance / step)));
  std::vector<double> values;
  for (int i = 0; i < n; ++i) values.push_back(tolerance * ((2 * i + 1.0) / n - 1));
  return values;
}

}  // namespace

int search_level(const TemplateModel& model) {
  const double side = std::sqrt(static_cast<double>(model.width()) * model.height());
  int level = 0;
  while (level < static_cast<int>(model.reduced.size()) && side / (2 << level) >= kFewCells)
    ++level;
  return level;
}

std::vector<TemplateSighting> search_template(const Image& image,
                                              const PixelBox& box,
                                              const TemplateModel& model,
                                              const CameraMapping* mapping,
                                              const TemplateRange& range,
                                              int max_sightings) {
  const int level = search_level(model);
  const int factor = 1 << level;
  const cv::Mat cells = averaged_picture(image, box, factor);
  if (cells.empty()) return {};
  const Eigen::Vector2d box_middle(box.x0 + 0.5 * box.width, box.y0 + 0.5 * box.height);
  const Eigen::Matrix2d px_from_frame =
      FitFrame(mapping, box_middle).jacobian(box_middle).inverse();
  const double scale_px = model.pitch * std::sqrt(std::abs(px_from_frame.determinant()));
  const double corner = 0.5 * std::hypot(model.width(), model.height()) * scale_px / factor;
  const double step = kStepCells / corner;
  const std::vector<double> turns = steps(range.turn_tolerance, step);
  const std::vector<double> scales = steps(range.log_scale_tolerance, step);
  const int side =
      2 * static_cast<int>(std::ceil(corner * std::exp(range.log_scale_tolerance))) + 3;
  const SearchPicture picture(cells, side, side);
  const double faintest = kFaintest * image.full_scale() / Image::kFullScale8;

  std::vector<Peak> peaks;
  int n_steps = 0;
  for (const double log_scale : scales) {
    for (const double turn : turns) {
      if (++n_steps > kMaxSteps) break;
      const Stencil stencil =
          make_stencil(model, px_from_frame, level, range.turn + turn, log_scale);
      const cv::Mat map = correlate(picture, stencil, range.gain_sign, faintest);
      collect_peaks(map, stencil, picture, box, factor, peaks);
    }
  }
  const double same = kSameTemplate * scale_px * std::min(model.width(), model.height());
  return distinct(std::move(peaks), same, max_sightings);
}

}  // namespace panelcal::internal
