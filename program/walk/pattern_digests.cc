// SPDX-License-Identifier: Apache-2.0
#include "program/walk/pattern_digests.h"

#include "calib/base/files/digest.h"

namespace panelcal {

const std::string& PatternDigests::of(std::string_view file, std::string_view bytes) {
  const auto known = by_file_.find(file);
  if (known != by_file_.end()) return known->second;
  return by_file_.emplace(file, file.empty() ? std::string() : sha256(bytes)).first->second;
}

}  // namespace panelcal
