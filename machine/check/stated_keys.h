// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "calib/base/diagnostic.h"

namespace panelcal {

/// Places of the keys of a machine.toml, for rules that hold several keys against each other.
///
/// A key is named by its tables: "coupon.pitch_mm", "nightly.gates.min_holes"; a row of an array of
/// tables by the `number` that it states, else by its own, from 0: "vision.tool.7.size_mm".
///
/// See    tests/machine/check/stated_keys_test.cc
class StatedKeys {
 public:
  /// Of a file that cannot be read or is no TOML, no key is stated.
  static StatedKeys of_file(const std::filesystem::path& machine_toml);
  static StatedKeys of_text(std::string_view text, const std::filesystem::path& machine_toml);

  bool has(std::string_view key) const { return places_.contains(key); }
  /// Of the key's value; of its table if it is not stated, and so on; at last of the file.
  Place place(std::string_view key) const;

 private:
  std::string file_;
  std::map<std::string, Place, std::less<>> places_;
};

}  // namespace panelcal
