// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/table/outliers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/base/statistics/median.h"
#include "calib/base/statistics/random.h"
#include "machine/config/plate/plate.h"
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Honest noise of two coordinates is so far off once in 270000.
constexpr double kTableOutlierSigmas = 5;
/// The worst ones are those at least half as far off as the worst one.
constexpr double kWorst = 0.5;
constexpr int kTableOutlierRounds = 5;
/// The median of fewer says nothing.
constexpr std::size_t kFewestPredicted = 8;

/// By chance: in any order of looks a rule could take whole columns of a plate, which without
/// neighbours that are seen in several poses predict nothing and leave the table open.
std::size_t fold_of(std::size_t i_look) {
  const double part = Random(2).fork(i_look).uniform() * static_cast<double>(kTableFolds);
  return std::min(kTableFolds - 1, static_cast<std::size_t>(part));
}

/// Of which chi square on a look is out of line.
double limit_of(const std::vector<TablePrediction>& all) {
  std::vector<double> values;
  for (const TablePrediction& one : all) values.push_back(one.chi_square);
  const double largest = *std::ranges::max_element(values);
  // The median of chi square (2) is 2 ln 2.
  const double scatter = std::max(1.0, median(std::move(values)) / (2 * std::numbers::ln2));
  return std::max(kTableOutlierSigmas * kTableOutlierSigmas * scatter, kWorst * kWorst * largest);
}

std::string dot_words(const TableData& data, const TablePrediction& one) {
  const TableObservation& look = data.seen[one.i_look];
  const Eigen::Vector2d& at_mm = data.views[look.i_view].axis_at.in_mm();
  return fmt::format("dot {} from ({:.3f}, {:.3f}) mm: {:.4f} mm beside where the others have it",
                     look.i_dot,
                     at_mm.x(),
                     at_mm.y(),
                     one.error_mm.norm());
}

}  // namespace

std::vector<TablePrediction> predict(const TableData& data,
                                     TableFitOptions options,
                                     std::size_t i_fold) {
  options.held_out_every = 0;
  // The rectangle of what is left would end before places that are to be predicted.
  const Expected<TableGrid> grid = table_grid(data, options);
  if (!grid) return {};
  options.grid = *grid;
  TableData used = data;
  used.seen.clear();
  std::vector<int> of_pose(data.views.size(), 0);
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    if (fold_of(i) == i_fold) continue;
    used.seen.push_back(data.seen[i]);
    if (data.seen[i].i_view < data.views.size()) ++of_pose[data.views[data.seen[i].i_view].i_pose];
  }
  std::vector<TablePrediction> out;
  const Expected<TableFit> fit = fit_table(used, options);
  if (!fit) return out;
  // One look lays a pose on nothing; and a pose without looks has no place in the fit.
  const auto is_laid = [&](const TableObservation& look) {
    return of_pose[data.views[look.i_view].i_pose] >= 2;
  };
  const auto turn_of = [&](const TableObservation& look) {
    return Eigen::Rotation2Dd(fit->poses[data.views[look.i_view].i_pose].angle_rad)
        .toRotationMatrix();
  };
  // Of errors of dots, from the looks at each: 1/mm^2, in the plate's frame.
  std::vector<Eigen::Matrix2d> of_looks(data.dots.size(), Eigen::Matrix2d::Zero());
  for (const TableObservation& look : used.seen) {
    if (!is_laid(look)) continue;
    const Eigen::Matrix2d turn = turn_of(look);
    of_looks[look.i_dot] += turn.transpose() * look.seen.cov.inverse() * turn;
  }
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    if (fold_of(i) != i_fold) continue;
    const TableObservation& look = data.seen[i];
    const PlateDot& dot = data.dots[look.i_dot];
    const bool is_known = dot.is_certified || !of_looks[look.i_dot].isZero(0);
    if (!is_known || !is_laid(look)) continue;
    const PlateView& view = data.views[look.i_view];
    const auto lies = place_in(fit->poses[view.i_pose], dot.place + fit->dot_errors[look.i_dot]);
    const Eigen::Vector2d error_mm = lies.in_mm() - view.axis_at.in_mm() -
                                     fit->map.error_mm(view.axis_at) - look.seen.position.in_mm();
    Eigen::Matrix2d cov = look.seen.cov + fit->covariance_at(view.axis_at);
    if (!dot.is_certified) {
      const Eigen::Matrix2d turn = turn_of(look);
      cov += turn * of_looks[look.i_dot].inverse() * turn.transpose();
    }
    const double chi_square = internal::squared_distance(error_mm, cov);
    if (std::isfinite(chi_square)) out.push_back({i, error_mm, chi_square});
  }
  return out;
}

std::vector<std::string> leave_out_outliers(const TableFitOptions& options, TableData& data) {
  std::vector<std::string> left_out;
  for (int round = 0; round < kTableOutlierRounds; ++round) {
    std::vector<TablePrediction> all;
    for (std::size_t i_fold = 0; i_fold < kTableFolds; ++i_fold) {
      const std::vector<TablePrediction> some = predict(data, options, i_fold);
      all.insert(all.end(), some.begin(), some.end());
    }
    if (all.size() < kFewestPredicted) break;
    const double limit = limit_of(all);
    std::vector<bool> is_kept(data.seen.size(), true);
    bool is_done = true;
    for (const TablePrediction& one : all) {
      if (one.chi_square < limit) continue;
      left_out.push_back(dot_words(data, one));
      is_kept[one.i_look] = false;
      is_done = false;
    }
    if (is_done) break;
    std::vector<TableObservation> kept;
    for (std::size_t i = 0; i < is_kept.size(); ++i) {
      if (is_kept[i]) kept.push_back(data.seen[i]);
    }
    data.seen = std::move(kept);
  }
  return left_out;
}

}  // namespace panelcal::internal
