// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/fields/field.h"

// Not installed. What the keys of several tables take.
namespace panelcal::internal {

/// Lengths, angles and so on that no machine exceeds: what is larger has the wrong unit.
inline constexpr double kMaxPlace_mm = 1e5;
inline constexpr Range kPlace{-kMaxPlace_mm, kMaxPlace_mm};
inline constexpr Range kAboveZero_um{0, 1e6, true};
inline constexpr int kMaxSeries = 1000;
inline constexpr int kMaxToolNumber = 1'000'000;
inline constexpr int kMaxTagId = 1'000'000;

}  // namespace panelcal::internal
