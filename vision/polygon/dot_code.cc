// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/dot_code.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr int kAllNeeded = 3;  // codes of up to this number of dots need every one

Eigen::Matrix2d dots_rotation(double angle) {
  Eigen::Matrix2d r;
  r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return r;
}

double vector_angle(const Eigen::Vector2d& v) {
  return std::atan2(v.y(), v.x());
}

/// An angle brought to -pi .. pi.
double wrapped_angle(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

/// Seen dots by square cells, to find the one nearest to a place.
class DotGrid {
 public:
  DotGrid(std::span<const SeenDot> seen, double reach) : seen_(seen), cell_(reach) {
    for (std::size_t i = 0; i < seen.size(); ++i) {
      cells_[key(seen[i].at)].push_back(static_cast<int>(i));
    }
  }

  std::optional<int> nearest(const Eigen::Vector2d& at) const {
    const auto [cx, cy] = key(at);
    std::optional<int> best;
    double best_distance = cell_;
    for (long y = cy - 1; y <= cy + 1; ++y) {
      for (long x = cx - 1; x <= cx + 1; ++x) {
        const auto found = cells_.find({x, y});
        if (found == cells_.end()) continue;
        for (const int i : found->second) {
          const double distance = (seen_[static_cast<std::size_t>(i)].at - at).norm();
          if (distance <= best_distance) {
            best = i;
            best_distance = distance;
          }
        }
      }
    }
    return best;
  }

 private:
  std::pair<long, long> key(const Eigen::Vector2d& at) const {
    return {std::lround(std::floor(at.x() / cell_)), std::lround(std::floor(at.y() / cell_))};
  }

  std::span<const SeenDot> seen_;
  double cell_;
  std::map<std::pair<long, long>, std::vector<int>> cells_;
};

struct BasePair {
  std::size_t first = 0;
  std::size_t second = 0;
};

/// Pairs without a common dot, far apart ones first: they tell the turn best.
std::vector<BasePair> base_pairs(std::span<const Eigen::Vector2d> dots, int n_pairs) {
  struct Ranked {
    double length;
    BasePair pair;
  };
  std::vector<Ranked> all;
  for (std::size_t i = 0; i < dots.size(); ++i) {
    for (std::size_t j = i + 1; j < dots.size(); ++j) {
      all.push_back({(dots[i] - dots[j]).norm(), {i, j}});
    }
  }
  std::stable_sort(
      all.begin(), all.end(), [](const Ranked& a, const Ranked& b) { return a.length > b.length; });
  std::vector<bool> used(dots.size(), false);
  std::vector<BasePair> pairs;
  for (const Ranked& ranked : all) {
    if (static_cast<int>(pairs.size()) >= n_pairs) break;
    if (used[ranked.pair.first] || used[ranked.pair.second]) continue;
    used[ranked.pair.first] = used[ranked.pair.second] = true;
    pairs.push_back(ranked.pair);
  }
  return pairs;
}

int count(const DotAssignment& assignment) {
  return static_cast<int>(
      std::ranges::count_if(assignment, [](const auto& i) { return i.has_value(); }));
}

bool share_a_dot(const DotAssignment& a, const DotAssignment& b) {
  return std::ranges::any_of(
      a, [&](const auto& i) { return i && std::ranges::find(b, i) != b.end(); });
}

/// Assigns every dot of the code at a pose; a seen dot serves once.
DotAssignment assign(const DotCode& code, const DotGrid& grid, const DotPose& pose) {
  const Eigen::Matrix2d map = std::exp(pose.log_scale) * dots_rotation(pose.turn);
  DotAssignment assignment;
  for (const Eigen::Vector2d& dot : code.dots) {
    auto nearest = grid.nearest(pose.at + map * dot);
    if (nearest && std::ranges::find(assignment, nearest) != assignment.end()) nearest.reset();
    assignment.push_back(nearest);
  }
  return assignment;
}

/// The pose that carries a pair of the code's dots onto a pair of seen ones; empty if that takes
/// more turn or scale than the tolerances allow.
std::optional<DotPose> hypothesis(const DotCode& code,
                                  const BasePair& pair,
                                  const Eigen::Vector2d& first,
                                  const Eigen::Vector2d& second) {
  const Eigen::Vector2d wanted = code.dots[pair.second] - code.dots[pair.first];
  const Eigen::Vector2d got = second - first;
  const double length = wanted.norm();
  // Both ends may be off by the tolerance of places.
  const double slack = 2 * code.place_tolerance / length;
  const double scale = got.norm() / length;
  if (std::abs(scale - 1) > code.scale_tolerance + slack) return std::nullopt;
  const double turn =
      code.turn + wrapped_angle(vector_angle(got) - vector_angle(wanted) - code.turn);
  if (std::abs(turn - code.turn) > code.turn_tolerance + slack) return std::nullopt;
  DotPose pose;
  pose.turn = turn;
  pose.log_scale = std::log(scale);
  const Eigen::Vector2d middle = 0.5 * (code.dots[pair.first] + code.dots[pair.second]);
  pose.at = 0.5 * (first + second) - scale * dots_rotation(turn) * middle;
  return pose;
}

/// Ways that share a dot with one of more dots are shadows of it.
void drop_shadows(std::vector<DotAssignment>& ways) {
  std::stable_sort(ways.begin(), ways.end(), [](const DotAssignment& a, const DotAssignment& b) {
    return count(a) > count(b);
  });
  std::vector<DotAssignment> kept;
  for (DotAssignment& way : ways) {
    const bool is_shadow = std::ranges::any_of(kept, [&](const DotAssignment& other) {
      return other == way || (count(other) > count(way) && share_a_dot(other, way));
    });
    if (!is_shadow) kept.push_back(std::move(way));
  }
  ways = std::move(kept);
}

}  // namespace

int least_dots(int n_dots) {
  return n_dots <= kAllNeeded ? n_dots : n_dots - n_dots / 4;
}

std::vector<DotAssignment> match_dots(const DotCode& code, std::span<const SeenDot> seen) {
  const int n_dots = static_cast<int>(code.dots.size());
  const int needed = least_dots(n_dots);
  if (n_dots < 2 || static_cast<int>(seen.size()) < needed) return {};
  const DotGrid grid(seen, code.place_tolerance);
  std::vector<DotAssignment> ways;
  for (const BasePair& pair : base_pairs(code.dots, n_dots - needed + 1)) {
    for (std::size_t i = 0; i < seen.size(); ++i) {
      for (std::size_t j = 0; j < seen.size(); ++j) {
        if (i == j) continue;
        const auto guess = hypothesis(code, pair, seen[i].at, seen[j].at);
        if (!guess) continue;
        DotAssignment way = assign(code, grid, *guess);
        if (count(way) < std::max(2, needed)) continue;
        // The pair alone is a lever: all dots together say better which others belong.
        way = assign(code, grid, fit_dots(code, seen, way));
        if (count(way) < needed || std::ranges::find(ways, way) != ways.end()) continue;
        ways.push_back(std::move(way));
      }
    }
  }
  drop_shadows(ways);
  return ways;
}

DotPose fit_dots(const DotCode& code,
                 std::span<const SeenDot> seen,
                 const DotAssignment& assignment) {
  constexpr int kIterations = 8;
  struct Pair {
    int dot;
    const SeenDot* seen;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < assignment.size(); ++i) {
    if (assignment[i]) {
      pairs.push_back({static_cast<int>(i), &seen[static_cast<std::size_t>(*assignment[i])]});
    }
  }
  // The start: turn by the plain sum of all dots about their middles (Umeyama 1991).
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Eigen::Vector2d seen_middle = Eigen::Vector2d::Zero();
  for (const Pair& pair : pairs) {
    middle += code.dots[static_cast<std::size_t>(pair.dot)] / static_cast<double>(pairs.size());
    seen_middle += pair.seen->at / static_cast<double>(pairs.size());
  }
  double along = 0;
  double across = 0;
  for (const Pair& pair : pairs) {
    const Eigen::Vector2d a = code.dots[static_cast<std::size_t>(pair.dot)] - middle;
    const Eigen::Vector2d b = pair.seen->at - seen_middle;
    along += a.dot(b);
    across += a.x() * b.y() - a.y() * b.x();
  }
  DotPose pose;
  pose.turn = code.turn + wrapped_angle(std::atan2(across, along) - code.turn);
  pose.at = seen_middle - dots_rotation(pose.turn) * middle;

  const int n = code.fits_scale ? 4 : 3;
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    const Eigen::Matrix2d map = std::exp(pose.log_scale) * dots_rotation(pose.turn);
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
    pose.chi_square = pose.worst = 0;
    for (const Pair& pair : pairs) {
      const Eigen::Vector2d arm = map * code.dots[static_cast<std::size_t>(pair.dot)];
      const Eigen::Vector2d residual = pair.seen->at - pose.at - arm;
      Eigen::Matrix<double, 2, 4> j;
      j << Eigen::Matrix2d::Identity(), Eigen::Vector2d(-arm.y(), arm.x()), arm;
      const Eigen::LLT<Eigen::Matrix2d> cov(pair.seen->cov);
      information += j.transpose() * cov.solve(j);
      gradient += j.transpose() * cov.solve(residual);
      pose.chi_square += residual.dot(cov.solve(residual));
      if (residual.norm() > pose.worst) {
        pose.worst = residual.norm();
        pose.worst_dot = pair.dot;
      }
    }
    const Eigen::MatrixXd used = information.topLeftCorner(n, n);
    const Eigen::LDLT<Eigen::MatrixXd> factor(used);
    pose.cov.setZero();
    pose.cov.topLeftCorner(n, n) = factor.solve(Eigen::MatrixXd::Identity(n, n));
    if (iteration == kIterations) break;
    Eigen::Vector4d step = Eigen::Vector4d::Zero();
    step.head(n) = factor.solve(gradient.head(n));
    if (!step.allFinite()) break;
    pose.at += step.head<2>();
    pose.turn += step[2];
    pose.log_scale += step[3];
  }
  pose.degrees_of_freedom = 2 * static_cast<int>(pairs.size()) - n;
  return pose;
}

std::optional<double> self_turn(const DotCode& code) {
  std::vector<SeenDot> own;
  for (const Eigen::Vector2d& dot : code.dots) own.push_back({dot, Eigen::Matrix2d::Identity()});
  DotCode unturned = code;
  unturned.turn = 0;
  for (const DotAssignment& way : match_dots(unturned, own)) {
    const bool is_whole = count(way) == static_cast<int>(way.size());
    const bool is_itself = [&] {
      for (std::size_t i = 0; i < way.size(); ++i) {
        if (way[i] != static_cast<int>(i)) return false;
      }
      return true;
    }();
    if (is_whole && !is_itself) return fit_dots(unturned, own, way).turn;
  }
  return std::nullopt;
}

}  // namespace panelcal::internal
