// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/json/strict_json.h"
#include "surface/map/voids.h"

// Not installed: part of surface/map/file.h, areas of zones and voids.
namespace panelcal::internal {

/// `{"polygon": [[x, y], ...]}` or the like.
std::string area_text(const Area& area);
/// Fails  measurement-file: no area that zones have
Expected<Area> read_zone_area(const nlohmann::json& value,
                              const std::string& name,
                              const std::string& file);

/// One element for each void, but for circles of one name and size in a row, which share one.
std::vector<std::string> void_texts(std::span<const Void> voids);
/// Fails  measurement-file; as Voids::make()
Expected<Voids> read_voids(const StrictObject& top, const std::string& file);

}  // namespace panelcal::internal
