// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"

// Not installed: part of calib/camera/exchange/lens.h.
namespace panelcal::internal {

/// A value of a file: its texts, one for each element of a list, and its place.
struct LensField {
  std::vector<std::string> texts;
  bool is_list = false;
  Place place;
};

/// Keys of a file with their values; a key within another stands behind a dot.
using LensFields = std::map<std::string, LensField, std::less<>>;

/// The part of YAML that camera models are written in: keys with scalars, lists in brackets or of
/// dashes, maps by indentation or in braces, tags, comments.
///
/// Fails  measurement-file: another construct; a key that is there twice
Expected<LensFields> read_yaml_fields(std::string_view text, const std::string& file);

/// mrcal's text: a Python dictionary of texts, numbers and lists.
///
/// Fails  measurement-file: another construct; a key that is there twice
Expected<LensFields> read_mrcal_fields(std::string_view text, const std::string& file);

}  // namespace panelcal::internal
