// SPDX-License-Identifier: Apache-2.0
#include "program/geometry/bent_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>

namespace panelcal {
namespace {

using Eigen::Vector2d;

constexpr double kTolerance_mm = 0.001;
/// Factor for what lies between two samples of the maps below.
constexpr double kSampling = 1.02;

Arc line(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y1}, {0.5 * (x0 + x1), 0.5 * (y0 + y1)}, false, true};
}

/// Counterclockwise about the centre from one angle to another.
Arc arc_about(const Vector2d& center_mm, double radius_mm, double from_rad, double to_rad) {
  return {center_mm + radius_mm * Vector2d(std::cos(from_rad), std::sin(from_rad)),
          center_mm + radius_mm * Vector2d(std::cos(to_rad), std::sin(to_rad)),
          center_mm,
          to_rad < from_rad,
          false};
}

Vector2d bowed(const Vector2d& p_mm) {
  return p_mm + 0.1 * Vector2d(std::sin(p_mm.y() / 60), std::cos(p_mm.x() / 80));
}

/// The greatest distance of the images of many places of a path from the pieces they belong to.
double deviation_mm(const std::vector<BentPiece>& pieces,
                    const std::function<Vector2d(double)>& path,
                    const std::function<Vector2d(const Vector2d&)>& map) {
  constexpr int kPlaces = 5000;
  double worst_mm = 0;
  for (int i = 0; i <= kPlaces; ++i) {
    const double share = static_cast<double>(i) / kPlaces;
    const auto piece = std::ranges::find_if(
        pieces, [share](const BentPiece& p) { return share <= p.share + 1e-12; });
    const Arc& image = piece->image;
    const Vector2d p_mm = map(path(share));
    const Vector2d chord = (image.end_mm - image.start_mm).normalized();
    const Vector2d off_mm = p_mm - image.start_mm;
    const double away_mm =
        image.straight
            ? std::abs(chord.x() * off_mm.y() - chord.y() * off_mm.x())
            : std::abs((p_mm - image.center_mm).norm() - (image.end_mm - image.center_mm).norm());
    worst_mm = std::max(worst_mm, away_mm);
  }
  return worst_mm;
}

void expect_chain(const std::vector<BentPiece>& pieces) {
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    EXPECT_EQ(pieces[i].image.start_mm, pieces[i - 1].image.end_mm);
    EXPECT_GT(pieces[i].share, pieces[i - 1].share);
  }
  EXPECT_EQ(pieces.back().share, 1);
}

TEST(BentPath, LeavesALineWholeWhereNothingIsBent) {
  const auto pieces = carry_bent(
      line(0, 0, 300, 200),
      [](const Vector2d& p) { return Vector2d(p.x() + 0.1 * p.y(), p.y()); },
      kTolerance_mm);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_TRUE(pieces[0].image.straight);
  EXPECT_EQ(pieces[0].end_mm, Vector2d(300, 200));
  EXPECT_EQ(pieces[0].image.end_mm, Vector2d(320, 200));
}

TEST(BentPath, CutsALineAsOftenAsAParabolaNeeds) {
  // y = a x^2 is 2 a (L / n)^2 / 8 from its chords: n = L sqrt(a / (4 tolerance)) = 15.8.
  constexpr double kBend = 1e-5;
  constexpr double kLength_mm = 316;
  const auto map = [](const Vector2d& p) { return Vector2d(p.x(), kBend * p.x() * p.x()); };
  const auto pieces = carry_bent(line(0, 0, kLength_mm, 0), map, kTolerance_mm);
  const double needed = std::ceil(kLength_mm * std::sqrt(kBend / (4 * kTolerance_mm)));
  EXPECT_GE(static_cast<double>(pieces.size()), needed);
  EXPECT_LE(static_cast<double>(pieces.size()), needed + 1);
  expect_chain(pieces);
  const auto path = [](double share) { return Vector2d(share * kLength_mm, 0); };
  EXPECT_LT(deviation_mm(pieces, path, map), kSampling * kTolerance_mm);
}

TEST(BentPath, KeepsLinesAndArcsNearTheBentOnes) {
  const auto line_pieces = carry_bent(line(10, 20, 410, 320), bowed, kTolerance_mm);
  const auto along = [](double share) { return Vector2d(10 + 400 * share, 20 + 300 * share); };
  expect_chain(line_pieces);
  EXPECT_GT(line_pieces.size(), 3u);
  EXPECT_LT(deviation_mm(line_pieces, along, bowed), kSampling * kTolerance_mm);
  for (const double turn_rad : {2.5, -2.5, std::numbers::pi, -std::numbers::pi}) {
    const Arc arc = arc_about({200, 150}, 120, 0.3, 0.3 + turn_rad);
    const auto pieces = carry_bent(arc, bowed, kTolerance_mm);
    const auto around = [turn_rad](double share) {
      const double angle_rad = 0.3 + share * turn_rad;
      return Vector2d(200 + 120 * std::cos(angle_rad), 150 + 120 * std::sin(angle_rad));
    };
    expect_chain(pieces);
    EXPECT_LT(deviation_mm(pieces, around, bowed), kSampling * kTolerance_mm) << turn_rad;
    EXPECT_LT(pieces.size(), line_pieces.size() + 12) << turn_rad;
    for (const BentPiece& piece : pieces) {
      EXPECT_FALSE(piece.image.straight);
      EXPECT_EQ(piece.image.clockwise, arc.clockwise);
      EXPECT_NEAR((piece.image.start_mm - piece.image.center_mm).norm(),
                  (piece.image.end_mm - piece.image.center_mm).norm(),
                  1e-9);
    }
  }
}

TEST(BentPath, CarriesACircleByAMirrorExactly) {
  const Arc arc = arc_about({5, 5}, 3, 0, 2);
  const auto pieces = carry_bent(
      arc, [](const Vector2d& p) { return Vector2d(-2 * p.x(), 2 * p.y()); }, 1e-6);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_TRUE(pieces[0].image.clockwise);
  EXPECT_LT((pieces[0].image.center_mm - Vector2d(-10, 10)).norm(), 1e-9);
}

TEST(BentPath, SurvivesWhatIsNotFinite) {
  const auto nowhere = [](const Vector2d&) {
    return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()).eval();
  };
  EXPECT_EQ(carry_bent(line(0, 0, 1, 0), nowhere, kTolerance_mm).size(), 1u);
  EXPECT_EQ(carry_bent(line(0, 0, INFINITY, 0), bowed, kTolerance_mm).size(), 1u);
  EXPECT_EQ(carry_bent(line(1, 1, 1, 1), bowed, kTolerance_mm).size(), 1u);
  const auto torn = [](const Vector2d& p) { return Vector2d(p.x(), p.x() > 0.5 ? 1.0 : 0.0); };
  const auto pieces = carry_bent(line(0, 0, 1, 0), torn, 1e-9);
  EXPECT_LE(pieces.size(), 4096u);
  expect_chain(pieces);
}

}  // namespace
}  // namespace panelcal
