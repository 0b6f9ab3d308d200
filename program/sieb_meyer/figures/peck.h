// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace panelcal::sieb_meyer {

/// The strokes of a peck drilled hole below the lowering value.
struct PeckStrokes {
  std::vector<double> strokes_mm;  ///< > 0, each from where the one before ended
  bool reaches_target = false;     ///< otherwise the machine reports, or drills on with PEKM,D
  double remaining_mm = 0;         ///< from the last stroke's end to the target; 0 if it is reached
};

/// G81: partial strokes that become shorter and shorter.
///
///   stroke n = J (W / 1000)^(n - 1), whole um (the rest is cut off), the last one limited by the
///   target plane; a stroke below 1 um ends the drilling before the target is reached
///
/// The table of G81 shows the cut. That of W cuts the same way but subtracts wrongly in its sixth
/// and seventh rows.
///
/// In     distance_mm: from the lowering value I down to the working plane Z or K, >= 0
///        first_stroke_mm: J, > 0; factor_permille: W, 0 to 1000
/// Out    at most 100000 strokes; none if distance_mm is 0
/// Fails  other signs or factors; more strokes
/// Source SIEB & MEYER manual, G81; W: Reduce Height of Partial Strokes; semantics page
/// See    tests/program/sieb_meyer/figures/peck_test.cc
tl::expected<PeckStrokes, std::string> peck_strokes(double distance_mm,
                                                    double first_stroke_mm,
                                                    double factor_permille);

}  // namespace panelcal::sieb_meyer
