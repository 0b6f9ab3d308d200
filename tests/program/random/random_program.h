// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <rapidcheck.h>

namespace panelcal::test {

/// Lines of a random, valid program body: holes, repeats, both modes, omitted axes, nested step
/// and repeat with mirrors, swaps and bare M02. Inch with decimal points; begins with a hole that
/// names both axes; no tools and no end.
rc::Gen<std::string> random_body();

/// The same with targets of their own in every pattern: a nested series of three, which holes
/// follow, and sometimes a hole at a target (G48).
rc::Gen<std::string> random_vision_body();

}  // namespace panelcal::test
