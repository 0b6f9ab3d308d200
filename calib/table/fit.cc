// SPDX-License-Identifier: Apache-2.0
#include "calib/table/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "calib/base/statistics/random.h"
#include "calib/table/modes.h"
#include "calib/table/smoother.h"
#include "calib/table/system.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using internal::LikelySmoothness;
using internal::Smoother;
using internal::TableBasis;
using internal::TableSolution;
using internal::TableState;
using internal::TableSystem;
using internal::TableWaves;

/// Angles of poses are the only thing that is not linear. They begin a warp over the travel off;
/// the first round finds them, the second what it made of their squares, the last is reported.
constexpr int kTableRounds = 3;
constexpr int kMaxFitSteps = 24;  ///< 1458 coefficients; beyond that a fit takes minutes

tl::unexpected<Diagnostic> table_data_refused(std::string what, std::string expected) {
  return failure({Code::CalibrationData, {}, std::move(what), std::move(expected)});
}

Expected<void> check_seen(const TableData& data) {
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    const TableObservation& seen = data.seen[i];
    if (seen.i_view >= data.views.size() || seen.i_dot >= data.dots.size()) {
      return table_data_refused(
          fmt::format("observation {} is of view {}, dot {}", i, seen.i_view, seen.i_dot),
          fmt::format("{} views, {} dots", data.views.size(), data.dots.size()));
    }
    const Eigen::Matrix2d& cov = seen.seen.cov;
    const bool is_cov =
        cov.allFinite() && cov(0, 1) == cov(1, 0) && cov(0, 0) > 0 && cov.determinant() > 0;
    if (!seen.seen.position.in_mm().allFinite() || !is_cov) {
      return table_data_refused(fmt::format("observation {} or its covariance is not one", i),
                                "a finite place, symmetric positive definite mm^2");
    }
  }
  if (data.seen.size() < 4) {
    return table_data_refused(fmt::format("{} observations", data.seen.size()), "4 or more");
  }
  return {};
}

Expected<void> check_table_data(const TableData& data, const TableFitOptions& options) {
  for (const PlateView& view : data.views) {
    if (!view.axis_at.in_mm().allFinite())
      return table_data_refused("a view's place is not finite", "mm");
    if (view.i_pose >= data.views.size()) {
      return table_data_refused(fmt::format("pose {} of {} views", view.i_pose, data.views.size()),
                                "poses counted from 0, each with a view");
    }
  }
  for (const PlateDot& dot : data.dots) {
    if (!dot.place.in_mm().allFinite())
      return table_data_refused("a dot's place is not finite", "mm");
  }
  if (options.steps < 1 || options.steps > kMaxFitSteps) {
    return table_data_refused(fmt::format("steps is {}", options.steps),
                              fmt::format("1 to {}", kMaxFitSteps));
  }
  if (options.grid && (!options.grid->is_valid() || options.grid->nx > kMaxFitSteps ||
                       options.grid->ny > kMaxFitSteps)) {
    return table_data_refused("the grid has no area or no steps",
                              fmt::format("a rectangle, 1 to {} steps a side", kMaxFitSteps));
  }
  if (!(options.open_sigma > mm(0)))
    return table_data_refused("open_sigma is not positive", "a length");
  if (options.held_out_every == 1 || options.held_out_every < 0) {
    return table_data_refused(fmt::format("held_out_every is {}", options.held_out_every),
                              "0, or 2 or more");
  }
  return check_seen(data);
}

/// A place of the table, in tenths of the grid's step: places that near are one, for no wave is
/// that short.
struct PlaceSeen {
  Eigen::Vector2d at;
  std::size_t i_view = 0;
  bool is_seen_again = false;
};

/// True if half of the places that are looked at are looked at in two views or more: only then do
/// the looks tell scatter that is larger than stated from short waves of the table, and with them
/// how smooth it is.
bool sees_places_again(const TableData& data, const TableGrid& grid) {
  constexpr double kFarthest = 1e9;
  const Eigen::Vector2d steps(grid.nx, grid.ny);
  const Eigen::Vector2d same_mm = 0.1 * (grid.high_mm - grid.low_mm).cwiseQuotient(steps);
  std::map<std::pair<long, long>, PlaceSeen> places;
  const auto near = [&](const Eigen::Vector2d& at, long column, long row) -> PlaceSeen* {
    for (long x = column - 1; x <= column + 1; ++x) {
      for (long y = row - 1; y <= row + 1; ++y) {
        const auto known = places.find({x, y});
        if (known != places.end() && (known->second.at - at).squaredNorm() < 1) {
          return &known->second;
        }
      }
    }
    return nullptr;
  };
  for (const TableObservation& seen : data.seen) {
    const Eigen::Vector2d& at_mm = data.views[seen.i_view].axis_at.in_mm();
    const Eigen::Vector2d at =
        (at_mm - grid.low_mm).cwiseQuotient(same_mm).cwiseMax(-kFarthest).cwiseMin(kFarthest);
    const long column = std::lround(at.x());
    const long row = std::lround(at.y());
    if (PlaceSeen* const known = near(at, column, row)) {
      known->is_seen_again |= known->i_view != seen.i_view;
    } else {
      places[{column, row}] = {at, seen.i_view};
    }
  }
  const auto n_again =
      std::ranges::count_if(places, [](const auto& place) { return place.second.is_seen_again; });
  return 2 * static_cast<std::size_t>(n_again) >= places.size();
}

std::vector<Eigen::Vector2d> pairs_of(const VectorXd& v) {
  std::vector<Eigen::Vector2d> pairs;
  for (Index i = 0; i + 1 < v.size(); i += 2) pairs.emplace_back(v[i], v[i + 1]);
  return pairs;
}

/// Every n-th on average, but without a pattern that might fall in with the plate's rows.
bool is_held_out(std::size_t i, int every) {
  return Random(1).fork(i).uniform() * every < 1;
}

void hold_out_looks(const TableData& data,
                    const TableFitOptions& options,
                    const TableBasis& basis,
                    const LikelySmoothness& smoothness,
                    const internal::OpenModes& open,
                    const TableState& about,
                    TableFit& fit) {
  std::vector<std::size_t> used;
  std::vector<std::size_t> held;
  std::vector<int> by_pose(about.poses.size(), 0);
  std::vector<int> by_dot(data.dots.size(), 0);
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    if (is_held_out(i, options.held_out_every)) {
      held.push_back(i);
      continue;
    }
    used.push_back(i);
    ++by_pose[data.views[data.seen[i].i_view].i_pose];
    ++by_dot[data.seen[i].i_dot];
  }
  const TableSystem system(data, used, basis, about);
  const Smoother smoother(*smoothness.waves, basis, system, open, about.table_mm);
  const auto solution = smoother.solve(smoothness.weight);
  if (!solution) return;
  const TableState state = system.complete(solution->table_mm);
  double sum_mm2 = 0;
  for (const std::size_t i : held) {
    const TableObservation& seen = data.seen[i];
    const bool is_laid = by_pose[data.views[seen.i_view].i_pose] >= 2;
    if (!is_laid || (by_dot[seen.i_dot] == 0 && !data.dots[seen.i_dot].is_certified)) continue;
    sum_mm2 += table_residual_mm(data, basis, state, seen).squaredNorm();
    ++fit.n_held_out;
  }
  if (fit.n_held_out == 0) return;
  fit.held_out_rms_mm = std::sqrt(sum_mm2 / static_cast<double>(fit.n_held_out));
}

TableFit table_report(const TableData& data,
                      const TableBasis& basis,
                      const TableState& state,
                      const TableSolution& solution) {
  TableFit fit;
  fit.poses = state.poses;
  for (const Eigen::Vector2d& error_mm : state.dots_mm) {
    fit.dot_errors.push_back(displacement_mm<frame::Plate>(error_mm));
  }
  double sum_mm2 = 0;
  for (const TableObservation& seen : data.seen) {
    const Eigen::Vector2d r_mm = table_residual_mm(data, basis, state, seen);
    fit.residuals.push_back(displacement_mm<frame::Table>(r_mm));
    sum_mm2 += r_mm.squaredNorm();
    fit.chi_square += r_mm.dot(seen.seen.cov.inverse() * r_mm);
  }
  fit.rms_mm = std::sqrt(sum_mm2 / static_cast<double>(data.seen.size()));
  fit.smoothness = solution.smoothness;
  fit.map = TableMap(basis.grid, pairs_of(solution.table_mm));
  fit.covariance = solution.cov;
  const MatrixXd geometry = internal::geometry_functionals(basis);
  fit.geometry.value = geometry * solution.table_mm;
  fit.geometry.cov = geometry * solution.cov * geometry.transpose();
  return fit;
}

}  // namespace

std::string_view TableGeometry::name(Index index) {
  constexpr std::array<std::string_view, kSize> kNames = {"scale x",
                                                          "scale y",
                                                          "squareness",
                                                          "linearity x 2",
                                                          "linearity x 3",
                                                          "linearity y 2",
                                                          "linearity y 3",
                                                          "straightness x 2",
                                                          "straightness x 3",
                                                          "straightness y 2",
                                                          "straightness y 3"};
  return kNames[static_cast<std::size_t>(index)];
}

Eigen::Matrix2d TableFit::covariance_at(const Position<frame::Machine>& commanded) const {
  if (!commanded.in_mm().allFinite()) return Eigen::Matrix2d::Constant(std::nan(""));
  const auto local = internal::local_of(map.grid(), commanded.in_mm());
  Eigen::Matrix2d cov = Eigen::Matrix2d::Zero();
  for (std::size_t a = 0; a < 16; ++a) {
    for (std::size_t b = 0; b < 16; ++b) {
      cov += local.weight[a] * local.weight[b] *
             covariance.block<2, 2>(2 * local.index[a], 2 * local.index[b]);
    }
  }
  return cov;
}

std::string TableFit::summary() const {
  std::string text =
      fmt::format("table: scale {:.1f} and {:.1f} ppm, squareness {:.1f} urad, rms {:.2f} um",
                  1e6 * geometry.value[TableGeometry::ScaleX],
                  1e6 * geometry.value[TableGeometry::ScaleY],
                  1e6 * geometry.value[TableGeometry::Squareness],
                  1e3 * rms_mm);
  if (held_out_rms_mm) text += fmt::format(", held out {:.2f} um", 1e3 * *held_out_rms_mm);
  for (const std::string& name : undetermined) text += fmt::format(", {} undetermined", name);
  return text;
}

Expected<TableGrid> table_grid(const TableData& data, const TableFitOptions& options) {
  PANELCAL_CHECK(check_table_data(data, options));
  if (options.grid) return *options.grid;
  Eigen::Vector2d low = data.views[data.seen.front().i_view].axis_at.in_mm();
  Eigen::Vector2d high = low;
  for (const TableObservation& seen : data.seen) {
    const Eigen::Vector2d& at = data.views[seen.i_view].axis_at.in_mm();
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const Eigen::Vector2d span = high - low;
  if (!(span.minCoeff() > 0) || !span.allFinite()) {
    return table_data_refused("all looks are from one line",
                              "commanded places that spread along x and y");
  }
  const Eigen::Vector2d steps = (span / span.maxCoeff() * options.steps).array().ceil();
  return TableGrid{low, high, static_cast<int>(steps.x()), static_cast<int>(steps.y())};
}

Expected<TableFit> fit_table(const TableData& data, const TableFitOptions& options) {
  PANELCAL_TRY(const TableGrid grid, table_grid(data, options));
  const TableBasis basis(grid);
  const std::vector<TableWaves> processes = sees_places_again(data, grid)
                                                ? internal::all_waves(basis)
                                                : std::vector{internal::plate_waves(basis)};
  std::vector<std::size_t> all(data.seen.size());
  std::iota(all.begin(), all.end(), std::size_t{0});

  TableState state = internal::table_start(data, basis);
  TableState about;
  std::optional<TableSolution> solution;
  internal::OpenModes open;
  int n_eliminated = 0;
  std::optional<LikelySmoothness> smoothness;
  for (int round = 0; round < kTableRounds; ++round) {
    about = state;
    about.dots_mm.assign(data.dots.size(), Eigen::Vector2d::Zero());
    const TableSystem system(data, all, basis, about);
    open = internal::find_open_modes(basis, system.normal(), options.open_sigma.in_mm());
    const bool is_last = round + 1 == kTableRounds;
    smoothness = is_last ? internal::most_likely(processes, basis, system, open, about.table_mm)
                         : LikelySmoothness{&processes.front(), internal::usual_weight(system)};
    solution.reset();
    if (!smoothness) break;
    const Smoother smoother(*smoothness->waves, basis, system, open, about.table_mm);
    solution = smoother.solve(smoothness->weight);
    if (!solution) break;
    internal::settle(basis, open, *solution);
    state = system.complete(solution->table_mm);
    n_eliminated = system.n_eliminated();
  }
  if (!solution || open.combinations.cols() == basis.modes.cols()) {
    return table_data_refused("nothing about the table can be seen in these looks",
                              "a plate seen from many places, certified or in several poses");
  }
  TableFit fit = table_report(data, basis, state, *solution);
  fit.undetermined = open.names;
  fit.parameters = solution->parameters + n_eliminated;
  fit.degrees_of_freedom =
      2 * static_cast<double>(data.seen.size()) - solution->taken_up - n_eliminated;
  if (options.held_out_every > 0)
    hold_out_looks(data, options, basis, *smoothness, open, about, fit);
  return fit;
}

}  // namespace panelcal
