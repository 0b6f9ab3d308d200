// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/sections/copies.h"

namespace panelcal::sieb_meyer {

SectionContent& SectionContent::operator|=(const SectionContent& other) {
  measurements |= other.measurements;
  calls |= other.calls;
  own_copies |= other.own_copies;
  old_feed |= other.old_feed && !feeds;
  feeds |= other.feeds;
  return *this;
}

std::int64_t Section::n_copies() const {
  std::int64_t n = 0;
  for (const CopyRow& row : rows) n += row.count;
  return n;
}

Eigen::Matrix2d offset_orientation(bool turned, bool mirror_x, bool mirror_y) {
  Eigen::Matrix2d mirror;
  mirror << (mirror_x ? -1 : 1), 0, 0, (mirror_y ? -1 : 1);
  if (!turned) return mirror;
  // A mirrored program turns the other way: the worked positions of M60M70 and M60M80 are a
  // quarter turn clockwise behind one mirror.
  Eigen::Matrix2d quarter;
  const double sense = mirror_x != mirror_y ? -1 : 1;
  quarter << 0, -sense, sense, 0;
  return quarter * mirror;
}

}  // namespace panelcal::sieb_meyer
