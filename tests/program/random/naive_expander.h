// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace panelcal::test {

/// A point in whole steps of 0.0001 inch, so that nothing is ever rounded.
struct Steps {
  long x = 0;
  long y = 0;
  friend bool operator==(const Steps&, const Steps&) = default;
};

/// The holes of a program body, in order, worked out in the plainest way: each M01 keeps the list
/// of all that came before and appends a changed copy of the list for every copy asked for.
///
/// Knows X, Y (with decimal points), R#, G90, G91, M25, M01, M02, R#M02, M70, M80, M90, M08; every
/// other line drills nothing. Shares no code with panelcal.
std::vector<Steps> naive_holes(const std::string& body);

}  // namespace panelcal::test
