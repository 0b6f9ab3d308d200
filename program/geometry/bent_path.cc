// SPDX-License-Identifier: Apache-2.0
#include "program/geometry/bent_path.h"

#include <algorithm>
#include <cmath>

#include "program/geometry/arc_path.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using Map = std::function<Vector2d(const Vector2d&)>;

constexpr int kMostPieces = 4096;
constexpr int kLeastSamples = 8;  // steps from a piece's begin to its end; even, for its middle
constexpr int kMostSamples = 8192;
constexpr double kSampled_mm = 2;
constexpr double kStraightPath_mm = 1e-9;

double distance_to_chord_mm(const Vector2d& p_mm, const Arc& line) {
  const Vector2d along = line.end_mm - line.start_mm;
  const double squared = along.squaredNorm();
  const double share =
      squared > 0 ? std::clamp((p_mm - line.start_mm).dot(along) / squared, 0.0, 1.0) : 0;
  return (line.start_mm + share * along - p_mm).norm();
}

/// Through both ends and, if it is no line, the middle.
Arc through(const Vector2d& start_mm, const Vector2d& middle_mm, const Vector2d& end_mm) {
  Arc arc{start_mm, end_mm, 0.5 * (start_mm + end_mm), false, true};
  const Vector2d chord = end_mm - start_mm;
  const double length_mm = chord.norm();
  if (!(length_mm > 0)) return arc;
  const Vector2d left = Vector2d(-chord.y(), chord.x()) / length_mm;
  const Vector2d rise = middle_mm - arc.center_mm;
  const double sagitta_mm = left.dot(rise);
  if (std::abs(sagitta_mm) < kStraightPath_mm) return arc;
  // The centre is c left of the chord: |rise - c left|^2 = c^2 + (length / 2)^2.
  const double to_center_mm =
      0.5 * (rise.squaredNorm() - 0.25 * length_mm * length_mm) / sagitta_mm;
  // An arc that rises to the left of its chord goes clockwise; at most half a turn of it has the
  // centre on the other side.
  arc.clockwise = sagitta_mm > 0;
  arc.center_mm +=
      (arc.clockwise ? std::min(to_center_mm, 0.0) : std::max(to_center_mm, 0.0)) * left;
  arc.straight = false;
  return arc;
}

double distance_mm(const Vector2d& p_mm, const Arc& image) {
  if (image.straight) return distance_to_chord_mm(p_mm, image);
  return std::abs((p_mm - image.center_mm).norm() - (image.start_mm - image.center_mm).norm());
}

struct Cut {
  std::vector<BentPiece> pieces;
  double deviation_mm = 0;
};

Cut cut(const ArcPath& path, const Map& map, bool is_line, int n_pieces) {
  const int n_for_length =
      static_cast<int>(std::min(1.0 * kMostSamples, path.length_mm() / kSampled_mm)) / n_pieces;
  const int n_steps = 2 * (std::max(kLeastSamples, n_for_length) / 2);
  Cut out;
  Vector2d begin_mm = map(path.at(0));
  for (int i = 0; i < n_pieces; ++i) {
    const auto share_at = [&](int step) {
      return (i + static_cast<double>(step) / n_steps) / n_pieces;
    };
    std::vector<Vector2d> images_mm;
    for (int step = 1; step < n_steps; ++step) images_mm.push_back(map(path.at(share_at(step))));
    BentPiece piece{.end_mm = path.at(share_at(n_steps)), .share = share_at(n_steps), .image = {}};
    const Vector2d end_mm = map(piece.end_mm);
    const Vector2d middle_mm = images_mm[static_cast<std::size_t>(n_steps / 2 - 1)];
    piece.image = is_line ? Arc{begin_mm, end_mm, 0.5 * (begin_mm + end_mm), false, true}
                          : through(begin_mm, middle_mm, end_mm);
    for (const Vector2d& p_mm : images_mm) {
      const double away_mm = distance_mm(p_mm, piece.image);
      // Written so that a NaN stays.
      if (!(away_mm <= out.deviation_mm)) out.deviation_mm = away_mm;
    }
    out.pieces.push_back(piece);
    begin_mm = end_mm;
  }
  return out;
}

}  // namespace

std::vector<BentPiece> carry_bent(const Arc& path, const Map& map, double tolerance_mm) {
  const ArcPath way(path);
  const Vector2d start_mm = map(path.start_mm);
  const Vector2d end_mm = map(path.end_mm);
  BentPiece whole{path.end_mm, 1, {start_mm, end_mm, 0.5 * (start_mm + end_mm), false, true}};
  const double length_mm = way.length_mm();
  if (!start_mm.allFinite() || !end_mm.allFinite() || !std::isfinite(length_mm)) return {whole};
  if (!(length_mm > 0)) return {whole};
  // Chords deviate by the square of their length, circles by the cube.
  const double order = path.straight ? 2 : 3;
  int n_pieces = 1;
  while (true) {
    Cut found = cut(way, map, path.straight, n_pieces);
    if (std::isnan(found.deviation_mm)) return {whole};
    if (found.deviation_mm <= tolerance_mm || n_pieces == kMostPieces) return found.pieces;
    const double factor = std::pow(found.deviation_mm / std::max(tolerance_mm, 1e-12), 1 / order);
    const double wanted = std::ceil(std::min(1.0 * kMostPieces, 0.9 * factor * n_pieces));
    n_pieces = std::min(kMostPieces, std::max(n_pieces + 1, static_cast<int>(wanted)));
  }
}

}  // namespace panelcal
