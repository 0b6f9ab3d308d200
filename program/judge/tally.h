// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "calib/correction/max_sigma.h"
#include "program/geometry/bounding_box.h"
#include "program/model/operation.h"

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
  using CountByTool = std::map<int, std::int64_t>;

  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

  const std::map<int, Tool>& tools() const { return tools_; }
  std::vector<int> tools_used() const;  ///< the tools that worked, by number

  const CountByTool& holes_by_tool() const { return holes_.by_tool; }
  const CountByTool& slots_by_tool() const { return slots_.by_tool; }  ///< drilled or routed whole
  const CountByTool& routs_by_tool() const { return routs_.by_tool; }  ///< lines and arcs
  std::int64_t n_holes() const { return holes_.n; }
  std::int64_t n_slots() const { return slots_.n; }
  std::int64_t n_routs() const { return routs_.n; }
  Length routed_length() const { return routed_length_; }  ///< of corrected lines and arcs

  // Over holes, the ends of slots, and routs with their starts.
  /// Between nominal and corrected.
  Length max_shift() const { return mm(std::sqrt(max_square_shift_mm2_)); }
  Length max_sigma() const { return max_sigma_.value(); }  ///< largest principal one
  const BoundingBox<frame::Nominal>& nominal_box() const { return nominal_box_; }
  /// Arcs count with their bulges, without the tool's width.
  const BoundingBox<frame::Actual>& corrected_box() const { return corrected_box_; }

  /// Every k-th hole, k a power of two, at most kSample of them.
  const std::vector<HoleMark>& sample() const { return sample_; }

 private:
  /// Counts without looking for the tool each time.
  class Counter {
   public:
    Counter() = default;
    Counter(const Counter& other) : by_tool(other.by_tool), n(other.n) {}
    Counter& operator=(const Counter& other) {
      by_tool = other.by_tool;
      n = other.n;
      count_ = nullptr;  // it belongs to the other one
      return *this;
    }

    void add(int tool) {
      if (count_ == nullptr || tool != tool_) take(tool);
      ++*count_;
      ++n;
    }

    CountByTool by_tool;
    std::int64_t n = 0;

   private:
    [[gnu::noinline]] void take(int tool) {
      tool_ = tool;
      count_ = &by_tool[tool];
    }

    std::int64_t* count_ = nullptr;  ///< of tool_, in by_tool
    int tool_ = 0;
  };

  void put_place(const PlacedPoint& place);
  /// Every hole asks, so without a division.
  bool is_sampled(std::int64_t index) const { return (index & (stride_ - 1)) == 0; }
  void put_hole(const Drill& drill);
  [[gnu::noinline]] void keep_sample(std::int64_t index, const Drill& drill);
  void put_slot(int tool, const PlacedPoint& start, const PlacedPoint& end);
  void put_rout(const Rout& rout);

  std::map<int, Tool> tools_;
  Counter holes_;
  Counter slots_;
  Counter routs_;
  PlacedPoint router_;  ///< place of the router
  Length routed_length_;
  double max_square_shift_mm2_ = 0;
  MaxSigma max_sigma_;
  BoundingBox<frame::Nominal> nominal_box_;
  BoundingBox<frame::Actual> corrected_box_;
  std::vector<HoleMark> sample_;
  std::int64_t stride_ = 1;  ///< a power of two
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
