// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/frame_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "vision/fit/local_maxima.h"
#include "vision/picture/cv_bridge.h"
#include "vision/tag/frame_sides.h"
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

/// Pixels of a cell in the reduced picture.
constexpr double kFrameCellPx = 2;
/// Turns and sizes between two that are tried move the frame's cells by less than 0.35 of a cell.
constexpr int kFrameTurns = 14;  // of a quarter
constexpr double kFrameSizeStep = 0.12;
/// Scores below this, in spreads of the levels, are no frames. A frame that is half hidden has 0.8,
/// noise next to nothing: its mean over 60 cells is small.
constexpr double kMinFrameScore = 0.45;
constexpr std::size_t kMaxFrames = 16;
/// Levels farther than this from the mean about them, in their spreads, are debris or glints and
/// are clipped, several times over: a tag's own two levels are one spread away.
constexpr double kClipSpreads = 1.3;
constexpr int kClips = 3;
constexpr double kSameFrame = 0.35;  // of the side: nearer maxima are of one frame

/// A smaller picture whose cells have two pixels.
struct SmallPicture {
  cv::Mat levels;     ///< float
  cv::Mat spreads;    ///< standard deviation of the levels about every place
  double factor = 1;  ///< pixels of the picture in one of these
  PixelBox box;

  Eigen::Vector2d to_image(const Eigen::Vector2d& at) const {
    const double x = (at.x() + 0.5) * factor - 0.5 + box.x0;
    return {x, (at.y() + 0.5) * factor - 0.5 + box.y0};
  }
};

SmallPicture small_picture(const Image& image, const PixelBox& box, double cell_px, int n_cells) {
  const cv::Mat part = pixels_of(image)(cv::Rect(box.x0, box.y0, box.width, box.height));
  SmallPicture small;
  small.box = box;
  small.factor = std::max(1.0, cell_px / kFrameCellPx);
  const auto side = [&](int n) {
    return std::max(1, static_cast<int>(std::lround(n / small.factor)));
  };
  cv::resize(part, small.levels, cv::Size(side(box.width), side(box.height)), 0, 0, cv::INTER_AREA);
  const int window = std::max(3, static_cast<int>(std::lround(n_cells * cell_px / small.factor)));
  for (int pass = 0; pass <= kClips; ++pass) {
    cv::Mat mean;
    cv::Mat square;
    cv::boxFilter(small.levels, mean, CV_32F, cv::Size(window, window));
    cv::sqrBoxFilter(small.levels, square, CV_32F, cv::Size(window, window));
    cv::Mat variance = square - mean.mul(mean);
    cv::max(variance, 1e-6F, variance);
    cv::sqrt(variance, small.spreads);
    if (pass == kClips) break;
    const cv::Mat low = mean - kClipSpreads * small.spreads;
    const cv::Mat high = mean + kClipSpreads * small.spreads;
    cv::max(small.levels, low, small.levels);
    cv::min(small.levels, high, small.levels);
  }
  return small;
}

/// A cell of the frame as the sums see it: where it is from the tag's middle, and its weight.
struct FrameTap {
  int dx = 0;
  int dy = 0;
  float weight = 0;
};

std::vector<FrameTap> frame_taps(const TagFamily& family,
                                 double cell_px,
                                 double turn_rad,
                                 bool is_inverted) {
  const TagPattern blank = family.blank();
  const double c = std::cos(turn_rad) * cell_px;
  const double s = std::sin(turn_rad) * cell_px;
  std::vector<FrameTap> taps;
  int n_white = 0;
  for (int row = 0; row < blank.n_cells; ++row) {
    for (int column = 0; column < blank.n_cells; ++column) {
      const TagCell cell = blank.at(column, row);
      if (cell == TagCell::Any) continue;
      const double x = column + 0.5 - 0.5 * blank.n_cells;
      const double y = row + 0.5 - 0.5 * blank.n_cells;
      const bool is_white = (cell == TagCell::White) != is_inverted;
      n_white += is_white;
      taps.push_back({static_cast<int>(std::lround(c * x - s * y)),
                      static_cast<int>(std::lround(s * x + c * y)),
                      is_white ? 1.0F : -1.0F});
    }
  }
  const auto n_black = static_cast<float>(static_cast<int>(taps.size()) - n_white);
  for (FrameTap& tap : taps) tap.weight /= tap.weight > 0 ? static_cast<float>(n_white) : n_black;
  return taps;
}

/// Sums of the taps at every place; what reaches beyond the picture counts as the nearest pixel.
cv::Mat frame_response(const cv::Mat& padded, int pad, const std::vector<FrameTap>& taps) {
  const int width = padded.cols - 2 * pad;
  const int height = padded.rows - 2 * pad;
  cv::Mat response = cv::Mat::zeros(height, width, CV_32F);
  for (int y = 0; y < height; ++y) {
    float* out = response.ptr<float>(y);
    for (const FrameTap& tap : taps) {
      const float* in = padded.ptr<float>(y + pad + tap.dy) + pad + tap.dx;
      const float weight = tap.weight;
      for (int x = 0; x < width; ++x) out[x] += weight * in[x];
    }
  }
  return response;
}

struct FrameSighting {
  float score = 0;
  Eigen::Vector2d at;  ///< in the small picture
  double turn_rad = 0;
  double scale = 1;
};

/// The best turn and size at every place.
class BestFrames {
 public:
  explicit BestFrames(cv::Size size)
      : scores_(cv::Mat::zeros(size, CV_32F)), poses_(cv::Mat::zeros(size, CV_32S)) {}

  void add(const cv::Mat& response, const cv::Mat& spreads, int pose) {
    for (int y = 0; y < response.rows; ++y) {
      const float* r = response.ptr<float>(y);
      const float* spread = spreads.ptr<float>(y);
      float* score = scores_.ptr<float>(y);
      int* best = poses_.ptr<int>(y);
      for (int x = 0; x < response.cols; ++x) {
        if (r[x] <= score[x] * spread[x]) continue;
        score[x] = r[x] / spread[x];
        best[x] = pose;
      }
    }
  }

  /// Local maxima, the highest first.
  std::vector<std::pair<cv::Point, int>> peaks(double apart_px) const {
    std::vector<std::pair<cv::Point, int>> chosen;
    for (const cv::Point& at : local_maxima(scores_, kMinFrameScore)) {
      if (chosen.size() == kMaxFrames) break;
      const bool is_new = std::none_of(chosen.begin(), chosen.end(), [&](const auto& other) {
        return cv::norm(other.first - at) < apart_px;
      });
      if (is_new) chosen.emplace_back(at, poses_.at<int>(at));
    }
    return chosen;
  }

 private:
  cv::Mat scores_;
  cv::Mat poses_;
};

std::vector<double> frame_scales(double size_tolerance) {
  const int n = static_cast<int>(std::ceil(std::max(0.0, size_tolerance / kFrameSizeStep - 0.5)));
  std::vector<double> scales;
  for (int i = -n; i <= n; ++i) scales.push_back(std::pow(1 + kFrameSizeStep, i));
  return scales;
}

TagQuad square_quad(const Eigen::Vector2d& center_px, double side_px, double turn_rad) {
  const double c = std::cos(turn_rad) * side_px;
  const double s = std::sin(turn_rad) * side_px;
  TagQuad quad;
  const auto corners = tag_corners();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d& v = corners[i];
    quad.corners_px[i] = center_px + Eigen::Vector2d(c * v.x() - s * v.y(), s * v.x() + c * v.y());
  }
  return quad;
}

}  // namespace

std::vector<TagQuad> find_tag_frames(const Image& image,
                                     const PixelBox& box,
                                     const TagFamily& family,
                                     const FrameQuery& query) {
  const double cell_px = query.side_px / family.n_on_side;
  if (box.width < 1 || box.height < 1 || !(cell_px >= 1)) return {};
  const SmallPicture small = small_picture(image, box, cell_px, family.n_cells);
  const std::vector<double> scales = frame_scales(query.size_tolerance);
  const double small_cell_px = cell_px / small.factor;
  const int pad =
      2 + static_cast<int>(std::ceil(0.75 * family.n_cells * small_cell_px * scales.back()));
  cv::Mat padded;
  cv::copyMakeBorder(small.levels, padded, pad, pad, pad, pad, cv::BORDER_REPLICATE);
  const auto turn_of = [](int pose) {
    return (pose % kFrameTurns) * 0.5 * std::numbers::pi / kFrameTurns;
  };
  const auto scale_of = [&](int pose) {
    return scales[static_cast<std::size_t>(pose / kFrameTurns)];
  };
  BestFrames best(small.levels.size());
  const int n_poses = kFrameTurns * static_cast<int>(scales.size());
  for (int pose = 0; pose < n_poses; ++pose) {
    const auto taps =
        frame_taps(family, small_cell_px * scale_of(pose), turn_of(pose), query.is_inverted);
    best.add(frame_response(padded, pad, taps), small.spreads, pose);
  }
  std::vector<TagQuad> quads;
  for (const auto& [at, pose] : best.peaks(kSameFrame * query.side_px / small.factor)) {
    const Eigen::Vector2d center_px = small.to_image({at.x, at.y});
    const TagQuad rough = square_quad(center_px, query.side_px * scale_of(pose), turn_of(pose));
    if (const auto quad = moved_to_sides(image, family, rough, query.is_inverted)) {
      quads.push_back(*quad);
    }
  }
  return quads;
}

}  // namespace panelcal::internal
