// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "calib/base/diagnostic.h"
#include <tl/expected.hpp>

namespace panelcal {

/// A value, or the diagnostic that says why there is none.
template <class T>
using Expected = tl::expected<T, Diagnostic>;

inline tl::unexpected<Diagnostic> failure(Diagnostic diagnostic) {
  return tl::unexpected<Diagnostic>(std::move(diagnostic));
}

}  // namespace panelcal

#define PANELCAL_CONCAT_INNER(a, b) a##b
#define PANELCAL_CONCAT(a, b) PANELCAL_CONCAT_INNER(a, b)
#define PANELCAL_TRY_INNER(result, target, expression)                \
  auto result = (expression);                                         \
  if (!result) return ::panelcal::failure(std::move(result).error()); \
  target = *std::move(result)

/// `PANELCAL_TRY(auto x, f());` takes f's value or returns f's diagnostic from this function.
#define PANELCAL_TRY(target, expression) \
  PANELCAL_TRY_INNER(PANELCAL_CONCAT(panelcal_try_, __LINE__), target, expression)

/// The same for an Expected<void>.
#define PANELCAL_CHECK(expression)                                                      \
  do {                                                                                  \
    auto panelcal_check = (expression);                                                 \
    if (!panelcal_check) return ::panelcal::failure(std::move(panelcal_check).error()); \
  } while (false)
