// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include "calib/base/diagnostic.h"
#include "program/model/operation.h"
#include "program/walk/walk.h"

namespace panelcal {

/// Range of the machine's axes.
struct Travel {
  Position<frame::Machine> low;
  Position<frame::Machine> high;
};

/// Watches a whole job pass and finds what no single block shows: tools that nothing uses, feeds
/// that no block sets, compensation without a value (of Excellon; the other language's tools have a
/// diameter), moves outside the travel, and coordinates of a suspicious size.
///
/// The size is held against three things: panels are 1 mm to 2 m, tools 0.03 to 20 mm, and holes
/// that are programmed one after the other do not overlap. Where a factor of 25.4 or a power of ten
/// mends all that is wrong, the warning names it.
class JobCheck final : public OperationSink {
 public:
  explicit JobCheck(std::optional<Travel> travel) : travel_(travel) {}

  void put(const Operation& operation) override;
  /// Reports what was found: tool-unused, feed-missing, compensation-missing,
  /// travel-exceeded, scale-suspicious.
  void report(const Program& program, DiagnosticLog& log) const;

 private:
  struct Outside {
    int line = 0;
    std::string file;
    Position<frame::Machine> place;
  };

  void take(const Tool& tool);
  void see(const Operation& operation, const PlacedPoint& point);
  void see_bulges(const Operation& operation, const Rout& rout);
  void put_rare(const Operation& operation);
  void hold_against_travel(const Operation& operation, const Position<frame::Machine>& place) {
    if (travel_) hold_against(*travel_, operation, place);
  }
  void hold_against(const Travel& travel,
                    const Operation& operation,
                    const Position<frame::Machine>& place);
  void see_compensation(const Operation& operation, const Compensation& compensation);
  void see_hole(const Operation& operation, const Drill& drill);
  [[gnu::noinline]] void drill_with(int tool);
  void report_scale(const Program& program, DiagnosticLog& log) const;

  std::optional<Travel> travel_;
  std::optional<Outside> outside_;
  std::int64_t n_outside_ = 0;
  Eigen::Vector2d router_mm_ = Eigen::Vector2d::Zero();
  Tool tool_;
  int drilling_tool_ = 0;
  std::set<int> used_;
  std::set<std::string> links_;  ///< of tools, as written
  std::set<int> without_infeed_;
  std::set<int> without_table_feed_;
  std::set<int> without_compensation_;
  Place first_without_compensation_;
  Eigen::Vector2d low_mm_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high_mm_ = -low_mm_;
  int last_line_ = 0;
  Eigen::Vector2d last_mm_ = Eigen::Vector2d::Zero();
  std::int64_t n_steps_ = 0;        ///< between holes of different blocks
  std::int64_t n_overlapping_ = 0;  ///< of them shorter than half the tool
};

}  // namespace panelcal
