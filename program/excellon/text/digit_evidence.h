// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "program/excellon/text/header.h"
#include "program/walk/options.h"
#include "program/walk/reporter.h"
#include <Eigen/Core>

namespace panelcal::excellon {

/// Places of one tool that lie nearer to each other than its diameter.
struct HoleOverlap {
  int n_places = 0;       ///< different ones
  int n_overlapping = 0;  ///< nearer to another place than the diameter
  /// Of these, in a crowd: the places within a diameter spread to two sides. Places of a nibbled
  /// slot, contour or ring lie along a line there.
  int n_crowded = 0;
};

/// Precondition: diameter_mm > 0
/// Cost   O(n log n) for n places
/// See    tests/program/excellon/text/digit_evidence_test.cc
HoleOverlap overlap_of(std::span<const Eigen::Vector2d> places_mm, double diameter_mm);

/// Holds the digits that nothing states, 000.000 or 00.0000, against the program's holes.
///
/// They are contradicted where most holes of a tool, 20 or more, are crowded, and in digits that
/// make coordinates ten times larger (0000.00, 000.00 and inch 00.000) nearly none are, which is
/// then the more likely reading. Where holes overlap along lines alone, they may be a nibble.
///
/// In     text: the program in the manual's characters; header: of it, with the body's unit
/// Out    false: the program is not to be executed
/// Fails  into the reporter: format-ambiguous with both readings and their extents; warns
///        format-assumed where most holes of a tool, 3 or more, overlap along lines
/// Source CNC-7 manual, Inch vs. Metric: the digits that a control has; Metric Measuring Mode: "the
///        digit format you last selected"
/// See    docs/conventions.md, "Number format"; tests/program/excellon/text/digit_evidence_test.cc
bool check_digits(std::string_view text,
                  const Header& header,
                  const ReadOptions& reading,
                  const Reporter& reporter);

}  // namespace panelcal::excellon
