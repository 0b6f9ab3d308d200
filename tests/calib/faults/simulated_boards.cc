// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/faults/simulated_boards.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace panelcal::test {
namespace {

using Eigen::Vector2d;

constexpr std::array kPitches_mm = {1.27, 2.0, 2.54};
constexpr double kRotation_rad = 1.5e-3;
constexpr double kStretch = 150e-6;
constexpr double kResidual_mm = 0.01;
constexpr double kViewRatio = 0.75;  // height over width of a view

/// Places of equal pads about a target, itself left out.
using Row = std::vector<Vector2d>;

int whole(Random& random, int low, int high) {
  return low + static_cast<int>(random.uniform() * (high - low + 1));
}

Row random_row(Random& random, double pitch_mm) {
  const bool is_across = random.uniform() < 0.5;
  const Vector2d along = is_across ? Vector2d(0, 1) : Vector2d(1, 0);
  const Vector2d beside(along.y(), along.x());
  const int n_before = whole(random, 0, 8);
  const int n_behind = whole(random, n_before == 0 ? 1 : 0, 8);
  const int n_rows = whole(random, 1, 2);
  const double apart_mm = pitch_mm * whole(random, 1, 4);
  Row row;
  for (int line = 0; line < n_rows; ++line) {
    for (int k = -n_before; k <= n_behind; ++k) {
      if (line == 0 && k == 0) continue;
      row.push_back(pitch_mm * k * along + apart_mm * line * beside);
    }
  }
  return row;
}

bool has(const Row& row, const Vector2d& place_mm) {
  constexpr double kSame_mm = 0.2;
  return std::ranges::any_of(row,
                             [&](const Vector2d& p) { return (p - place_mm).norm() < kSame_mm; });
}

/// No pad of the first row is in all others.
bool are_different(const std::vector<Row>& rows) {
  return std::ranges::none_of(rows.front(), [&](const Vector2d& p) {
    return std::ranges::all_of(rows, [&](const Row& row) { return has(row, p); });
  });
}

std::vector<Row> random_rows(Random& random,
                             std::size_t n,
                             Neighbours neighbours,
                             double pitch_mm) {
  if (neighbours == Neighbours::Alike) return std::vector<Row>(n, random_row(random, pitch_mm));
  std::vector<Row> rows;
  do {
    rows.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const bool is_alone = random.uniform() < 0.15;
      const double own_mm = random.uniform() < 0.5 ? pitch_mm : kPitches_mm[whole(random, 0, 2)];
      rows.push_back(is_alone ? Row() : random_row(random, own_mm));
    }
  } while (!are_different(rows));
  return rows;
}

struct Panel {
  Eigen::Matrix2d linear;
  Vector2d shift_mm;

  Vector2d at(const Vector2d& p) const { return linear * p + shift_mm; }
};

Panel random_panel(Random& random, double pitch_mm) {
  const double theta = kRotation_rad * random.normal();
  Panel panel;
  panel.linear << 1 + kStretch * random.normal(), -theta, theta, 1 + kStretch * random.normal();
  // Whole pitches along the rows are the hardest.
  const double way_mm =
      pitch_mm * (random.uniform() < 0.5 ? whole(random, -3, 3) : random.uniform(-3, 3));
  const double turn = random.uniform() < 0.5 ? std::numbers::pi / 2 * whole(random, 0, 1)
                                             : random.uniform(0, std::numbers::pi);
  panel.shift_mm = way_mm * Vector2d(std::cos(turn), std::sin(turn)) +
                   0.05 * Vector2d(random.normal(), random.normal());
  return panel;
}

/// Candidates of one picture.
class Camera {
 public:
  Camera(Random& random, const BoardTrial& trial, double half_width_mm)
      : random_(random), trial_(trial), half_mm_(half_width_mm, kViewRatio * half_width_mm) {}

  /// Index of the pad among the candidates that count; -1: not among them.
  int look(const Vector2d& place_mm, ConstellationTarget& target) {
    if (((place_mm - target.expected_mm).cwiseAbs() - half_mm_).maxCoeff() > 0) return -1;
    if (target.radius_mm && (place_mm - target.expected_mm).norm() > *target.radius_mm) return -1;
    if (random_.uniform() < trial_.lost) return -1;
    const bool counts = random_.uniform() >= trial_.covered;
    const double sigma_mm = random_.uniform(0.001, 0.006);
    ConstellationCandidate seen;
    seen.cov_mm2 = sigma_mm * sigma_mm * Eigen::Matrix2d::Identity();
    seen.place_mm = place_mm + sigma_mm * Vector2d(random_.normal(), random_.normal());
    seen.score =
        random_.uniform(0.9, 1) - (random_.uniform() < 0.05 ? random_.uniform(0, 0.25) : 0);
    seen.counts = counts;
    target.candidates.push_back(seen);
    return counts ? static_cast<int>(target.candidates.size()) - 1 : -1;
  }

  void add_spurious(ConstellationTarget& target) {
    for (double left = trial_.spurious; random_.uniform() < left; left -= 0.5) {
      const Vector2d off =
          half_mm_.cwiseProduct(Vector2d(random_.uniform(-1, 1), random_.uniform(-1, 1)));
      const int i = look(target.expected_mm + off, target);
      if (i >= 0) target.candidates[static_cast<std::size_t>(i)].counts = random_.uniform() < 0.2;
    }
  }

  std::array<Vector2d, 4> view_mm(const Vector2d& middle) const {
    return {middle - half_mm_,
            middle + Vector2d(half_mm_.x(), -half_mm_.y()),
            middle + half_mm_,
            middle + Vector2d(-half_mm_.x(), half_mm_.y())};
  }

 private:
  Random& random_;
  const BoardTrial& trial_;
  Vector2d half_mm_;
};

}  // namespace

SimulatedBoard simulated_board(Random& random, Neighbours neighbours, const BoardTrial& trial) {
  SimulatedBoard board;
  board.pitch_mm = kPitches_mm[whole(random, 0, 2)];
  board.options.limits.rotation = rad(2.5 * kRotation_rad);
  board.options.limits.stretch_ppm = 2.5e6 * kStretch;
  board.options.limits.residual = mm(4 * kResidual_mm);
  const auto n = static_cast<std::size_t>(random.uniform() < 0.2 ? 2 : whole(random, 3, 4));
  const Vector2d size_mm(random.uniform(60, 250), random.uniform(50, 200));
  const std::array<Vector2d, 4> corners = {
      Vector2d(0, 0), size_mm, Vector2d(size_mm.x(), 0), Vector2d(0, size_mm.y())};
  const std::vector<Row> rows = random_rows(random, n, neighbours, board.pitch_mm);
  const Panel panel = random_panel(random, board.pitch_mm);
  const double half_mm = random.uniform(trial.min_view_mm, trial.max_view_mm);
  Camera camera(random, trial, half_mm);
  const double radius_mm = 3.5 * board.pitch_mm;
  // Without a radius targets lie in their pictures.
  const bool has_radius = random.uniform() < 0.5 || kViewRatio * half_mm < radius_mm;
  for (std::size_t i = 0; i < n; ++i) {
    ConstellationTarget target;
    target.expected_mm = corners[i];
    target.view_mm = camera.view_mm(corners[i]);
    if (has_radius) target.radius_mm = radius_mm;
    const Vector2d own_mm =
        panel.at(corners[i]) + kResidual_mm * Vector2d(random.normal(), random.normal());
    board.right.push_back(camera.look(own_mm, target));
    for (const Vector2d& off : rows[i]) camera.look(own_mm + panel.linear * off, target);
    camera.add_spurious(target);
    board.targets.push_back(target);
  }
  return board;
}

bool is_wrong(const SimulatedBoard& board, const Constellation& found) {
  if (!found.is_decided()) return false;
  const Combination& best = found.ranked.front();
  for (std::size_t i = 0; i < board.right.size(); ++i) {
    if (static_cast<int>(*best.choice[i]) != board.right[i]) return true;
  }
  return false;
}

}  // namespace panelcal::test
