// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "program/text/number_format.h"

namespace panelcal::excellon {

/// A number format as a CAM system states it in a comment.
struct CommentFormat {
  std::optional<std::pair<int, int>> digits;  ///< before and behind the point
  std::optional<LengthUnit> unit;
  std::optional<Zeros> zeros;
  std::optional<bool> is_incremental;
  std::string unknown;  ///< a part that says nothing known, of a comment that states digits

  static constexpr const char* kExpected =
      "digits, Absolute or Incremental, MM or Inch, Leading, Trailing or None";
};

/// Reads `;FILE_FORMAT=4:4` (Altium, EasyEDA), `; FORMAT={3:3/ absolute / metric / suppress leading
/// zeros}` (KiCad) and `; Format  : 3.3 / Absolute / MM / Leading` (Mentor, which names the zeros
/// that it leaves off). Digits that each number states itself, `-:-`, are absent.
///
/// See    tests/program/excellon/text/comment_format_test.cc
CommentFormat read_comment_format(std::string_view comment);

}  // namespace panelcal::excellon
