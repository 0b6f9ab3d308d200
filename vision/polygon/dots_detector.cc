// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/fit/pipeline.h"
#include "vision/polygon/dot_code.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Residuals may be larger than the dots' covariances say by chance in one of some ten thousand
/// codes; and by this part of the size tolerance, as dots are etched no better than that.
constexpr double kChiSquareSigmas = 4;
constexpr double kDotSigmas = 3;
/// Discs in view that are fitted.
constexpr std::size_t kMaxDiscs = 200;

/// A distance of the code's unit (mm or px) in the picture, the largest that a lens may make of it.
double reach_px(const DetectorInput& input) {
  double reach = 0;
  for (const Eigen::Vector2d& dot : input.target.dots) reach = std::max(reach, dot.norm());
  if (input.mapping) reach /= input.mapping->parameters().scale_mm_per_px;
  constexpr double kLens = 1.1;
  return kLens * (1 + input.target.size_tolerance) * reach;
}

double dot_size(const DetectorInput& input) {
  return input.target.size ? input.target.size->in_mm() : input.target.size_px->in_px();
}

DotCode dot_code_of(const DetectorInput& input) {
  const Target& target = input.target;
  DotCode code;
  code.dots = target.dots;
  code.turn = target.angle.in_rad();
  code.turn_tolerance = target.angle_tolerance.in_rad();
  code.scale_tolerance = target.size_tolerance;
  code.place_tolerance = kDotPlaceTolerance * dot_size(input);
  // Target says mm with a mapping; sizes in px with a mapping are pixels all the same.
  code.fits_scale = !target.size;
  return code;
}

/// Every dot-like disc where the code's dots may be.
std::vector<FittedCandidate> find_dots(const DetectorInput& input) {
  Target disc = input.target;
  disc.shape = Shape::Disc;
  disc.dots.clear();
  LocateOptions options = input.options;
  if (options.search_radius) {
    options.search_radius = px(options.search_radius->in_px() + reach_px(input));
  }
  return detect_rims({input.image, disc, input.mapping, options, SearchArea(options)}, kMaxDiscs);
}

SeenDot seen_dot(const FittedCandidate& dot, bool in_mm) {
  if (in_mm && dot.fit.center_optical) {
    return {dot.fit.center_optical->position.in_mm(), dot.fit.center_optical->cov};
  }
  return {dot.fit.center.position.in_px(), dot.fit.center.cov};
}

/// The common values of the dots are the code's: means, or the worst of them.
void fill_from_dots(const std::vector<const TargetFit*>& dots, int n_asked, TargetFit& fit) {
  const double n = static_cast<double>(dots.size());
  double size_px = 0;
  double size_mm = 0;
  for (const TargetFit* dot : dots) {
    size_px += dot->size.in_px() / n;
    if (dot->size_mm) size_mm += dot->size_mm->in_mm() / n;
    fit.score += dot->score / n;
    fit.blur_px += dot->blur_px / n;
    fit.background += dot->background / n;
    fit.contrast += dot->contrast / n;
    fit.noise += dot->noise / n;
    fit.excluded += dot->excluded / n;
    fit.visible += dot->visible / n;
    fit.axis_ratio = std::min(fit.axis_ratio, dot->axis_ratio);
    fit.outlines_px.insert(fit.outlines_px.end(), dot->outlines_px.begin(), dot->outlines_px.end());
  }
  fit.size = px(size_px);
  if (dots.front()->size_mm) fit.size_mm = mm(size_mm);
  const double seen = n / n_asked;
  fit.score *= seen;
  fit.visible *= seen;
}

/// The place of the code in the picture and, with a mapping, in Optical. False if the lens model
/// cannot draw it there, which may happen far beside the dots.
bool fill_place(const DetectorInput& input,
                const DotPose& pose,
                bool in_mm,
                const Eigen::Matrix2d& cov,
                TargetFit& fit) {
  fit.angle = rad(pose.turn);
  if (!in_mm) {
    fit.center = {position_px<frame::Image>(pose.at), cov};
    if (input.mapping) fit.center_optical = (*input.mapping)(fit.center);
    return true;
  }
  fit.center_optical = PositionEstimate<frame::Optical>{position_mm<frame::Optical>(pose.at), cov};
  const auto u = input.mapping->image_of(fit.center_optical->position);
  if (!u) return false;
  const Eigen::Matrix2d px_from_mm = input.mapping->jacobian(*u).inverse();
  fit.center = {*u, propagate(px_from_mm, cov)};
  return true;
}

/// Of a code whose dots were found.
Problem code_problem(const DetectorInput& input,
                     const DotCode& code,
                     const DotPose& pose,
                     bool in_mm) {
  const double expected = pose.degrees_of_freedom;
  const double limit =
      expected + kChiSquareSigmas * std::sqrt(2 * expected) + kChiSquareSigmas * kChiSquareSigmas;
  const double tolerance = input.target.size_tolerance * dot_size(input);
  const char* unit = in_mm ? "mm" : "px";
  if (pose.chi_square > limit && pose.worst > tolerance) {
    return fmt::format(
        "the dots are not where the code has them: dot {} is off by {:.3g} {}; {:.3g} are allowed",
        pose.worst_dot + 1,
        pose.worst,
        unit,
        tolerance);
  }
  const double scale = std::exp(pose.log_scale) - 1;
  if (std::abs(scale) > code.scale_tolerance + kDotSigmas * std::sqrt(pose.cov(3, 3))) {
    return fmt::format(
        "its dots are {:+.1f} % further apart than the code has them; {:.1f} % are allowed",
        100 * scale,
        100 * code.scale_tolerance);
  }
  return turn_problem(pose.turn - code.turn, std::sqrt(pose.cov(2, 2)), code.turn_tolerance);
}

/// Arrangements of equal discs.
class DotCodes {
 public:
  using Sighting = DotAssignment;
  struct Fit {
    TargetFit target;
    DotPose pose;
    bool is_drawn = true;  ///< the lens model reaches its place
  };

  explicit DotCodes(const DetectorInput& input)
      : input_(input),
        code_(dot_code_of(input)),
        own_turn_rad_(self_turn(code_)),
        in_mm_(!code_.fits_scale && input.mapping != nullptr) {
    if (own_turn_rad_) return;
    for (FittedCandidate& dot : find_dots(input)) {
      if (!dot.is_good()) continue;
      seen_.push_back(seen_dot(dot, in_mm_));
      dots_.push_back(std::move(dot));
    }
  }

  Proposals<Sighting> propose() const {
    if (own_turn_rad_) {
      return {{},
              unfit(fmt::format("the code looks the same when turned by {:.0f} degrees: a smaller "
                                "angle_tolerance is needed, or another code",
                                rad(*own_turn_rad_).in_deg()))};
    }
    if (seen_.empty()) return {};
    const int n = static_cast<int>(code_.dots.size());
    return {
        match_dots(code_, seen_),
        unlikely(fmt::format("no {} of the code's {} dots are in their places; {} dots are seen",
                             least_dots(n),
                             n,
                             seen_.size()))};
  }

  Fit fit(const Sighting& assignment) const {
    Fit fit{.target = {}, .pose = fit_dots(code_, seen_, assignment)};
    const DotPose& pose = fit.pose;
    std::vector<const TargetFit*> own;
    for (const auto& i : assignment) {
      if (i) own.push_back(&dots_[static_cast<std::size_t>(*i)].fit);
    }
    fit.target.visible = 0;
    fill_from_dots(own, static_cast<int>(assignment.size()), fit.target);
    // Dots that are etched worse than they are seen: their scatter counts.
    const double dof = pose.degrees_of_freedom;
    const bool is_scattered = pose.chi_square > dof + kDotSigmas * std::sqrt(2 * dof);
    const double factor = is_scattered && dof > 0 ? std::max(1.0, pose.chi_square / dof) : 1;
    const Eigen::Matrix2d cov = factor * pose.cov.topLeftCorner<2, 2>();
    fit.is_drawn = fill_place(input_, pose, in_mm_, cov, fit.target);
    fit.target.angle_sigma = rad(std::sqrt(factor * pose.cov(2, 2)));
    return fit;
  }

  Judgement judge(const Fit& fit) const {
    if (!fit.is_drawn) return unlikely("its place is where the camera mapping ends");
    if (auto problem = code_problem(input_, code_, fit.pose, in_mm_)) {
      return unfit(*std::move(problem));
    }
    if (auto problem = score_problem(fit.target.score, input_.options.min_score))
      return unlikely(*std::move(problem));
    return {};
  }

 private:
  const DetectorInput& input_;
  DotCode code_;
  std::optional<double> own_turn_rad_;  ///< by which it looks the same
  bool in_mm_;
  std::vector<FittedCandidate> dots_;
  std::vector<SeenDot> seen_;
};

}  // namespace

std::vector<FittedCandidate> detect_dots(const DetectorInput& input) {
  return detect(input, DotCodes(input));
}

}  // namespace panelcal::internal
