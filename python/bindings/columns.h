// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "program/model/operation.h"
#include "python/bindings/convert.h"

namespace panelcal::python {

/// Operations as columns of numbers, a row for each: a slot has two, the second one for its end.
/// 93 bytes a row.
class OperationColumns final : public OperationSink {
 public:
  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

  /// The columns as arrays, which own them. Precondition: called once
  py::dict take();

 private:
  /// A row; its numbers are NaN, but what is known.
  ///
  /// In     at: null where the operation has no place
  void add(std::string_view op, const Operation& operation, int tool, const PlacedPoint* at);

  std::vector<std::string> ops_;  ///< words that `op_` numbers
  std::map<std::string, std::uint8_t, std::less<>> i_op_;
  std::vector<InstancePath> boards_;
  std::map<InstancePath, std::uint32_t> i_board_;
  double diameter_mm_ = 0;  ///< of the tool in force

  std::vector<std::uint8_t> op_;
  std::vector<std::int32_t> line_, tool_;
  std::vector<std::uint32_t> board_;
  std::vector<double> diameters_mm_, nominal_mm_, actual_mm_, cov_mm2_, risk_;
};

}  // namespace panelcal::python
