// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "program/model/operation.h"

namespace panelcal {

/// Every place that a job works at, in columns: holes, ends of slots, corners and starts of routs.
/// 45 bytes a place.
///
/// See    tests/machine/job/summary/place_table_test.cc
class PlaceTable final : public OperationSink {
 public:
  enum class Kind : std::uint8_t { Hole, SlotEnd, RoutCorner };

  /// Forgets the places of an execution before this one.
  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

  std::size_t size() const { return kind.size(); }

  std::vector<std::uint8_t> kind;
  std::vector<double> nominal_x_mm;
  std::vector<double> nominal_y_mm;
  std::vector<float> shift_x_um;  ///< corrected minus nominal
  std::vector<float> shift_y_um;
  std::vector<float> sigma_um;  ///< in the worst direction; 0 without a correction
  std::vector<float> risk;      ///< of breaking the tolerance; NaN where it is not told
  std::vector<std::uint32_t> line;
  std::vector<std::uint32_t> tool;
  std::vector<std::uint32_t> board;  ///< index into boards
  std::vector<std::uint32_t> file;   ///< index into files
  std::vector<InstancePath> boards;
  std::vector<std::string> files;  ///< of stored patterns; the first is empty: the program itself

 private:
  void add(const Operation& operation, Kind kind, int tool, const PlacedPoint& place);

  PlacedPoint router_;
  std::map<InstancePath, std::uint32_t> i_board_;
};

}  // namespace panelcal
