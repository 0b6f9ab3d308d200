// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/diagnostic.h"
#include "vision/fit/detection.h"

namespace panelcal {

/// Finds out over a series of pictures whether all targets are larger or smaller than stated by the
/// same factor: then the vision tool's size is wrong, or the camera's scale.
///
/// See    tests/vision/suggest/common_scale_test.cc
class CommonScale {
 public:
  void add(const Detection& detection);

  /// "all 12 targets measure 2.0 % larger than stated (they differ by 0.1 %): ..."; empty for
  /// fewer than three, or if they do not agree, or agree with what is stated.
  std::optional<std::string> words() const;
  /// The same as scale-suspicious, a warning.
  ///
  /// In     machine: the file that states the sizes
  std::optional<Diagnostic> warning(const std::string& machine) const;

 private:
  std::optional<std::string> problem() const;

  std::vector<double> ratios_;
};

}  // namespace panelcal
