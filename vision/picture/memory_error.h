// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>

// Not installed.
namespace panelcal::internal {

/// Throws std::bad_alloc where `error` is one or OpenCV's own form of it, so that a picture for
/// which the memory does not suffice never passes for one without a target.
void rethrow_memory_error(const std::exception& error);

}  // namespace panelcal::internal
