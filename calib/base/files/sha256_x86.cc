// SPDX-License-Identifier: Apache-2.0
#include "calib/base/files/sha256_x86.h"

#if defined(__x86_64__)

#include <array>

#include <cpuid.h>
#include <immintrin.h>

namespace panelcal::internal {
namespace {

constexpr std::size_t kSha256BlockBytes = 64;

/// The round constants (FIPS 180-4, 4.2.2).
alignas(16) constexpr std::array<std::uint32_t, 64> kSha256Rounds = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

bool has_sha_instructions() {
  constexpr unsigned kFeatures = 7;
  constexpr unsigned kSha = 1U << 29U;  // in EBX
  unsigned eax = 0;
  unsigned ebx = 0;
  unsigned ecx = 0;
  unsigned edx = 0;
  if (__get_cpuid_count(kFeatures, 0, &eax, &ebx, &ecx, &edx) == 0) return false;
  return (ebx & kSha) != 0 && __builtin_cpu_supports("sse4.1");
}

const __m128i* vector_at(const void* address) {
  return static_cast<const __m128i*>(address);
}

/// The instructions want the state as (A B E F) and (C D G H), most significant word first.
[[gnu::target("sha,sse4.1")]] void take_blocks_by_sha(const char* at,
                                                      std::size_t n_blocks,
                                                      std::span<std::uint32_t, 8> state) {
  const __m128i words_from_bytes = _mm_set_epi64x(0x0c0d0e0f08090a0b, 0x0405060700010203);
  const __m128i cdab = _mm_shuffle_epi32(_mm_loadu_si128(vector_at(&state[0])), 0xB1);
  const __m128i efgh = _mm_shuffle_epi32(_mm_loadu_si128(vector_at(&state[4])), 0x1B);
  __m128i abef = _mm_alignr_epi8(cdab, efgh, 8);
  __m128i cdgh = _mm_blend_epi16(efgh, cdab, 0xF0);
  for (; n_blocks > 0; --n_blocks, at += kSha256BlockBytes) {
    const __m128i abef_before = abef;
    const __m128i cdgh_before = cdgh;
    __m128i w[4];  // the last sixteen words of the schedule, a ring of four vectors
#pragma GCC unroll 16
    for (int i = 0; i < 16; ++i) {
      __m128i& next = w[i % 4];
      if (i < 4) {
        next = _mm_shuffle_epi8(_mm_loadu_si128(vector_at(at + 16 * i)), words_from_bytes);
      } else {
        const __m128i seven_back = _mm_alignr_epi8(w[(i + 3) % 4], w[(i + 2) % 4], 4);
        const __m128i sum = _mm_add_epi32(_mm_sha256msg1_epu32(next, w[(i + 1) % 4]), seven_back);
        next = _mm_sha256msg2_epu32(sum, w[(i + 3) % 4]);
      }
      const __m128i added = _mm_add_epi32(next, _mm_load_si128(vector_at(&kSha256Rounds[4 * i])));
      cdgh = _mm_sha256rnds2_epu32(cdgh, abef, added);
      abef = _mm_sha256rnds2_epu32(abef, cdgh, _mm_shuffle_epi32(added, 0x0E));
    }
    abef = _mm_add_epi32(abef, abef_before);
    cdgh = _mm_add_epi32(cdgh, cdgh_before);
  }
  const __m128i feba = _mm_shuffle_epi32(abef, 0x1B);
  const __m128i dchg = _mm_shuffle_epi32(cdgh, 0xB1);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(&state[0]), _mm_blend_epi16(feba, dchg, 0xF0));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(&state[4]), _mm_alignr_epi8(dchg, feba, 8));
}

}  // namespace

std::size_t take_sha256_blocks(std::string_view bytes, std::span<std::uint32_t, 8> state) {
  if (!has_sha_instructions()) return 0;
  const std::size_t n_blocks = bytes.size() / kSha256BlockBytes;
  take_blocks_by_sha(bytes.data(), n_blocks, state);
  return n_blocks * kSha256BlockBytes;
}

}  // namespace panelcal::internal

#else

namespace panelcal::internal {

std::size_t take_sha256_blocks(std::string_view, std::span<std::uint32_t, 8>) {
  return 0;
}

}  // namespace panelcal::internal

#endif
