// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "program/geometry/bounding_box.h"
#include "program/model/operation.h"

namespace panelcal::svg {

/// Part of each step-and-repeat instance that is drilled, for up to kMost instances.
///
/// Instances of different sections are the same one if path and placement agree: a panel is
/// usually stepped once for each tool.
class Instances {
 public:
  static constexpr std::size_t kMost = 2000;

  /// Takes in a disc around a place of `operation`.
  void add(const Operation& operation, const PlacedPoint& place, double radius_mm);

  std::size_t n() const { return boxes_.size(); }
  bool is_complete() const { return is_complete_; }
  /// Path data of a frame around each one; those of a single place have none.
  std::string frames() const;

 private:
  /// Path, and the placement in its last digits.
  using Key = std::pair<InstancePath, std::array<std::int64_t, 6>>;
  struct Worked {
    BoundingBox<frame::Actual> box;
    std::int64_t n_places = 0;
  };

  std::map<Key, Worked> boxes_;
  Key last_key_;
  Worked* last_ = nullptr;  ///< of last_key_; null if there is no room for it
  bool is_complete_ = true;
};

}  // namespace panelcal::svg
