// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/family.h"

#include <algorithm>
#include <memory>

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>

namespace panelcal {
namespace {

/// One row of the table of families: the library makes and unmakes each with functions of its own.
struct Entry {
  std::string_view name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

constexpr std::array kEntries = {
    Entry{"tag36h11", tag36h11_create, tag36h11_destroy},
    Entry{"tag36h10", tag36h10_create, tag36h10_destroy},
    Entry{"tag25h9", tag25h9_create, tag25h9_destroy},
    Entry{"tag16h5", tag16h5_create, tag16h5_destroy},
    Entry{"tagCircle21h7", tagCircle21h7_create, tagCircle21h7_destroy},
    Entry{"tagCircle49h12", tagCircle49h12_create, tagCircle49h12_destroy},
    Entry{"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
    Entry{"tagStandard52h13", tagStandard52h13_create, tagStandard52h13_destroy},
    Entry{"tagCustom48h12", tagCustom48h12_create, tagCustom48h12_destroy},
};

constexpr auto kFamilyNames = [] {
  std::array<std::string_view, kEntries.size()> names;
  std::transform(
      kEntries.begin(), kEntries.end(), names.begin(), [](const Entry& e) { return e.name; });
  return names;
}();

}  // namespace

std::span<const std::string_view> tag_family_names() {
  return kFamilyNames;
}

TagPattern TagFamily::blank() const {
  TagPattern pattern;
  pattern.n_cells = n_cells;
  pattern.n_on_side = n_on_side;
  for (int i = 0; i <= n_cells; ++i) {
    pattern.lines.push_back((i - 0.5 * n_cells) / n_on_side);
  }
  // The frame is a ring of one cell inside of the corners' square, and one of the other colour
  // outside of it.
  const TagCell inner = is_reversed ? TagCell::White : TagCell::Black;
  const TagCell outer = is_reversed ? TagCell::Black : TagCell::White;
  const int first = (n_cells - n_on_side) / 2;
  const int last = first + n_on_side - 1;
  for (int row = 0; row < n_cells; ++row) {
    for (int column = 0; column < n_cells; ++column) {
      // Depth in cells inside the corners' square; negative outside.
      const int depth = std::min({column - first, last - column, row - first, last - row});
      pattern.levels.push_back(depth == 0 ? inner : depth == -1 ? outer : TagCell::Any);
    }
  }
  return pattern;
}

TagPattern TagFamily::pattern(int id) const {
  TagPattern pattern = blank();
  std::uint64_t code = codes[static_cast<std::size_t>(id)];
  for (auto bit = bits.rbegin(); bit != bits.rend(); ++bit, code >>= 1) {
    const auto cell = static_cast<std::size_t>(bit->row * n_cells + bit->column);
    pattern.levels[cell] = (code & 1) != 0 ? TagCell::White : TagCell::Black;
  }
  return pattern;
}

std::optional<TagFamily> find_tag_family(std::string_view name) {
  const auto* entry = std::find(kFamilyNames.begin(), kFamilyNames.end(), name);
  if (entry == kFamilyNames.end()) return std::nullopt;
  const Entry& e = kEntries[static_cast<std::size_t>(entry - kFamilyNames.begin())];
  const std::unique_ptr<apriltag_family_t, decltype(e.destroy)> source(e.create(), e.destroy);
  TagFamily family;
  family.name = e.name;
  family.n_cells = source->total_width;
  family.n_on_side = source->width_at_border;
  family.is_reversed = source->reversed_border;
  family.hamming_distance = static_cast<int>(source->h);
  // The library counts bits' places from the corners' square.
  const int first = (family.n_cells - family.n_on_side) / 2;
  for (std::uint32_t i = 0; i < source->nbits; ++i) {
    family.bits.push_back(
        {static_cast<int>(source->bit_x[i]) + first, static_cast<int>(source->bit_y[i]) + first});
  }
  family.codes.assign(source->codes, source->codes + source->ncodes);
  return family;
}

std::optional<TagPattern> tag_pattern(std::string_view family, int id) {
  const auto found = find_tag_family(family);
  if (!found || id < 0 || id >= found->n_tags()) return std::nullopt;
  return found->pattern(id);
}

}  // namespace panelcal
