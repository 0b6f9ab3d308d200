// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "program/model/operation.h"
#include "program/walk/survey.h"

namespace panelcal::plan {

/// A place of the job: a hole, an end of a slot or of a rout move, or a target.
struct PlannedPlace {
  Position<frame::Nominal> nominal;
  int line = 0;
  std::string file;  ///< of a stored pattern; empty: the program itself
  int tool = 0;
  bool is_target = false;
  InstancePath path;
};

/// The same while it passes; views are valid during the call only.
struct PassingPlace {
  const Position<frame::Nominal>& nominal;
  int line = 0;
  std::string_view file;
  int tool = 0;
  std::span<const int> path;
  std::optional<std::size_t> base_series = std::nullopt;
  std::optional<std::size_t> nested_series = std::nullopt;
  bool is_target = false;
  bool is_rout = false;         ///< an end of a rout move
  bool has_own_target = false;  ///< drilled where a target of its own is seen, whatever the fits

  PlannedPlace kept() const;
};

PlannedPlace target_place(const Measurement& measurement);

/// Passes on every place that a job works at.
class PlaceSink final : public OperationSink {
 public:
  using Visit = std::function<void(const PassingPlace&)>;

  PlaceSink(const Survey& survey, Visit visit);
  void put(const Operation& operation) override;

 private:
  void pass(const Operation& operation, const PlacedPoint& point, int tool);

  Visit visit_;
  std::set<std::pair<std::string, int>> own_target_lines_;
  Position<frame::Nominal> router_;
  bool begins_contour_ = true;
};

/// Places among which further targets are chosen: all of them up to kAll; of more, one in each cell
/// of a grid, and the outermost in kDirections directions. A place that is left out then has one
/// within a cell's diagonal, 1/kCells of that of all places.
class CandidatePool {
 public:
  static constexpr std::size_t kAll = 4096;
  static constexpr int kCells = 48;
  static constexpr std::size_t kDirections = 32;

  CandidatePool(const Position<frame::Nominal>& low, const Position<frame::Nominal>& high);

  void add(const PassingPlace& place);
  void add(PlannedPlace target);
  /// No place twice.
  std::vector<PlannedPlace> candidates() const;
  bool is_thinned() const { return n_ > kAll; }

 private:
  std::optional<PlannedPlace>& cell(const Position<frame::Nominal>& p);

  Eigen::Vector2d low_mm_;
  Eigen::Vector2d cell_mm_;
  std::size_t n_ = 0;
  std::vector<PlannedPlace> all_;
  std::vector<PlannedPlace> targets_;
  std::vector<std::optional<PlannedPlace>> cells_;
  std::array<std::pair<double, PlannedPlace>, kDirections> outermost_;
};

}  // namespace panelcal::plan
