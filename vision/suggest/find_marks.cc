// SPDX-License-Identifier: Apache-2.0
#include "vision/suggest/find_marks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include "vision/picture/cv_bridge.h"
#include "vision/picture/memory_error.h"
#include "vision/suggest/outline_shape.h"
#include "vision/tag/read_tags.h"
#include <opencv2/imgproc.hpp>

namespace panelcal {
namespace {

using internal::OutlineShape;

/// A shape at one level.
struct LevelShape {
  OutlineShape shape;
  Polarity polarity = Polarity::Bright;
  int level = 0;
  double inside = 0;  ///< levels just off the rim
  double outside = 0;
  std::vector<Eigen::Vector2d> outline_px;
};

/// Half a percent of the pixels at either end are glints and dead pixels.
constexpr double kTail = 0.005;

/// A shape that fills a picture is its subject: the board, not a mark on it.
constexpr double kMaxSide = 0.9;
/// Corners show in larger outlines only: small discs look like anything.
constexpr double kCornered = 1.5;
/// Tags of fewer pixels a side are not read; one size tells of those within the factor.
constexpr double kMinTag_px = 16;
constexpr double kTagReach = 1.4;

/// The picture blurred a little, in 8 bit from its darkest to its brightest level.
struct SpreadPicture {
  cv::Mat pixels;
  double levels_per_full_scale = 0;  ///< of the 8 bit
};

SpreadPicture spread_picture(const Image& image) {
  cv::Mat mat;
  cv::GaussianBlur(internal::mat_of(image), mat, {}, 1);
  mat.convertTo(mat, CV_32F);
  std::vector<float> sorted(mat.begin<float>(), mat.end<float>());
  const auto n_tail = static_cast<std::ptrdiff_t>(kTail * static_cast<double>(sorted.size()));
  std::ranges::nth_element(sorted, sorted.begin() + n_tail);
  const double low = sorted[static_cast<std::size_t>(n_tail)];
  std::ranges::nth_element(sorted, sorted.end() - 1 - n_tail);
  const double high = *(sorted.end() - 1 - n_tail);
  SpreadPicture out;
  if (!(high > low)) return out;
  const double gain = Image::kFullScale8 / (high - low);
  mat.convertTo(out.pixels, CV_8U, gain, -gain * low);
  out.levels_per_full_scale = gain * image.full_scale();
  return out;
}

/// Sigma of what differs between places that the blur does not connect: noise, grain and texture.
double roughness_of(const cv::Mat& pixels) {
  constexpr int kApart_px = 5;
  if (pixels.cols <= kApart_px) return 0;
  cv::Mat differences;
  cv::absdiff(pixels.colRange(kApart_px, pixels.cols),
              pixels.colRange(0, pixels.cols - kApart_px),
              differences);
  std::array<std::ptrdiff_t, 256> counts{};
  for (auto it = differences.begin<std::uint8_t>(); it != differences.end<std::uint8_t>(); ++it) {
    ++counts[*it];
  }
  std::ptrdiff_t n_below = 0;
  std::size_t median = 0;
  while (2 * (n_below + counts[median]) < static_cast<std::ptrdiff_t>(differences.total())) {
    n_below += counts[median++];
  }
  constexpr double kSigmasPerMedian = 1.4826;
  return kSigmasPerMedian * static_cast<double>(median) / std::numbers::sqrt2;
}

/// True if chance would hardly make such a rim: the longer it is, the less contrast it needs.
bool stands_out(const LevelShape& shape, double roughness) {
  constexpr double kSigmasOf8 = 6;
  const double sigmas = kSigmasOf8 * std::sqrt(8 / std::max(8.0, shape.shape.size_px));
  return std::abs(shape.inside - shape.outside) >= sigmas * roughness;
}

bool touches_border(const cv::Rect& box, const cv::Mat& pixels) {
  return box.x <= 1 || box.y <= 1 || box.br().x >= pixels.cols - 1 || box.br().y >= pixels.rows - 1;
}

/// The level beside an outline: the quartile on the asked side, since of a cross's arms only the
/// tips have their inside towards the middle.
double level_beside(const cv::Mat& pixels,
                    const std::vector<Eigen::Vector2d>& outline_px,
                    const Eigen::Vector2d& center_px,
                    double step_px,
                    bool is_upper) {
  std::vector<int> levels;
  for (const Eigen::Vector2d& u : outline_px) {
    const Eigen::Vector2d v = u + step_px * (u - center_px).normalized();
    const cv::Point at(static_cast<int>(std::lround(v.x())), static_cast<int>(std::lround(v.y())));
    if (at.x < 0 || at.y < 0 || at.x >= pixels.cols || at.y >= pixels.rows) continue;
    levels.push_back(pixels.at<std::uint8_t>(at));
  }
  if (levels.empty()) return 0;
  const std::size_t i_quartile = (is_upper ? 3 * levels.size() : levels.size()) / 4;
  const auto quartile = levels.begin() + static_cast<std::ptrdiff_t>(i_quartile);
  std::ranges::nth_element(levels, quartile);
  return *quartile;
}

/// The shape of one contour. A hole's contour runs through the pixels around it, a blob's through
/// its own: by Pick's theorem the number of pixels inside follows from either.
std::optional<LevelShape> level_shape(const cv::Mat& pixels,
                                      const std::vector<cv::Point>& contour,
                                      bool is_hole,
                                      const MarkOptions& options) {
  const cv::Rect box = cv::boundingRect(contour);
  const int side = std::min(box.width, box.height);
  if (side < options.min_size_px || touches_border(box, pixels)) return std::nullopt;
  if (side > kMaxSide * std::min(pixels.cols, pixels.rows)) return std::nullopt;
  // Nets of tracks are no marks, and long.
  if (static_cast<int>(contour.size()) > 8 * std::max(box.width, box.height)) return std::nullopt;
  if (std::max(box.width, box.height) > 3 * side) return std::nullopt;
  const double sign = is_hole ? -1 : 1;
  const double area = cv::contourArea(contour) + sign * static_cast<double>(contour.size()) / 2 + 1;
  const Eigen::Vector2d middle(box.x + 0.5 * (box.width - 1), box.y + 0.5 * (box.height - 1));
  LevelShape out;
  for (const cv::Point& p : contour) {
    const Eigen::Vector2d u(p.x, p.y);
    const Eigen::Vector2d from = u - middle;
    out.outline_px.emplace_back(u + sign * 0.5 * from.normalized());
  }
  const auto shape = internal::shape_of(out.outline_px, area);
  const double min_size_px =
      options.min_size_px * (shape && shape->shape != Shape::Disc ? kCornered : 1);
  if (!shape || shape->size_px < min_size_px) return std::nullopt;
  out.shape = *shape;
  out.polarity = is_hole ? Polarity::Dark : Polarity::Bright;
  const double step_px = std::max(3.0, 0.06 * shape->size_px);
  const auto beside = [&](double step, bool is_upper) {
    return level_beside(pixels, out.outline_px, shape->center_px, step, is_upper);
  };
  out.inside = beside(-step_px, !is_hole);
  out.outside = beside(step_px, is_hole);
  return out;
}

std::vector<LevelShape> shapes_at(const cv::Mat& pixels, int level, const MarkOptions& options) {
  cv::Mat above;
  cv::threshold(pixels, above, level, 255, cv::THRESH_BINARY);
  std::vector<std::vector<cv::Point>> contours;
  std::vector<cv::Vec4i> tree;  // next, previous, first child, parent
  cv::findContours(above, contours, tree, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  std::vector<LevelShape> shapes;
  for (std::size_t i = 0; i < contours.size(); ++i) {
    auto shape = level_shape(pixels, contours[i], tree[i][3] >= 0, options);
    if (!shape) continue;
    shape->level = level;
    shapes.push_back(*std::move(shape));
  }
  return shapes;
}

/// True if two shapes are one at two levels.
bool is_same_mark(const LevelShape& a, const LevelShape& b) {
  const double size = std::max(a.shape.size_px, b.shape.size_px);
  return a.shape.shape == b.shape.shape && a.polarity == b.polarity &&
         std::abs(a.shape.size_px - b.shape.size_px) <= std::max(1.5, 0.1 * size) &&
         (a.shape.center_px - b.shape.center_px).norm() <= std::max(1.0, 0.06 * size);
}

/// Shapes of rising level that are one mark.
using Chain = std::vector<LevelShape>;

void add_to_chains(std::vector<LevelShape> shapes, int level_step, std::vector<Chain>& chains) {
  const std::size_t n_before = chains.size();
  for (LevelShape& shape : shapes) {
    // One level may be missed.
    const auto end = chains.begin() + static_cast<std::ptrdiff_t>(n_before);
    const auto found = std::find_if(chains.begin(), end, [&](const Chain& chain) {
      return shape.level - chain.back().level <= 2 * level_step &&
             is_same_mark(chain.back(), shape);
    });
    if (found == end) {
      chains.push_back({std::move(shape)});
    } else {
      found->push_back(std::move(shape));
    }
  }
}

/// The shape half way between inside and outside, its size between the levels' sizes.
SeenMark mark_of(const Chain& chain, double levels_per_full_scale) {
  const LevelShape& some = chain[chain.size() / 2];
  const double half = 0.5 * (some.inside + some.outside);
  const auto above =
      std::ranges::find_if(chain, [&](const LevelShape& s) { return s.level > half; });
  const LevelShape& upper = above == chain.end() ? chain.back() : *above;
  const LevelShape& lower = above == chain.begin() ? chain.front() : *(above - 1);
  const double span = upper.level - lower.level;
  const double t = span > 0 ? std::clamp((half - lower.level) / span, 0.0, 1.0) : 0;
  const LevelShape& nearest = t < 0.5 ? lower : upper;
  SeenMark mark;
  mark.shape = nearest.shape.shape;
  mark.polarity = nearest.polarity;
  mark.center = position_px(nearest.shape.center_px.x(), nearest.shape.center_px.y());
  mark.size = px((1 - t) * lower.shape.size_px + t * upper.shape.size_px);
  if (mark.shape == Shape::Cross) mark.detail = px(nearest.shape.width_px);
  mark.angle = rad(nearest.shape.angle_rad);
  mark.contrast = std::abs(nearest.inside - nearest.outside) / levels_per_full_scale;
  mark.quality = nearest.shape.quality;
  mark.outline_px = nearest.outline_px;
  return mark;
}

double apart_px(const SeenMark& a, const SeenMark& b) {
  return (a.center - b.center).in_px().norm();
}

/// Leaves the best of marks that are one: a blurred disc may be taken for a square at some levels.
void drop_doubles(std::vector<SeenMark>& marks) {
  std::ranges::stable_sort(
      marks, std::ranges::greater(), [](const SeenMark& m) { return m.quality * m.contrast; });
  std::vector<SeenMark> kept;
  for (SeenMark& mark : marks) {
    const bool is_known = std::ranges::any_of(kept, [&](const SeenMark& other) {
      const double size = std::max(mark.size.in_px(), other.size.in_px());
      return mark.polarity == other.polarity && apart_px(mark, other) < 0.15 * size &&
             std::abs(mark.size.in_px() - other.size.in_px()) < 0.3 * size;
    });
    if (!is_known) kept.push_back(std::move(mark));
  }
  marks = std::move(kept);
}

/// A disc with one of the other polarity in its middle is a ring; the inner one stays as well.
void name_rings(std::vector<SeenMark>& marks) {
  for (SeenMark& outer : marks) {
    if (outer.shape != Shape::Disc) continue;
    const double size = outer.size.in_px();
    for (const SeenMark& inner : marks) {
      const bool is_in = inner.shape == Shape::Disc && inner.polarity != outer.polarity &&
                         inner.size.in_px() < 0.85 * size && inner.size.in_px() > 0.1 * size &&
                         apart_px(inner, outer) < 0.1 * size;
      if (is_in && (!outer.detail || *outer.detail < inner.size)) outer.detail = inner.size;
    }
  }
  for (SeenMark& mark : marks) {
    if (mark.shape == Shape::Disc && mark.detail) mark.shape = Shape::Ring;
  }
}

SeenMark mark_of(const ReadTag& tag, std::string_view family, const SeenMark& square) {
  SeenMark mark = square;
  mark.shape = Shape::AprilTag;
  mark.polarity = Polarity::Bright;
  mark.family = family;
  mark.tag_id = tag.id;
  mark.outline_px.clear();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double around_px = 0;
  for (std::size_t i = 0; i < tag.corners.size(); ++i) {
    sum += tag.corners[i].in_px();
    around_px += (tag.corners[i] - tag.corners[(i + 1) % tag.corners.size()]).in_px().norm();
    mark.outline_px.push_back(tag.corners[i].in_px());
  }
  const Eigen::Vector2d center = sum / 4;
  mark.center = position_px<frame::Image>(center);
  mark.size = px(around_px / 4);
  mark.quality = 1;
  return mark;
}

bool is_square(const SeenMark& mark) {
  return mark.shape == Shape::Square || mark.shape == Shape::Diamond;
}

/// Tags have square frames, so that squares say at which sizes to look for them. Whatever lies in a
/// tag is a part of it.
void read_tags_into(const Image& image, std::vector<SeenMark>& marks) {
  std::vector<SeenMark> tags;
  std::vector<SeenMark> squares;
  std::ranges::copy_if(marks, std::back_inserter(squares), is_square);
  std::erase_if(squares, [](const SeenMark& m) { return m.size.in_px() < kMinTag_px; });
  std::ranges::sort(squares, {}, [](const SeenMark& m) { return m.size.in_px(); });
  double read_px = 0;
  for (const SeenMark& square : squares) {
    if (square.size.in_px() < kTagReach * read_px) continue;
    read_px = square.size.in_px();
    for (const char* family : {"tag36h11", "tagStandard41h12", "tag25h9"}) {
      Target target;
      target.shape = Shape::AprilTag;
      target.size_px = square.size;
      target.tag_family = family;
      const auto read = read_tags(image, target);
      if (!read) continue;
      for (const ReadTag& tag : *read) {
        SeenMark mark = mark_of(tag, family, square);
        const bool is_known = std::ranges::any_of(tags, [&](const SeenMark& other) {
          return apart_px(mark, other) < 0.5 * mark.size.in_px();
        });
        if (!is_known) tags.push_back(std::move(mark));
      }
    }
  }
  std::erase_if(marks, [&](const SeenMark& mark) {
    return std::ranges::any_of(tags, [&](const SeenMark& tag) {
      return apart_px(mark, tag) < 0.75 * tag.size.in_px() &&
             mark.size.in_px() < 1.5 * tag.size.in_px();
    });
  });
  std::ranges::move(tags, std::back_inserter(marks));
}

std::vector<SeenMark> marks_in(const Image& image, const MarkOptions& options) {
  const SpreadPicture picture = spread_picture(image);
  if (picture.pixels.empty()) return {};
  constexpr std::size_t kMinLevels = 2;
  const int step = std::max(1, 256 / (options.n_levels + 1));
  const double roughness = roughness_of(picture.pixels);
  std::vector<Chain> chains;
  std::vector<Chain> ended;
  for (int level = step; level < 255; level += step) {
    const auto live = std::ranges::partition(
        chains, [&](const Chain& c) { return level - c.back().level <= 2 * step; });
    std::ranges::move(live, std::back_inserter(ended));
    chains.erase(live.begin(), live.end());
    add_to_chains(shapes_at(picture.pixels, level, options), step, chains);
  }
  std::ranges::move(chains, std::back_inserter(ended));
  std::vector<SeenMark> marks;
  for (const Chain& chain : ended) {
    if (chain.size() < kMinLevels || !stands_out(chain[chain.size() / 2], roughness)) continue;
    SeenMark mark = mark_of(chain, picture.levels_per_full_scale);
    if (mark.contrast >= options.min_contrast) marks.push_back(std::move(mark));
  }
  drop_doubles(marks);
  name_rings(marks);
  if (options.reads_tags) read_tags_into(image, marks);
  std::ranges::stable_sort(marks, {}, [](const SeenMark& m) {
    return std::pair(m.center.in_px().y(), m.center.in_px().x());
  });
  return marks;
}

}  // namespace

std::vector<SeenMark> find_marks(const Image& image, const MarkOptions& options) {
  if (image.empty()) return {};
  try {
    return marks_in(image, options);
  } catch (const std::exception& e) {
    internal::rethrow_memory_error(e);
    return {};
  }
}

}  // namespace panelcal
