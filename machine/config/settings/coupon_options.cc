// SPDX-License-Identifier: Apache-2.0
#include "machine/config/settings/coupon_options.h"

namespace panelcal {

std::string text(const Approach& approach) {
  std::string text;
  if (approach.x != 0) text += approach.x > 0 ? "+x" : "-x";
  if (approach.y != 0) text += approach.y > 0 ? "+y" : "-y";
  return text;
}

std::optional<Approach> approach_from_text(std::string_view written) {
  for (const int x : {-1, 0, 1}) {
    for (const int y : {-1, 0, 1}) {
      const Approach approach{x, y};
      if (text(approach) == written && !written.empty()) return approach;
    }
  }
  return std::nullopt;
}

}  // namespace panelcal
