// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "calib/base/fields/field.h"

// Not installed.
namespace panelcal::internal {

/// A kind of JSON file, for its page and its schema.
struct JsonFile {
  std::string_view name;   ///< "camera.cal.json"
  std::string_view about;  ///< its writers and readers: Markdown
  std::vector<const TableDescription*> versions;
  bool notes_ledger = false;  ///< it may have the member "ledger" of calib/base/fields/noted_head.h
};

}  // namespace panelcal::internal
