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
  int quarters = 0;     ///< quad.turned(quarters) has its corners in the tag's order
  double contrast = 0;  ///< white minus black, grey levels; negative if inverted
};

/// How many wrong bits a reading may have: 4 where the tool names an id, 1 where any tag will do;
/// fewer in families in which chance would make tags of that.
///
/// Cells of no tag that pass for a frame read as one of n ids in one of four turns with probability
///
///   P = 4 n sum_k<=w C(bits, k) / 2^bits,    w wrong bits allowed,
///
/// since all words are equally likely. For tag36h11 (36 bits, 587 tags, Hamming distance 11) that
/// is 1.3e-6 with w = 1 and any id, 3.9e-6 with w = 4 and one id; 16 frames a picture at most make
/// 6e-5. Counted on 10^7 random words (tests/vision/tag/reader_test.cc): 1.2e-6 and 3.9e-6. The
/// frame's own cells, of which four fifths must be right, are a factor of 1e-7 on top for grids
/// whose frame is random too. w is the largest up to 4 or 1 with P <= 2e-4 and 2 w < distance: two
/// tags are never taken for each other. tag25h9 reads 2 with an id, 1 without; tag16h5 none.
int tolerable_wrong_bits(const TagFamily& family, bool id_is_named);

/// The tag whose code is nearest to a word, with no more wrong bits than tolerable.
///
/// In     words: the cells' bits as they are for a tag turned by 0 to 3 quarters; id: as above
std::optional<TagReading> decoded(const TagFamily& family,
                                  const std::array<std::uint64_t, 4>& words,
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
