// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/detection.h"
#include "vision/fit/detector.h"

namespace panelcal::internal {

/// Adds to the reason of a refusal what is in the picture instead: a mark that is the target but
/// for its polarity, size or shape, or a picture that uses a small part of its range.
///
/// In     detection: refused
/// Out    its reason is longer, or the same if there is nothing to say; size_ratio, if the mark is
///        the target but for its size
/// Cost   that of find_marks() on the searched part of the picture, with half of the levels: good
///        pictures do not pay it
/// See    tests/vision/suggest/explain_test.cc
void explain(const DetectorInput& input, Detection& detection);

}  // namespace panelcal::internal
