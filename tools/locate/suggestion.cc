// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/suggestion.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "calib/base/append_format.h"
#include "calib/base/json/json_string.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Blocks to choose from; the list has all groups.
constexpr std::size_t kMaxBlocks = 6;
constexpr std::size_t kMaxListed = 40;
/// The tolerance that a vision tool has without a key.
constexpr double kUsualTolerance = 0.04;

double angle_deg(const SeenMark& mark) {
  return std::round(mark.angle.in_deg());
}

/// Half the range of the sizes about the median, and a little more.
double size_tolerance(const MarkGroup& group) {
  const double size = group.size.in_px();
  const double reach =
      std::max(group.max_size.in_px() - size, size - group.min_size.in_px()) / size;
  return std::ceil(100 * (reach + 0.02)) / 100;
}

/// `size_px = 61.2`, or in mm.
std::string length_key(std::string_view name, PixelLength length, std::optional<Length> pixel) {
  if (!pixel) return fmt::format("{}_px = {:.1f}\n", name, length.in_px());
  return fmt::format("{}_mm = {:.3f}\n", name, length.in_px() * pixel->in_mm());
}

std::string range_text(const MarkGroup& group) {
  if (group.marks.size() == 1) return fmt::format("{:.1f} px", group.size.in_px());
  return fmt::format("{:.1f} px ({:.1f} to {:.1f})",
                     group.size.in_px(),
                     group.min_size.in_px(),
                     group.max_size.in_px());
}

std::string kind_text(const SeenMark& mark) {
  if (mark.shape == Shape::AprilTag) return mark.family;
  return fmt::format("{} {}", name(mark.polarity), name(mark.shape));
}

/// "#  12  bright disc  61.2 px (60.1 to 62.0)  contrast 0.41  best at 512.3, 388.1".
std::string listed(const MarkGroup& group) {
  const SeenMark& best = group.best();
  std::string out = fmt::format("# {:>4}  {:<18} {:<28} contrast {:.2f}, best at {:.1f}, {:.1f}",
                                group.marks.size(),
                                kind_text(best),
                                range_text(group),
                                group.contrast,
                                best.center.in_px().x(),
                                best.center.in_px().y());
  if (best.detail) {
    out += fmt::format(
        ", {} {:.1f} px", best.shape == Shape::Cross ? "bars" : "hole", best.detail->in_px());
  }
  if (best.tag_id) out += fmt::format(", id {}", *best.tag_id);
  return out + "\n";
}

std::string block(const MarkGroup& group, std::size_t number, std::optional<Length> pixel) {
  const SeenMark& best = group.best();
  std::string out =
      fmt::format("\n[[vision.tool]]            # {} seen\nnumber = {}\nshape = \"{}\"\n",
                  group.marks.size(),
                  number,
                  name(best.shape));
  out += length_key("size", group.size, pixel);
  if (best.shape == Shape::Cross && best.detail) out += length_key("width", *best.detail, pixel);
  out += fmt::format("polarity = \"{}\"\n", name(best.polarity));
  const bool has_angle =
      best.shape == Shape::Square || best.shape == Shape::Diamond || best.shape == Shape::Cross;
  // In millimetres y points up.
  const double turn_deg = pixel ? -angle_deg(best) : angle_deg(best);
  if (has_angle && turn_deg != 0) out += fmt::format("angle_deg = {:.0f}\n", turn_deg);
  if (best.shape == Shape::AprilTag) {
    out += fmt::format("family = \"{}\"\n", best.family);
    if (group.marks.size() == 1) out += fmt::format("id = {}\n", *best.tag_id);
  }
  const double tolerance = size_tolerance(group);
  if (tolerance > kUsualTolerance) out += fmt::format("size_tolerance = {:.2f}\n", tolerance);
  return out;
}

}  // namespace

std::string suggestion_toml(const std::vector<PictureMarks>& pictures,
                            std::optional<Length> pixel) {
  std::vector<SeenMark> all;
  for (const PictureMarks& picture : pictures) {
    all.insert(all.end(), picture.marks.begin(), picture.marks.end());
  }
  const std::size_t n_all = all.size();
  const std::vector<MarkGroup> groups = group_marks(std::move(all));
  std::string out =
      fmt::format("# {} mark{} in {} picture{}{}\n",
                  n_all,
                  n_all == 1 ? "" : "s",
                  pictures.size(),
                  pictures.size() == 1 ? "" : "s",
                  n_all == 0 ? ": nothing round, square, cross-shaped or tagged" : "");
  for (std::size_t i = 0; i < std::min(kMaxListed, groups.size()); ++i) out += listed(groups[i]);
  if (groups.size() > kMaxListed) {
    out += fmt::format("# and {} groups that are less useful\n", groups.size() - kMaxListed);
  }
  for (std::size_t i = 0; i < std::min(kMaxBlocks, groups.size()); ++i) {
    out += block(groups[i], i + 1, pixel);
  }
  return out;
}

}  // namespace panelcal
