// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/detector.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "vision/fit/pipeline.h"
#include "vision/fit/place.h"
#include "vision/round/candidate_fit.h"
#include "vision/round/radial_votes.h"
#include "vision/round/rays.h"

namespace panelcal::internal {
namespace {

constexpr std::size_t kLooks = 2;    // places looked at along rays for each one fitted
constexpr double kSameCircle = 0.3;  // of the radius: nearer candidates are one
/// Rays cross other things too, so their contrast is only roughly that of the target.
constexpr double kStepOfContrast = 0.5;
constexpr double kSameStart_px = 0.5;
/// Two rings of one kind that are 2 px apart are together so blurred, or more.
constexpr double kBlurOfTwoEdges_px = 1.5;
constexpr double kOfTheTwo = 0.7;
constexpr double kAllAround = 0.9;  // of the rim
/// Of the tolerance: an edge of two is beside the size of either.
constexpr double kBetweenTwo = 0.25;

ExpectedRim expected_rim(const Target& target, const CameraMapping* mapping) {
  ExpectedRim expected;
  expected.shape = target.shape;
  expected.polarity = target.polarity;
  expected.size_tolerance = target.size_tolerance;
  expected.radius = frame_length(target.size, target.size_px, mapping).value_or(0) / 2;
  if (const auto inner = frame_length(target.inner_size, target.inner_size_px, mapping)) {
    expected.inner_radius = *inner / 2;
  }
  return expected;
}

/// A rim seen along rays, with the frame it was seen in.
struct CircleSighting {
  FitFrame fit_frame;
  RimStart start;
  Eigen::Vector2d center_px;
};

bool is_near_size(const ExpectedRim& expected, double radius) {
  return std::abs(radius / expected.radius - 1) < expected.near_size();
}

/// True if fits from both would be the same.
bool is_same_start(const RimStart& a, const RimStart& b) {
  const RimVector difference = a.parameters - b.parameters;
  return difference.head<2>().norm() < kSameStart_px &&
         std::abs(difference[kRadius]) < kSameStart_px;
}

/// True if a good fit may be of two edges together, which is wide, and of a size between theirs.
bool may_be_two_edges(const Target& target, const ExpectedRim& expected, const TargetFit& fit) {
  if (fit.blur_px < kBlurOfTwoEdges_px) return false;
  const double ratio = size_ratio(fit, target).value_or(1);
  return std::abs(ratio - 1) > kBetweenTwo * expected.size_tolerance;
}

/// The strongest rim about a place, or, if that is not near the size, one that is.
std::optional<RimStart> see_rim(const Image& image,
                                const FitFrame& fit_frame,
                                const ExpectedRim& expected,
                                double least_step) {
  const Eigen::Vector2d center = Eigen::Vector2d::Zero();
  for (const RimChoice choice : {RimChoice::Strongest, RimChoice::OfItsSize}) {
    auto start = find_rim(image, fit_frame, center, expected, least_step, choice);
    if (start && is_near_size(expected, start->parameters[kRadius])) return start;
  }
  return std::nullopt;
}

/// Discs, holes and rings.
class Rims {
 public:
  using Sighting = CircleSighting;
  using Fit = RimFit;

  Rims(const DetectorInput& input, std::size_t max_fitted)
      : input_(input),
        expected_(expected_rim(input.target, input.mapping)),
        least_step_(kStepOfContrast * input.min_contrast()),
        max_fitted_(max_fitted) {}

  /// Nearer candidates are one: two starts may end at one rim.
  double apart_px() const { return kSameCircle * expected_.radius; }

  Proposals<Sighting> propose() const {
    const auto peaks = radial_votes(input_.image,
                                    input_.area.box(input_.image, 1.3 * expected_.radius + 4),
                                    expected_.radius,
                                    expected_.polarity,
                                    input_.min_contrast(),
                                    static_cast<int>(kLooks * max_fitted_));
    std::vector<Sighting> sightings;
    for (const VotePeak& peak : peaks) {
      if (!input_.area.contains(peak.at_px, 0.5 * expected_.radius)) continue;
      const FitFrame fit_frame(input_.mapping, peak.at_px);
      const auto start = see_rim(input_.image, fit_frame, expected_, least_step_);
      if (!start) continue;
      const auto u = fit_frame.to_image(start->parameters.head<2>());
      if (!u || !input_.area.contains(*u, 2)) continue;
      const bool is_new = std::ranges::all_of(
          sightings, [&](const Sighting& s) { return (s.center_px - *u).norm() > apart_px(); });
      if (is_new) sightings.push_back({fit_frame, *start, *u});
    }
    std::ranges::stable_sort(
        sightings, std::ranges::greater(), [](const Sighting& s) { return s.start.support; });
    if (sightings.size() > max_fitted_) {
      sightings.erase(sightings.begin() + static_cast<std::ptrdiff_t>(max_fitted_),
                      sightings.end());
    }
    return {std::move(sightings)};
  }

  /// Where a sighting is not the target, a ring about the same centre that is weaker but of the
  /// size may be: a pad in a mask's opening, a dome whose rim is darker than its middle.
  Fit fit(const Sighting& sighting) const {
    Fit fit = fit_candidate(input_, sighting.fit_frame, expected_, sighting.start);
    if (sighting.start.at_border) return fit;
    const bool is_good = judge(fit).verdict == Verdict::Good;
    if (is_good && !may_be_two_edges(input_.target, expected_, fit.target)) return fit;
    const auto start = find_rim(input_.image,
                                sighting.fit_frame,
                                sighting.start.parameters.head<2>(),
                                expected_,
                                least_step_,
                                RimChoice::OfItsSize);
    if (!start) return fit;
    const bool is_same = is_same_start(*start, sighting.start);
    if (is_same && sighting.start.is_of_its_size) return fit;
    Fit other = fit_candidate(input_, sighting.fit_frame, expected_, *start);
    if (judge(other).verdict != Verdict::Good) return fit;
    // What one start was taken for twice has to be plain: arcs of a dome's shading look like a rim.
    const double blur_px = other.target.blur_px;
    const bool is_plain = other.target.visible > kAllAround && blur_px < kBlurOfTwoEdges_px;
    if (is_same && !is_plain) return fit;
    // An edge of two is wider than either; one that is out of focus stays as wide.
    return is_good && blur_px > kOfTheTwo * fit.target.blur_px ? fit : other;
  }

  Judgement judge(const Fit& fit) const { return judge_rim(input_, expected_, fit); }

 private:
  const DetectorInput& input_;
  ExpectedRim expected_;
  double least_step_;  ///< grey levels, of an edge
  std::size_t max_fitted_;
};

}  // namespace

std::vector<FittedCandidate> detect_rims(const DetectorInput& input) {
  return detect_rims(input, kMaxFitted);
}

std::vector<FittedCandidate> detect_rims(const DetectorInput& input, std::size_t max_fitted) {
  const Rims rims(input, max_fitted);
  return detect(input, rims, rims.apart_px());
}

}  // namespace panelcal::internal
