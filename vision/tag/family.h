// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace panelcal {

/// Names of all known AprilTag families.
std::span<const std::string_view> tag_family_names();

/// The print of one cell of a tag; `Any`: the print there is not the tag's.
enum class TagCell : std::uint8_t { Black, White, Any };

/// One tag as a grid of cells.
///
/// The tag's frame: seen from the front with its first row on top, x right, y down; the square that
/// its corners make is [-1/2, 1/2] x [-1/2, 1/2]. Families whose border is reversed, and quiet
/// zones, have cells outside of that square.
struct TagPattern {
  int n_cells = 0;              ///< in a row and in a column
  int n_on_side = 0;            ///< of them on a side of the corners' square
  std::vector<double> lines;    ///< borders of cells, the same in x and in y: n_cells + 1, rising
  std::vector<TagCell> levels;  ///< n_cells x n_cells, by rows, first row on top

  TagCell at(int column, int row) const {
    return levels[static_cast<std::size_t>(row) * static_cast<std::size_t>(n_cells) +
                  static_cast<std::size_t>(column)];
  }
};

/// The corners in a tag's frame in the order of the AprilTag library: bottom left, bottom right,
/// top right, top left; counter-clockwise as seen from the front.
inline std::array<Eigen::Vector2d, 4> tag_corners() {
  return {Eigen::Vector2d(-0.5, 0.5),
          Eigen::Vector2d(0.5, 0.5),
          Eigen::Vector2d(0.5, -0.5),
          Eigen::Vector2d(-0.5, -0.5)};
}

/// A family of tags: one layout, many codes.
struct TagFamily {
  struct Bit {
    int column = 0;  ///< in the grid of TagPattern
    int row = 0;
  };

  std::string_view name;
  int n_cells = 0;
  int n_on_side = 0;
  /// White frame on black ground instead of a black one on white.
  bool is_reversed = false;
  int hamming_distance = 0;          ///< least number of bits in which two of its tags differ
  std::vector<Bit> bits;             ///< places of a code's bits, the most significant one first
  std::vector<std::uint64_t> codes;  ///< by id

  int n_tags() const { return static_cast<int>(codes.size()); }
  /// The grid without any code: data bits are `Any`.
  TagPattern blank() const;
  /// Precondition: 0 <= id < n_tags().
  TagPattern pattern(int id) const;
};

/// The family of that name, with the codes as the AprilTag library has them.
///
/// Out    empty if there is no such family
/// Cost   1 us to 0.1 ms: copies the codes, up to 65,535 of them
/// Source Olson 2011; Krogius, Haggenmiller and Olson 2019 (layouts other than a black frame)
/// See    tests/vision/tag/family_test.cc
std::optional<TagFamily> find_tag_family(std::string_view name);

/// One tag's pattern; empty if there is no such family or id.
std::optional<TagPattern> tag_pattern(std::string_view family, int id);

}  // namespace panelcal
