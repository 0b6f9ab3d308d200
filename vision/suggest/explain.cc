// SPDX-License-Identifier: Apache-2.0
#include "vision/suggest/explain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/suggest/find_marks.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Fewer levels than a person is shown marks from: this is for the plain ones.
constexpr int kExplainLevels = 12;
/// A mark that fits like this is not worth its mention.
constexpr double kMaxStrange = 1.7;

/// The shape under which find_marks() reports a target; empty for those that it does not know.
std::optional<Shape> seen_as(Shape shape) {
  constexpr std::array kSeen = {
      Shape::Disc, Shape::Ring, Shape::Square, Shape::Diamond, Shape::Cross, Shape::AprilTag};
  if (shape == Shape::Hole) return Shape::Disc;
  if (std::ranges::find(kSeen, shape) == kSeen.end()) return std::nullopt;
  return shape;
}

/// A mark beside what was asked for.
struct Likeness {
  bool has_shape = false;
  bool has_polarity = false;
  bool has_size = false;
  double ratio = 1;    ///< of the sizes
  double strange = 0;  ///< its difference: 1 for another polarity, or for twice the size
};

Likeness likeness(const SeenMark& mark, const Target& target, double asked_px) {
  const Shape asked = *seen_as(target.shape);
  // A pad with a hole is seen as a ring.
  const bool is_holed = asked == Shape::Disc && mark.shape == Shape::Ring;
  Likeness like;
  like.has_shape = mark.shape == asked || is_holed;
  like.has_polarity = mark.polarity == target.polarity || asked == Shape::AprilTag;
  like.ratio = mark.size.in_px() / asked_px;
  like.has_size = std::abs(like.ratio - 1) <= target.size_tolerance;
  like.strange =
      (like.has_shape ? 0 : 1.5) + (like.has_polarity ? 0 : 1) + std::abs(std::log2(like.ratio));
  return like;
}

/// The searched part of a picture, and where it begins.
struct SearchedPart {
  Image image;
  Eigen::Vector2d first_px = Eigen::Vector2d::Zero();
};

SearchedPart searched_part(const DetectorInput& input, double reach_px) {
  const PixelBox box = input.area.box(input.image, reach_px);
  SearchedPart part{Image(box.width, box.height, input.image.full_scale()),
                    Eigen::Vector2d(box.x0, box.y0)};
  for (int y = 0; y < box.height; ++y) {
    const auto row =
        input.image.row(box.y0 + y)
            .subspan(static_cast<std::size_t>(box.x0), static_cast<std::size_t>(box.width));
    std::ranges::copy(row, part.image.row(y).begin());
  }
  return part;
}

std::string wrong_words(const Likeness& like) {
  std::string words;
  const auto add = [&](bool is_right, std::string_view word) {
    if (is_right) return;
    words += words.empty() ? "" : " and ";
    words += word;
  };
  add(like.has_shape, "shape");
  add(like.has_polarity, "polarity");
  add(like.has_size, "size");
  return words;
}

/// Tells of the mark that is most like the target, unless it is the one that was judged.
void explain_by_marks(const DetectorInput& input, double asked_px, Detection& detection) {
  const SearchedPart part = searched_part(input, 1.5 * asked_px);
  const bool is_tag = input.target.shape == Shape::AprilTag;
  const auto marks = find_marks(part.image, {.n_levels = kExplainLevels, .reads_tags = is_tag});
  const SeenMark* best = nullptr;
  Likeness best_like{.strange = kMaxStrange};
  Eigen::Vector2d best_px = Eigen::Vector2d::Zero();
  for (const SeenMark& mark : marks) {
    const Eigen::Vector2d at_px = part.first_px + mark.center.in_px();
    const Likeness like = likeness(mark, input.target, asked_px);
    if (!input.area.contains(at_px, 0) || like.strange >= best_like.strange) continue;
    best = &mark;
    best_like = like;
    best_px = at_px;
  }
  if (best == nullptr) return;
  const bool is_resized = best_like.has_shape && best_like.has_polarity;
  if (is_resized && !detection.size_ratio) detection.size_ratio = best_like.ratio;
  const bool is_judged =
      detection.best && detection.status == DetectionStatus::Rejected &&
      (detection.best->center.position.in_px() - best_px).norm() < 0.3 * best->size.in_px();
  const std::string wrong = wrong_words(best_like);
  if (is_judged) return;
  const std::string there =
      fmt::format("; at {:.0f}, {:.0f} is a {}", best_px.x(), best_px.y(), describe(*best));
  if (!wrong.empty()) {
    detection.reason += there + fmt::format(" where a {} {} of {:.1f} px was asked for: {}",
                                            name(input.target.polarity),
                                            name(input.target.shape),
                                            asked_px,
                                            wrong);
  } else if (best->contrast < input.options.min_contrast) {
    detection.reason += there + fmt::format(
                                    " with a contrast of {:.3f}, limit {:.3f}: [vision] "
                                    "min_contrast",
                                    best->contrast,
                                    input.options.min_contrast);
  }
}

/// Cameras of 10 to 14 bit often write files of 16 with the upper ones empty.
void explain_by_range(const Image& image, Detection& detection) {
  constexpr double kMaxUsed = 0.26;
  if (image.full_scale() <= Image::kFullScale8 || image.empty()) return;
  const double brightest = *std::ranges::max_element(image.pixels());
  if (!(brightest > 0) || brightest > kMaxUsed * image.full_scale()) return;
  const int unused = static_cast<int>(std::floor(std::log2((image.full_scale() + 1) / brightest)));
  detection.reason += fmt::format(
      "; the picture uses 1/{} of its range: {} bit in {}? set [camera] "
      "bits",
      1 << unused,
      static_cast<int>(std::log2(image.full_scale() + 1)) - unused,
      static_cast<int>(std::log2(image.full_scale() + 1)));
}

}  // namespace

void explain(const DetectorInput& input, Detection& detection) {
  explain_by_range(input.image, detection);
  if (!seen_as(input.target.shape)) return;
  const Target& target = input.target;
  const auto asked_px = frame_length(target.size, target.size_px, input.mapping);
  if (asked_px && *asked_px > 0) explain_by_marks(input, *asked_px, detection);
}

}  // namespace panelcal::internal
