// SPDX-License-Identifier: Apache-2.0
// Content and copies of a section.
#pragma once

#include <cstdint>
#include <vector>

#include "program/text/source_text.h"
#include <Eigen/Core>

namespace panelcal::sieb_meyer {

/// Equally spaced copies of a section, all turned the same way. Programmed coordinates.
struct CopyRow {
  int line = 0;
  Eigen::Matrix2d orientation = Eigen::Matrix2d::Identity();
  Eigen::Vector2d first_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d last_mm = Eigen::Vector2d::Zero();
  std::int64_t count = 1;

  /// Zero point of copy i.
  Eigen::Vector2d offset_mm(std::int64_t i) const {
    if (count == 1) return first_mm;
    return first_mm +
           (last_mm - first_mm) * (static_cast<double>(i) / static_cast<double>(count - 1));
  }
};

/// The facts about the lines of a section that a walk needs before it runs them.
struct SectionContent {
  bool measurements = false;  ///< by camera or probe, or perhaps by a subprogram
  bool calls = false;         ///< of subprograms
  bool own_copies = false;    ///< that differ: an area, a scale, a turn, or their number in a text
  bool feeds = false;         ///< F
  bool old_feed = false;      ///< something is routed before the first F
  /// Lines behind these.
  SectionContent& operator|=(const SectionContent& other);
};

/// The scope of an offset: lines from an M31 to the first offset line of its level, or all since
/// the last offsets where no bracket is open.
struct Section {
  int parent = -1;           ///< index of the section around it; -1: none
  LinePlace begin;           ///< of the line that opens it, which belongs to it
  std::size_t body_end = 0;  ///< of the first offset line, or behind the closing line
  LinePlace closing;         ///< of the line with its M30, or of its last offset line
  LinePlace after;
  std::vector<CopyRow> rows;  ///< empty: executed once, where it stands
  std::vector<int> children;
  SectionContent has;
  bool is_bracketed = false;
  int layout_line = 0;  ///< of the first call with X or Y of a subprogram of offsets; 0: none

  bool is_offset() const { return !rows.empty(); }
  std::int64_t n_copies() const;
};

/// The linear part of an offset command; `turned` is M60, which comes with at most one other.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 5.5; semantics page, Offset transforms
Eigen::Matrix2d offset_orientation(bool turned, bool mirror_x, bool mirror_y);

}  // namespace panelcal::sieb_meyer
