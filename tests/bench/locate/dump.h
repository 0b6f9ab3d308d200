// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "vision/picture/image.h"

namespace panelcal::bench {

/// Writes DIR/WHAT_INDEX.png; does nothing if the folder's name is empty. Throws if it cannot.
void dump_picture(const std::string& dir, const Image& image, const std::string& what, int index);

}  // namespace panelcal::bench
