// SPDX-License-Identifier: Apache-2.0
#include "program/geometry/arcs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/base/plane_vectors.h"

namespace panelcal {
namespace {

using internal::cross;
using internal::left_of;

constexpr double kMaxMismatch = 0.03;  // of the radius (semantics page, I/J)
constexpr double kRoundingSteps = 3;   // start, end, I and J rounded by half a step in x and y each
constexpr double kRelativeNoise = 1e-12;
constexpr double kStraightArc_mm = 1e-9;
constexpr double kSimilarity = 1e-12;  // what composing rotations leaves of unequal stretch
constexpr int kMaxHalvings = 12;       // 4096 pieces

/// The line between the ends and the unit vector from it to where the centre belongs.
struct Chord {
  Eigen::Vector2d middle_mm;
  Eigen::Vector2d inward;
  double half_mm;

  Chord(const Eigen::Vector2d& start_mm, const Eigen::Vector2d& end_mm, bool clockwise)
      : middle_mm(0.5 * (start_mm + end_mm)), half_mm(0.5 * (end_mm - start_mm).norm()) {
    const Eigen::Vector2d left = left_of(end_mm - start_mm) / (2 * half_mm);
    inward = clockwise ? Eigen::Vector2d(-left) : left;
  }
};

/// An arc with its ends but no centre yet, and what can be said against it already.
ArcFit begin_fit(const Eigen::Vector2d& start_mm,
                 const Eigen::Vector2d& end_mm,
                 double radius_mm,
                 bool clockwise,
                 double rounding_mm) {
  ArcFit fit{.arc = {start_mm, end_mm, start_mm, clockwise}};
  const double length_mm = (end_mm - start_mm).norm();
  if (!std::isfinite(length_mm) || !std::isfinite(radius_mm) || radius_mm < 0) {
    fit.fault = ArcFault::RadiusMismatch;
    // One step of the file's grid is a chord, also when its length comes out a hair shorter.
  } else if (length_mm == 0 || length_mm < rounding_mm * (1 - 1e-6)) {
    fit.fault = ArcFault::NoChord;
  }
  return fit;
}

/// One reading of I and J.
struct Candidate {
  Eigen::Vector2d center_mm;
  double mismatch_mm = 0;  // of its distances from start and end
  double inward_mm = 0;    // from the chord, positive on the side where the centre belongs
  int rank = 0;

  // The readings from the best to the worst. A centre that fits to the last digit but makes more
  // than half a circle rules before one that has to be adjusted.
  enum Rank { Exact, ExactButTooLong, Adjustable, Unfit };
  bool is_faulty() const { return rank == ExactButTooLong || rank == Unfit; }
};

Candidate judge(const Eigen::Vector2d& center_mm,
                const Eigen::Vector2d& end_mm,
                const Chord& chord,
                double radius_mm,
                double grain_mm) {
  Candidate candidate{.center_mm = center_mm};
  candidate.mismatch_mm = std::abs((end_mm - center_mm).norm() - radius_mm);
  candidate.inward_mm = chord.inward.dot(center_mm - chord.middle_mm);
  const bool is_exact = candidate.mismatch_mm <= kRoundingSteps * grain_mm;
  const bool is_inside = candidate.inward_mm >= -kRoundingSteps * grain_mm;
  const double fitted_mm = std::hypot(chord.half_mm, std::max(candidate.inward_mm, 0.0));
  const double limit_mm = kMaxMismatch * radius_mm;
  if (is_exact) {
    candidate.rank = is_inside ? Candidate::Exact : Candidate::ExactButTooLong;
  } else if (is_inside && candidate.mismatch_mm <= limit_mm &&
             std::abs(fitted_mm - radius_mm) <= limit_mm) {
    candidate.rank = Candidate::Adjustable;
  } else {
    candidate.rank = Candidate::Unfit;
  }
  return candidate;
}

const Candidate& better(const Candidate& manual, const Candidate& cam) {
  if (manual.rank != cam.rank) return manual.rank < cam.rank ? manual : cam;
  const bool is_tie = manual.rank == Candidate::Exact || manual.rank == Candidate::ExactButTooLong;
  return is_tie || manual.mismatch_mm <= cam.mismatch_mm ? manual : cam;
}

/// The image of an arc, a piece of an ellipse: q(theta) for theta between -half_turn and half_turn,
/// the angle at the original centre from the arc's middle.
class ArcImage {
 public:
  ArcImage(const Arc& arc,
           const Eigen::Matrix2d& linear,
           const Eigen::Vector2d& translation_mm,
           bool image_clockwise)
      : linear_(linear), translation_mm_(translation_mm), is_clockwise_(image_clockwise) {
    const Chord chord(arc.start_mm, arc.end_mm, arc.clockwise);
    const double depth_mm = chord.inward.dot(arc.center_mm - chord.middle_mm);
    middle_mm_ = chord.middle_mm;
    outward_ = -chord.inward;
    along_ = (arc.end_mm - arc.start_mm) / (2 * chord.half_mm);
    radius_mm_ = std::hypot(chord.half_mm, depth_mm);
    half_turn_rad_ = std::atan2(chord.half_mm, depth_mm);
    const Eigen::Matrix2d gram = linear.transpose() * linear;
    sum_ = gram.trace();
    anisotropy_ = std::hypot(gram(0, 0) - gram(1, 1), 2 * gram(0, 1));
  }

  bool is_similarity() const { return sum_ > 0 && anisotropy_ <= kSimilarity * sum_; }
  /// Of a similarity's image.
  double sagitta_mm() const { return rise_mm(0) * std::sqrt(0.5 * sum_); }

  void split(const Eigen::Vector2d& start_mm,
             const Eigen::Vector2d& end_mm,
             double tolerance_mm,
             std::vector<Arc>& out) const {
    split({-half_turn_rad_, half_turn_rad_, start_mm, end_mm}, tolerance_mm, 0, out);
  }

 private:
  struct Span {
    double from_rad;
    double to_rad;
    Eigen::Vector2d start_mm;
    Eigen::Vector2d end_mm;
  };

  /// An arc and how far at most it is from the ellipse.
  struct Piece {
    Arc arc;
    double deviation_mm = std::numeric_limits<double>::infinity();
  };

  void split(const Span& span, double tolerance_mm, int n_halvings, std::vector<Arc>& out) const {
    const Piece piece = fit(span);
    if (n_halvings == kMaxHalvings || piece.deviation_mm <= tolerance_mm) {
      out.push_back(piece.arc);
      return;
    }
    const double theta = 0.5 * (span.from_rad + span.to_rad);
    const Eigen::Vector2d q_mm =
        linear_ * (middle_mm_ + rise_mm(theta) * outward_ + radius_mm_ * std::sin(theta) * along_) +
        translation_mm_;
    split({span.from_rad, theta, span.start_mm, q_mm}, tolerance_mm, n_halvings + 1, out);
    split({theta, span.to_rad, q_mm, span.end_mm}, tolerance_mm, n_halvings + 1, out);
  }

  /// r (cos theta - cos half_turn), without the cancellation of flat arcs.
  double rise_mm(double theta) const {
    return 2 * radius_mm_ * std::sin(0.5 * (half_turn_rad_ + theta)) *
           std::sin(0.5 * (half_turn_rad_ - theta));
  }

  /// Puts a circle through both ends and the middle of a piece and bounds its deviation.
  ///
  /// With x along the image of the piece's own chord, from its middle, y to the side of the bulge,
  ///   q(theta) = (ux (cos theta - cos phi) + v sin theta, uy (cos theta - cos phi)) r
  /// for -phi <= theta <= phi. Put into the circle's equation this is a trigonometric polynomial of
  /// degree 2. Its zeros are -phi, 0, phi and one more, psi, that its leading coefficients tell:
  ///   F = |q - c|^2 - R^2 = 4 r^2 (s1^2 - s2^2) prod sin((theta - zero) / 2)
  /// up to its sign, s1 and s2 being the singular values of the map. A point at F is at most
  /// |F| / (R + sqrt(R^2 - |F|)) from the circle.
  Piece fit(const Span& span) const {
    const double phi = 0.5 * (span.to_rad - span.from_rad);
    const double theta = 0.5 * (span.to_rad + span.from_rad);
    const Eigen::Vector2d u = linear_ * (std::cos(theta) * outward_ + std::sin(theta) * along_);
    const Eigen::Vector2d v = linear_ * (std::cos(theta) * along_ - std::sin(theta) * outward_);
    const double v_norm = v.norm();
    const double ux = v_norm > 0 ? u.dot(v) / v_norm : u.norm();
    const double uy = v_norm > 0 ? std::abs(cross(v, u)) / v_norm : 0;
    const double sin_half = std::sin(0.5 * phi);
    const double rise_mm = 2 * radius_mm_ * sin_half * sin_half;
    const double half_mm = radius_mm_ * std::sin(phi) * v_norm;
    const double sagitta_mm = rise_mm * uy;
    const double lean_mm = rise_mm * ux;

    const Eigen::Vector2d middle_mm = 0.5 * (span.start_mm + span.end_mm);
    Piece piece{.arc = {span.start_mm, span.end_mm, middle_mm, is_clockwise_, true}};
    if (phi > 0.5 * std::numbers::pi + 1e-9) return piece;  // more than half a circle: split it
    // If x(theta) does not turn round, the piece keeps between its ends.
    const double advance = v_norm * std::cos(phi) - std::abs(ux) * std::sin(phi);
    if (sagitta_mm < kStraightArc_mm) {
      piece.deviation_mm = sagitta_mm + (advance >= 0 ? 0 : std::abs(lean_mm));
      return piece;
    }

    double depth_mm = 0.5 * (half_mm * half_mm - lean_mm * lean_mm) / sagitta_mm - 0.5 * sagitta_mm;
    double bound_mm2 = three_point_bound_mm2(phi, u, v);
    if (depth_mm < 0) {  // F of the half circle differs by 2 depth y
      bound_mm2 -= 2 * depth_mm * sagitta_mm;
      depth_mm = 0;
    }
    const Eigen::Vector2d left = left_of(span.end_mm - span.start_mm).normalized();
    const Eigen::Vector2d center_mm = middle_mm + (is_clockwise_ ? -depth_mm : depth_mm) * left;
    if (!center_mm.allFinite()) return piece;
    piece.arc.center_mm = center_mm;
    piece.arc.straight = false;
    // Seen from the centre the piece must run from its start to its end without turning round, or
    // being near the circle would not be being near the arc. Least value of the angular speed:
    const double turning_mm = uy * v_norm * rise_mm + depth_mm * advance;
    const double radius_mm = std::hypot(half_mm, depth_mm);
    const double rest_mm2 = radius_mm * radius_mm - bound_mm2;
    if (turning_mm > 0 && rest_mm2 >= 0) {
      piece.deviation_mm = bound_mm2 / (radius_mm + std::sqrt(rest_mm2));
    }
    return piece;
  }

  /// The greatest |F| of `fit`, or a little more: the first three factors at their common maximum,
  /// the fourth at its own.
  double three_point_bound_mm2(double phi,
                               const Eigen::Vector2d& u,
                               const Eigen::Vector2d& v) const {
    const double psi = 2 * std::atan2(2 * u.dot(v), u.squaredNorm() - v.squaredNorm());
    const bool has_peak =
        std::abs(std::remainder(psi - std::numbers::pi, 2 * std::numbers::pi)) <= phi;
    const double fourth = has_peak ? 1
                                   : std::max(std::abs(std::sin(0.5 * (phi - psi))),
                                              std::abs(std::sin(0.5 * (phi + psi))));
    const double w = std::sin(0.5 * phi);
    const double three = 2 * w * w * w / (3 * std::numbers::sqrt3);
    return 4 * radius_mm_ * radius_mm_ * anisotropy_ * three * fourth;
  }

  Eigen::Matrix2d linear_;
  Eigen::Vector2d translation_mm_;
  bool is_clockwise_;
  Eigen::Vector2d middle_mm_;  // of the original chord
  Eigen::Vector2d outward_;    // unit, from the chord to the arc's middle
  Eigen::Vector2d along_;      // unit, from start to end
  double radius_mm_;
  double half_turn_rad_;
  double sum_;         // of the map's squared singular values
  double anisotropy_;  // their difference
};

}  // namespace

ArcFit arc_from_radius(const Eigen::Vector2d& start_mm,
                       const Eigen::Vector2d& end_mm,
                       double radius_mm,
                       bool clockwise,
                       double rounding_mm) {
  ArcFit fit = begin_fit(start_mm, end_mm, radius_mm, clockwise, rounding_mm);
  if (fit.fault != ArcFault::None) return fit;
  const Chord chord(start_mm, end_mm, clockwise);
  const double lacking_mm = chord.half_mm - radius_mm;
  const double noise_mm = kRelativeNoise * (start_mm.norm() + end_mm.norm());
  if (lacking_mm > rounding_mm + noise_mm) fit.adjusted_mm = lacking_mm;
  const double depth_mm =
      lacking_mm >= 0 ? 0 : std::sqrt(-lacking_mm) * std::sqrt(radius_mm + chord.half_mm);
  fit.arc.center_mm = chord.middle_mm + depth_mm * chord.inward;
  return fit;
}

ArcFit arc_from_center_offset(const Eigen::Vector2d& start_mm,
                              const Eigen::Vector2d& end_mm,
                              const Eigen::Vector2d& ij_mm,
                              bool clockwise,
                              double rounding_mm) {
  const double radius_mm = ij_mm.norm();
  ArcFit fit = begin_fit(start_mm, end_mm, radius_mm, clockwise, rounding_mm);
  if (fit.fault != ArcFault::None) return fit;
  const Chord chord(start_mm, end_mm, clockwise);
  const double grain_mm =
      rounding_mm + kRelativeNoise * (start_mm.norm() + end_mm.norm() + radius_mm);
  const Candidate manual = judge(start_mm - ij_mm, end_mm, chord, radius_mm, grain_mm);
  const Candidate cam = judge(start_mm + ij_mm, end_mm, chord, radius_mm, grain_mm);
  const Candidate& best = better(manual, cam);
  if (best.is_faulty()) {
    fit.fault = ArcFault::RadiusMismatch;
    fit.arc.center_mm = best.center_mm;
    fit.adjusted_mm = best.mismatch_mm;
    return fit;
  }
  const double depth_mm = std::max(best.inward_mm, 0.0);
  fit.arc.center_mm = chord.middle_mm + depth_mm * chord.inward;
  // Over a chord of a few steps rounding can change the radius of a big circle a lot, though not
  // the path: radii that rounding explains count as unchanged.
  const double change_mm = std::abs(std::hypot(chord.half_mm, depth_mm) - radius_mm);
  if (best.rank == Candidate::Adjustable && change_mm > grain_mm) fit.adjusted_mm = change_mm;
  return fit;
}

std::vector<Arc> carry_arc(const Arc& arc,
                           const Eigen::Matrix2d& linear,
                           const Eigen::Vector2d& translation_mm,
                           double tolerance_mm) {
  const bool flips = cross(linear.col(0), linear.col(1)) < 0;
  Arc image;
  image.start_mm = linear * arc.start_mm + translation_mm;
  image.end_mm = linear * arc.end_mm + translation_mm;
  image.center_mm = 0.5 * (image.start_mm + image.end_mm);
  image.clockwise = arc.clockwise != flips;
  image.straight = true;
  const double chord_mm = (arc.end_mm - arc.start_mm).norm();
  const bool is_finite = std::isfinite(chord_mm) && arc.center_mm.allFinite() &&
                         linear.allFinite() && image.start_mm.allFinite() &&
                         image.end_mm.allFinite();
  if (!is_finite || arc.straight || chord_mm == 0) return {image};

  const ArcImage splitter(arc, linear, translation_mm, image.clockwise);
  if (splitter.is_similarity()) {
    image.straight = splitter.sagitta_mm() < kStraightArc_mm;
    if (!image.straight) image.center_mm = linear * arc.center_mm + translation_mm;
    return {image};
  }
  std::vector<Arc> pieces;
  splitter.split(image.start_mm, image.end_mm, tolerance_mm, pieces);
  return pieces;
}

}  // namespace panelcal
