// SPDX-License-Identifier: Apache-2.0
// Draws of random SIEB & MEYER programs.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include <rapidcheck.h>

#include "tests/program/sieb_meyer/random_sm_job.h"

namespace panelcal::test {

/// Of the whole range in every case; RapidCheck's own ranges grow with the number of cases.
inline int any(int low, int high) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(low, high + 1));
}

/// Shrinks to false.
inline bool one_in(int n) {
  return any(1, n) == n;
}

/// Shrinks to zero.
inline long any_either_way(int most) {
  const int n = any(0, 2 * most);
  return n % 2 == 0 ? n / 2 : -(n + 1) / 2;
}

template <std::size_t N>
std::string any_of(const std::array<const char*, N>& words) {
  return words[static_cast<std::size_t>(any(0, static_cast<int>(N) - 1))];
}

/// In 0.001 mm; whole millimetres now and then, which lose most digits.
inline Microns any_place(int most_um = 200'000) {
  const int grid = one_in(3) ? 1000 : 1;
  const long x = any_either_way(most_um / grid) * grid;
  return {x, any_either_way(most_um / grid) * grid};
}

inline double norm(Microns p) {
  return std::hypot(static_cast<double>(p.x), static_cast<double>(p.y));
}

/// Between the two lines at a corner, 0 to pi.
inline double angle_at(Microns before, Microns corner, Microns after) {
  const Microns a = before - corner;
  const Microns b = after - corner;
  const double dot = static_cast<double>(a.x) * static_cast<double>(b.x) +
                     static_cast<double>(a.y) * static_cast<double>(b.y);
  return std::acos(std::clamp(dot / (norm(a) * norm(b)), -1.0, 1.0));
}

}  // namespace panelcal::test
