// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <tuple>
#include <utility>

#include "calib/base/statistics/median.h"
#include "vision/suggest/seen_mark.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Sizes of one group differ by less from the smallest to the next.
constexpr double kLikeSize = 1.08;
/// More contrast makes no mark more useful.
constexpr double kEnoughContrast = 0.25;

auto kind_of(const SeenMark& mark) {
  return std::tuple(mark.shape, mark.polarity, mark.family);
}

bool are_alike(const SeenMark& smaller, const SeenMark& larger) {
  return kind_of(smaller) == kind_of(larger) &&
         larger.size.in_px() <= kLikeSize * smaller.size.in_px();
}

double worth_of(const SeenMark& mark) {
  return mark.quality * std::min(1.0, mark.contrast / kEnoughContrast);
}

/// In     marks: of rising size, not empty
MarkGroup group_of(std::vector<SeenMark> marks) {
  MarkGroup group;
  group.min_size = marks.front().size;
  group.max_size = marks.back().size;
  group.size = marks[marks.size() / 2].size;
  std::vector<double> contrasts;
  for (const SeenMark& mark : marks) {
    contrasts.push_back(mark.contrast);
    group.worth += worth_of(mark);
  }
  group.contrast = median(std::move(contrasts));
  std::ranges::stable_sort(marks, std::ranges::greater(), worth_of);
  group.marks = std::move(marks);
  return group;
}

}  // namespace

std::vector<MarkGroup> group_marks(std::vector<SeenMark> marks) {
  std::ranges::stable_sort(marks, [](const SeenMark& a, const SeenMark& b) {
    return std::pair(kind_of(a), a.size.in_px()) < std::pair(kind_of(b), b.size.in_px());
  });
  std::vector<MarkGroup> groups;
  auto first = marks.begin();
  while (first != marks.end()) {
    // Neighbours chain up, so that a group is bounded from its smallest member.
    const auto last =
        std::find_if(first, marks.end(), [&](const SeenMark& m) { return !are_alike(*first, m); });
    groups.push_back(group_of({first, last}));
    first = last;
  }
  std::ranges::stable_sort(groups, [](const MarkGroup& a, const MarkGroup& b) {
    const bool a_is_tag = a.best().shape == Shape::AprilTag;
    const bool b_is_tag = b.best().shape == Shape::AprilTag;
    return a_is_tag != b_is_tag ? a_is_tag : a.worth > b.worth;
  });
  return groups;
}

std::string describe(const SeenMark& mark) {
  const std::string what = mark.shape == Shape::AprilTag
                               ? fmt::format("{} {}", mark.family, mark.tag_id.value_or(0))
                               : std::string(name(mark.shape));
  return fmt::format("{} {} of {:.1f} px", name(mark.polarity), what, mark.size.in_px());
}

}  // namespace panelcal
