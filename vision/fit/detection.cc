// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/detection.h"

#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

Diagnostic bad_option(std::string what, std::string expected) {
  return {Code::TargetInvalid, {}, std::move(what), std::move(expected)};
}

}  // namespace

std::string_view name(DetectionStatus status) {
  switch (status) {
    case DetectionStatus::Found:
      return "found";
    case DetectionStatus::NotFound:
      return "not_found";
    case DetectionStatus::Ambiguous:
      return "ambiguous";
    case DetectionStatus::Rejected:
      return "rejected";
  }
  return {};
}

Expected<void> LocateOptions::validate() const {
  const auto is_share = [](double v) { return v >= 0 && v <= 1; };
  const auto bad_share = [](std::string_view field, double v) {
    return failure(bad_option(fmt::format("{} = {}", field, v), "0 to 1"));
  };
  if (search_radius && !(search_radius->in_px() > 0)) {
    return failure(bad_option(fmt::format("search_radius = {} px", search_radius->in_px()),
                              "a number above 0"));
  }
  if (search_center && !search_center->in_px().allFinite()) {
    return failure(bad_option("search_center is not finite", "a place in the picture"));
  }
  if (!is_share(ambiguity_margin)) return bad_share("ambiguity_margin", ambiguity_margin);
  if (!is_share(min_contrast)) return bad_share("min_contrast", min_contrast);
  if (!is_share(min_score)) return bad_share("min_score", min_score);
  if (!is_share(min_visible)) return bad_share("min_visible", min_visible);
  if (!is_share(max_clipped)) return bad_share("max_clipped", max_clipped);
  if (!is_share(max_oval)) return bad_share("max_oval", max_oval);
  if (!is_share(max_lobes)) return bad_share("max_lobes", max_lobes);
  if (!is_share(max_roughness)) return bad_share("max_roughness", max_roughness);
  if (!(max_blur_px > 0)) {
    return failure(bad_option(fmt::format("max_blur_px = {}", max_blur_px), "a number above 0"));
  }
  return {};
}

}  // namespace panelcal
