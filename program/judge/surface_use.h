// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "calib/base/diagnostic.h"
#include "calib/base/units.h"
#include "program/model/operation.h"
#include "program/walk/survey.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

/// Counts the depths of a job that count from a map (--surface), and how well it knows them.
class SurfaceUse final : public OperationSink {
 public:
  void put(const Operation& operation) override;

  std::int64_t n_depths() const { return n_depths_; }
  /// `12 depths count from the map, ...`; pieces of contours count each.
  std::string summary() const;

 private:
  void add(const Operation& operation, const DepthOfCut& cut);

  std::int64_t n_depths_ = 0;
  std::int64_t n_filled_ = 0;
  std::int64_t n_extrapolated_ = 0;
  std::int64_t n_in_void_ = 0;
  Length lowest_;
  Length highest_;
  Length largest_sigma_;
  int line_of_largest_sigma_ = 0;
  std::string file_of_largest_sigma_;
};

/// Holds what a job has probed by itself against a map that was made before: another board, or
/// another zero, would be drilled to wrong depths wherever the map is counted on.
///
/// A probe contradicts the map if it is off by more than five sigmas of probe and map together;
/// probes that the map does not reach say nothing. The worst one is named.
///
/// Fails  into the log: surface-out-of-tolerance
/// See    tests/program/judge/surface_use_test.cc
void hold_against_map(const Survey& survey,
                      const ZonedMap& map,
                      const std::string& file,
                      DiagnosticLog& log);

}  // namespace panelcal
