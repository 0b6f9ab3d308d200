// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/detector.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

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

/// The fit of a sighting. Where that is not the target, a ring about the same centre that is weaker
/// but of the size may be: a pad in a mask's opening, a dome whose rim is darker than its middle.
FittedCandidate fit_or_look_again(const DetectorInput& input,
                                  const ExpectedRim& expected,
                                  const CircleSighting& sighting,
                                  double min_contrast) {
  FittedCandidate candidate =
      fit_candidate(input.image, sighting.fit_frame, expected, sighting.start, input.options);
  const bool is_good = candidate.verdict == FittedCandidate::Verdict::Good;
  if (sighting.start.at_border) return candidate;
  if (is_good && !may_be_two_edges(input.target, expected, candidate.fit)) return candidate;
  const auto start = find_rim(input.image,
                              sighting.fit_frame,
                              sighting.start.parameters.head<2>(),
                              expected,
                              kStepOfContrast * min_contrast,
                              RimChoice::OfItsSize);
  if (!start) return candidate;
  const bool is_same = is_same_start(*start, sighting.start);
  if (is_same && sighting.start.is_of_its_size) return candidate;
  FittedCandidate other =
      fit_candidate(input.image, sighting.fit_frame, expected, *start, input.options);
  if (other.verdict != FittedCandidate::Verdict::Good) return candidate;
  // What one start was taken for twice has to be plain: arcs of a dome's shading look like a rim.
  const bool is_plain = other.fit.visible > kAllAround && other.fit.blur_px < kBlurOfTwoEdges_px;
  if (is_same && !is_plain) return candidate;
  // An edge of two is wider than either; one that is out of focus stays as wide.
  return is_good && other.fit.blur_px > kOfTheTwo * candidate.fit.blur_px ? candidate : other;
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

std::vector<CircleSighting> see_rims(const Image& image,
                                     const CameraMapping* mapping,
                                     const ExpectedRim& expected,
                                     const SearchArea& area,
                                     double min_contrast,
                                     std::size_t max_fitted) {
  const auto peaks = radial_votes(image,
                                  area.box(image, 1.3 * expected.radius + 4),
                                  expected.radius,
                                  expected.polarity,
                                  min_contrast,
                                  static_cast<int>(kLooks * max_fitted));
  std::vector<CircleSighting> sightings;
  for (const VotePeak& peak : peaks) {
    if (!area.contains(peak.at_px, 0.5 * expected.radius)) continue;
    const FitFrame fit_frame(mapping, peak.at_px);
    const auto start = see_rim(image, fit_frame, expected, kStepOfContrast * min_contrast);
    if (!start) continue;
    const auto u = fit_frame.to_image(start->parameters.head<2>());
    if (!u || !area.contains(*u, 2)) continue;
    const bool is_new =
        std::all_of(sightings.begin(), sightings.end(), [&](const CircleSighting& s) {
          return (s.center_px - *u).norm() > kSameCircle * expected.radius;
        });
    if (is_new) sightings.push_back({fit_frame, *start, *u});
  }
  std::stable_sort(
      sightings.begin(), sightings.end(), [](const CircleSighting& a, const CircleSighting& b) {
        return a.start.support > b.start.support;
      });
  if (sightings.size() > max_fitted) {
    sightings.erase(sightings.begin() + static_cast<std::ptrdiff_t>(max_fitted), sightings.end());
  }
  return sightings;
}

}  // namespace

std::vector<FittedCandidate> detect_rims(const DetectorInput& input) {
  return detect_rims(input, kMaxFitted);
}

std::vector<FittedCandidate> detect_rims(const DetectorInput& input, std::size_t max_fitted) {
  const ExpectedRim expected = expected_rim(input.target, input.mapping);
  const double min_contrast = input.options.min_contrast * input.image.full_scale();
  std::vector<FittedCandidate> candidates;
  for (const CircleSighting& s :
       see_rims(input.image, input.mapping, expected, input.area, min_contrast, max_fitted)) {
    auto candidate = fit_or_look_again(input, expected, s, min_contrast);
    const Eigen::Vector2d& at = candidate.fit.center.position.in_px();
    if (!input.area.contains(at, 0)) continue;
    // Two starts may end at one rim.
    const auto same = std::ranges::find_if(candidates, [&](const FittedCandidate& other) {
      return (other.fit.center.position.in_px() - at).norm() < kSameCircle * expected.radius;
    });
    if (same == candidates.end()) {
      candidates.push_back(std::move(candidate));
    } else if (std::pair(candidate.verdict, -candidate.fit.score) <
               std::pair(same->verdict, -same->fit.score)) {
      *same = std::move(candidate);
    }
  }
  return candidates;
}

}  // namespace panelcal::internal
