// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "panelcal/program/operation.h"

namespace panelcal {

/// A hole as a picture of the job needs it.
struct HoleMark {
  int tool = 0;
  Position<frame::Nominal> nominal;
  Position<frame::Actual> corrected;
};

/// Counts what passes, in constant memory, and keeps a sample of the holes for pictures.
class Tally final : public OperationSink {
 public:
  static constexpr std::size_t kSample = 20000;

  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

  const std::map<int, Tool>& tools() const { return tools_; }
  const std::map<int, std::int64_t>& holes_by_tool() const { return holes_by_tool_; }
  std::int64_t n_holes() const { return n_holes_; }
  Length max_shift() const { return max_shift_; }  ///< between nominal and corrected
  Length max_sigma() const { return max_sigma_; }  ///< largest principal standard deviation
  /// Every k-th hole, k a power of two, at most kSample of them.
  const std::vector<HoleMark>& sample() const { return sample_; }

 private:
  void put_hole(const Drill& drill);

  std::map<int, Tool> tools_;
  std::map<int, std::int64_t> holes_by_tool_;
  std::int64_t n_holes_ = 0;
  Length max_shift_;
  Length max_sigma_;
  std::vector<HoleMark> sample_;
  std::int64_t stride_ = 1;
};

/// Passes every operation to several sinks in turn.
class Tee final : public OperationSink {
 public:
  explicit Tee(std::vector<OperationSink*> sinks) : sinks_(std::move(sinks)) {}
  void begin(const ProgramInfo& info) override {
    for (OperationSink* sink : sinks_) sink->begin(info);
  }
  void put(const Operation& operation) override {
    for (OperationSink* sink : sinks_) sink->put(operation);
  }

 private:
  std::vector<OperationSink*> sinks_;
};

}  // namespace panelcal
