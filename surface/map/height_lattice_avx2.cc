// SPDX-License-Identifier: Apache-2.0
// Heights of four places at once. Every operation is one of height_lattice.cc's, on the same
// numbers, in the same order and never fused with another: so the heights are the same to the bit.
#include <cstddef>
#include <cstdint>
#include <span>

#include "surface/map/height_lattice.h"

#if defined(__x86_64__)

#include <immintrin.h>

// Only these functions may have such instructions: others of this file are any processor's.
#define PANELCAL_AVX2 [[gnu::target("avx2"), gnu::always_inline]] static inline

namespace panelcal {
namespace {

/// Along y or x, HermiteWeights of four places.
struct FourWeights {
  __m256d low, low_slope, high, high_slope;
};

PANELCAL_AVX2 __m256d minus(__m256d value) {
  return _mm256_xor_pd(_mm256_set1_pd(-0.0), value);
}

PANELCAL_AVX2 __m256d magnitude(__m256d value) {
  return _mm256_andnot_pd(_mm256_set1_pd(-0.0), value);
}

/// low + share * (high - low)
PANELCAL_AVX2 __m256d between(__m256d low, __m256d high, __m256d share) {
  return _mm256_add_pd(low, _mm256_mul_pd(share, _mm256_sub_pd(high, low)));
}

/// (a b + c d) + (e f + g h)
PANELCAL_AVX2 __m256d sum_of_products(
    __m256d a, __m256d b, __m256d c, __m256d d, __m256d e, __m256d f, __m256d g, __m256d h) {
  return _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(a, b), _mm256_mul_pd(c, d)),
                       _mm256_add_pd(_mm256_mul_pd(e, f), _mm256_mul_pd(g, h)));
}

PANELCAL_AVX2 FourWeights weights_at(__m256d t) {
  const __m256d one = _mm256_set1_pd(1);
  const __m256d rest = _mm256_sub_pd(one, t);
  const __m256d steep = _mm256_sub_pd(_mm256_set1_pd(3), _mm256_mul_pd(_mm256_set1_pd(2), t));
  FourWeights out;
  out.high = _mm256_mul_pd(_mm256_mul_pd(t, t), steep);
  out.low = _mm256_sub_pd(one, out.high);
  out.low_slope = _mm256_mul_pd(_mm256_mul_pd(t, rest), rest);
  out.high_slope = _mm256_mul_pd(_mm256_mul_pd(minus(t), t), rest);
  return out;
}

/// Two nodes' worth of doubles from two places each.
PANELCAL_AVX2 __m256d two_and_two(const double* a, const double* b) {
  return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(a)), _mm_loadu_pd(b), 1);
}

}  // namespace

/// Cells and coordinates of four places, in the order 0, 2, 1, 3: so pairs of doubles are told
/// apart at once.
struct HeightLattice::Fours {
  __m256d u, v;
  __m256d cell;
  __m256d is_outside;  // all bits or none
  std::size_t node[4];

  struct Nodes {
    const double* heights_mm;  // if bicubic, with slopes along x
    const double* slopes_mm;
    std::size_t n_x;
  };

  PANELCAL_AVX2 Fours at(const Finder& finder, const double* places_mm) {
    const __m256d a = _mm256_loadu_pd(places_mm), b = _mm256_loadu_pd(places_mm + 4);
    const __m256d x =
        _mm256_mul_pd(_mm256_sub_pd(_mm256_unpacklo_pd(a, b), _mm256_set1_pd(finder.first_x_mm)),
                      _mm256_set1_pd(finder.cells_per_x_mm));
    const __m256d y =
        _mm256_mul_pd(_mm256_sub_pd(_mm256_unpackhi_pd(a, b), _mm256_set1_pd(finder.first_y_mm)),
                      _mm256_set1_pd(finder.cells_per_y_mm));
    // Of a number that is not finite, the second one is the larger.
    const __m256d zero = _mm256_setzero_pd();
    const __m256d x_inside =
        _mm256_min_pd(_mm256_max_pd(x, zero), _mm256_set1_pd(finder.below_n_columns));
    const __m256d y_inside =
        _mm256_min_pd(_mm256_max_pd(y, zero), _mm256_set1_pd(finder.below_n_rows));
    constexpr int kDown = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC;
    const __m256d i = _mm256_round_pd(x_inside, kDown), j = _mm256_round_pd(y_inside, kDown);
    const __m256d n_columns = _mm256_set1_pd(static_cast<double>(finder.n_columns));
    const __m256d off =
        _mm256_add_pd(magnitude(_mm256_sub_pd(x, x_inside)), magnitude(_mm256_sub_pd(y, y_inside)));
    Fours out;
    out.u = _mm256_sub_pd(x_inside, i);
    out.v = _mm256_sub_pd(y_inside, j);
    // Exact: there are no more nodes than int counts.
    out.cell = _mm256_add_pd(_mm256_mul_pd(j, n_columns), i);
    out.is_outside = _mm256_cmp_pd(off, _mm256_set1_pd(Finder::kSameNode), _CMP_NLE_UQ);
    unpack(_mm256_cvttpd_epi32(_mm256_add_pd(out.cell, j)), out.node);
    return out;
  }

  PANELCAL_AVX2 void unpack(__m128i four, std::size_t (&out)[4]) {
    const auto low = static_cast<std::uint64_t>(_mm_cvtsi128_si64(four));
    const auto high = static_cast<std::uint64_t>(_mm_extract_epi64(four, 1));
    out[0] = low & 0xffffffff;
    out[1] = low >> 32;
    out[2] = high & 0xffffffff;
    out[3] = high >> 32;
  }

  PANELCAL_AVX2 __m256d bilinear_mm(const Fours& at, const Nodes& nodes) {
    const double* const first = nodes.heights_mm;
    const double* const second = first + nodes.n_x;
    const __m256d low_a = two_and_two(first + at.node[0], first + at.node[2]);
    const __m256d low_b = two_and_two(first + at.node[1], first + at.node[3]);
    const __m256d high_a = two_and_two(second + at.node[0], second + at.node[2]);
    const __m256d high_b = two_and_two(second + at.node[1], second + at.node[3]);
    const __m256d low_mm =
        between(_mm256_unpacklo_pd(low_a, low_b), _mm256_unpackhi_pd(low_a, low_b), at.u);
    const __m256d high_mm =
        between(_mm256_unpacklo_pd(high_a, high_b), _mm256_unpackhi_pd(high_a, high_b), at.u);
    return between(low_mm, high_mm, at.v);
  }

  /// One place's (height, slope, height, slope) of the two columns: weights are its four along y.
  PANELCAL_AVX2 __m256d columns_mm(const Nodes& nodes, std::size_t node, const double* weights) {
    const double* const heights_mm = nodes.heights_mm + 2 * node;
    const double* const slopes_mm = nodes.slopes_mm + 2 * node;
    return sum_of_products(_mm256_broadcast_sd(weights),
                           _mm256_loadu_pd(heights_mm),
                           _mm256_broadcast_sd(weights + 4),
                           _mm256_loadu_pd(slopes_mm),
                           _mm256_broadcast_sd(weights + 8),
                           _mm256_loadu_pd(heights_mm + 2 * nodes.n_x),
                           _mm256_broadcast_sd(weights + 12),
                           _mm256_loadu_pd(slopes_mm + 2 * nodes.n_x));
  }

  PANELCAL_AVX2 __m256d bicubic_mm(const Fours& at, const Nodes& nodes) {
    const FourWeights x = weights_at(at.u), y = weights_at(at.v);
    alignas(32) double by_place[16];
    _mm256_store_pd(by_place, y.low);
    _mm256_store_pd(by_place + 4, y.low_slope);
    _mm256_store_pd(by_place + 8, y.high);
    _mm256_store_pd(by_place + 12, y.high_slope);
    const __m256d a = columns_mm(nodes, at.node[0], by_place);
    const __m256d b = columns_mm(nodes, at.node[1], by_place + 1);
    const __m256d c = columns_mm(nodes, at.node[2], by_place + 2);
    const __m256d d = columns_mm(nodes, at.node[3], by_place + 3);
    const __m256d ab_heights = _mm256_unpacklo_pd(a, b), ab_slopes = _mm256_unpackhi_pd(a, b);
    const __m256d cd_heights = _mm256_unpacklo_pd(c, d), cd_slopes = _mm256_unpackhi_pd(c, d);
    constexpr int kFirstColumns = 0x20, kSecondColumns = 0x31;
    return sum_of_products(x.low,
                           _mm256_permute2f128_pd(ab_heights, cd_heights, kFirstColumns),
                           x.low_slope,
                           _mm256_permute2f128_pd(ab_slopes, cd_slopes, kFirstColumns),
                           x.high,
                           _mm256_permute2f128_pd(ab_heights, cd_heights, kSecondColumns),
                           x.high_slope,
                           _mm256_permute2f128_pd(ab_slopes, cd_slopes, kSecondColumns));
  }

  /// Copies of what is looked up in, since a height that is written might change an original.
  template <bool kIsBicubic, bool kHasMarks>
  [[gnu::target("avx2")]] static bool all(Finder finder,
                                          Nodes nodes,
                                          std::span<const Eigen::Vector2d> places_mm,
                                          double* heights_mm,
                                          const std::uint8_t* cell_marks) {
    __m256d is_outside = _mm256_setzero_pd();
    unsigned marks = 0;
    for (std::size_t k = 0; k < places_mm.size(); k += 4) {
      const Fours at = Fours::at(finder, places_mm[k].data());
      const __m256d found_mm = kIsBicubic ? bicubic_mm(at, nodes) : bilinear_mm(at, nodes);
      _mm256_storeu_pd(heights_mm + k, _mm256_permute4x64_pd(found_mm, _MM_SHUFFLE(3, 1, 2, 0)));
      is_outside = _mm256_or_pd(is_outside, at.is_outside);
      if constexpr (kHasMarks) {
        std::size_t cell[4];
        unpack(_mm256_cvttpd_epi32(at.cell), cell);
        for (const std::size_t i : cell) marks |= cell_marks[i];
      }
    }
    return _mm256_movemask_pd(is_outside) != 0 || marks != 0;
  }
};

std::size_t HeightLattice::heights_in_fours(std::span<const Eigen::Vector2d> places_mm,
                                            double* heights_mm,
                                            const std::uint8_t* cell_marks,
                                            bool& is_due) const {
  if (!__builtin_cpu_supports("avx2")) return 0;
  const auto fours = places_mm.first(places_mm.size() / 4 * 4);
  const bool is_bicubic = nodes_mm_.empty();
  const Fours::Nodes nodes = {
      (is_bicubic ? heights_mm_ : nodes_mm_).data(), slopes_mm_.data(), n_columns_ + 1};
  const auto all = is_bicubic ? (cell_marks ? Fours::all<true, true> : Fours::all<true, false>)
                              : (cell_marks ? Fours::all<false, true> : Fours::all<false, false>);
  if (all(finder_, nodes, fours, heights_mm, cell_marks)) is_due = true;
  return fours.size();
}

}  // namespace panelcal

#else

namespace panelcal {

std::size_t HeightLattice::heights_in_fours(std::span<const Eigen::Vector2d>,
                                            double*,
                                            const std::uint8_t*,
                                            bool&) const {
  return 0;
}

}  // namespace panelcal

#endif
