// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "vision/picture/image.h"
#include "vision/tag/family.h"
#include "vision/tag/quads.h"

namespace panelcal::internal {

/// The reading of the cells of a quad.
struct TagReading {
  int id = 0;
  int wrong_bits = 0;   ///< bits that are not the tag's
  int unseen_bits = 0;  ///< covered by something that is neither black nor white
  int quarters = 0;     ///< quad.turned(quarters) has its corners in the tag's order
  double contrast = 0;  ///< white minus black, grey levels; negative if inverted
};

/// The cells of a quad as a code's bits, the most significant one first.
struct TagWord {
  std::uint64_t bits = 0;
  std::uint64_t is_seen = 0;  ///< 0 where something that is neither black nor white covers the cell
};

/// Number of the bits seen that may be wrong: 4 where the tool names an id, 1 where any tag will
/// do; fewer where chance would make tags of that; -1: too few are seen.
///
/// Cells of no tag that pass for a frame read as one of n tags in one of four turns with
/// probability
///
///   P = 4 n sum_k<=w C(b, k) / 2^b,    b bits seen, w wrong ones allowed,
///
/// since all words are equally likely; w is the largest with P <= 2e-4 and 2 w < Hamming distance.
/// For tag36h11 (b = 36, n = 587, distance 11) P is 1.3e-6 with w = 1 and any id, 3.9e-6 with w = 4
/// and one id; with 8 cells covered w = 3 and P = 5.5e-5. The frame's own 64 cells, of which four
/// fifths must be right, are a factor of 1e-6 on top for grids that are random all over.
/// tests/vision/tag/reader_test.cc counts P on random words.
int tolerable_wrong_bits(const TagFamily& family, bool id_is_named, int n_seen);

/// The tag whose code is nearest to a word, with no more wrong bits than tolerable. If any bit is
/// wrong or covered, every other tag must be farther off by three bits: tags of one family are not
/// taken for each other.
///
/// In     words: the cells as they are for a tag turned by 0 to 3 quarters; id: the one asked for
std::optional<TagReading> decoded(const TagFamily& family,
                                  const std::array<TagWord, 4>& words,
                                  std::optional<int> id);

/// Reads a quad: planes are fitted to the black and the white cells of the frame, and bits are told
/// by which of the two they are nearer to.
///
/// In     id: the tag asked for, if any: it may have more wrong bits than others
/// Out    empty if the frame does not look like one, if the quad leaves the picture, or if the bits
///        are not those of any tag
/// Cost   0.1 ms; 1 ms for families of 50,000 tags
std::optional<TagReading> read_tag(const Image& image,
                                   const TagFamily& family,
                                   const TagQuad& quad,
                                   bool is_inverted,
                                   std::optional<int> id = std::nullopt);

}  // namespace panelcal::internal
