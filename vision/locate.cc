// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/locate.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <fmt/format.h>

#include "panelcal/vision/candidate_fit.h"
#include "panelcal/vision/radial_votes.h"
#include "panelcal/vision/rim_rays.h"

namespace panelcal {
namespace {

using internal::ExpectedRim;
using internal::FitFrame;
using internal::FittedCandidate;
using internal::PixelBox;
using Verdict = FittedCandidate::Verdict;

constexpr int kMaxPeaks = 24;       // places looked at along rays
constexpr int kMaxFitted = 8;       // places fitted
constexpr double kSamePlace = 0.3;  // of the radius: nearer candidates are one
/// A rim is worth a fit if its size is off by less than this, or by less than this many times the
/// tolerance: near enough to be the target badly made, not another kind of mark.
constexpr double kNearSize = 0.15;
constexpr double kNearSizeTolerances = 1.5;

/// Where targets may be.
class SearchArea {
 public:
  SearchArea(const LocateOptions& options) {
    if (!options.search_center || !options.search_radius) return;
    center_px_ = options.search_center->in_px();
    radius_px_ = options.search_radius->in_px();
  }

  bool contains(const Eigen::Vector2d& u_px, double slack_px) const {
    return !center_px_ || (u_px - *center_px_).norm() <= radius_px_ + slack_px;
  }

  /// The pixels where edges of a target of this radius may be.
  PixelBox box(const Image& image, double target_radius_px) const {
    if (!center_px_) return {0, 0, image.width(), image.height()};
    const double reach = radius_px_ + 1.3 * target_radius_px + 4;
    const auto clamped = [](double v, int end) {
      return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(end)));
    };
    PixelBox box;
    box.x0 = clamped(std::floor(center_px_->x() - reach), image.width());
    box.y0 = clamped(std::floor(center_px_->y() - reach), image.height());
    box.width = clamped(std::ceil(center_px_->x() + reach) + 1, image.width()) - box.x0;
    box.height = clamped(std::ceil(center_px_->y() + reach) + 1, image.height()) - box.y0;
    return box;
  }

 private:
  std::optional<Eigen::Vector2d> center_px_;
  double radius_px_ = 0;
};

ExpectedRim expected_rim(const Target& target, const CameraMapping* mapping) {
  const double mm_per_px = mapping ? mapping->parameters().scale_mm_per_px : 1;
  const auto in_px = [&](const std::optional<Length>& length,
                         const std::optional<PixelLength>& length_px) -> std::optional<double> {
    if (length) return length->in_mm() / mm_per_px;
    if (length_px) return length_px->in_px();
    return std::nullopt;
  };
  ExpectedRim expected;
  expected.shape = target.shape;
  expected.polarity = target.polarity;
  expected.size_tolerance = target.size_tolerance;
  expected.radius = in_px(target.size, target.size_px).value_or(0) / 2;
  if (const auto inner = in_px(target.inner_size, target.inner_size_px)) {
    expected.inner_radius = *inner / 2;
  }
  return expected;
}

/// A rim seen along rays, with the frame it was seen in.
struct Sighting {
  FitFrame fit_frame;
  internal::RimStart start;
  Eigen::Vector2d center_px;
};

bool is_near_size(const ExpectedRim& expected, double radius) {
  const double limit = std::max(kNearSize, kNearSizeTolerances * expected.size_tolerance);
  return std::abs(radius / expected.radius - 1) < limit;
}

std::vector<Sighting> see_rims(const Image& image,
                               const CameraMapping* mapping,
                               const ExpectedRim& expected,
                               const SearchArea& area,
                               double min_contrast) {
  const auto peaks = internal::radial_votes(image,
                                            area.box(image, expected.radius),
                                            expected.radius,
                                            expected.polarity,
                                            min_contrast,
                                            kMaxPeaks);
  std::vector<Sighting> sightings;
  for (const internal::VotePeak& peak : peaks) {
    if (!area.contains(peak.at_px, 0.5 * expected.radius)) continue;
    const FitFrame fit_frame(mapping, peak.at_px);
    // Rays cross other things too, so their contrast is only roughly that of the target.
    const auto start =
        internal::find_rim(image, fit_frame, Eigen::Vector2d::Zero(), expected, 0.5 * min_contrast);
    if (!start || !is_near_size(expected, start->parameters[internal::kRadius])) continue;
    const auto u = fit_frame.to_image(start->parameters.head<2>());
    if (!u || !area.contains(*u, 2)) continue;
    const bool is_new = std::all_of(sightings.begin(), sightings.end(), [&](const Sighting& s) {
      return (s.center_px - *u).norm() > kSamePlace * expected.radius;
    });
    if (is_new) sightings.push_back({fit_frame, *start, *u});
  }
  std::stable_sort(sightings.begin(), sightings.end(), [](const Sighting& a, const Sighting& b) {
    return a.start.support > b.start.support;
  });
  if (sightings.size() > kMaxFitted)
    sightings.erase(sightings.begin() + kMaxFitted, sightings.end());
  return sightings;
}

/// Good ones first, then unfit ones, then unlikely ones; each by score.
void rank(std::vector<FittedCandidate>& candidates) {
  std::stable_sort(
      candidates.begin(), candidates.end(), [](const FittedCandidate& a, const FittedCandidate& b) {
        if (a.verdict != b.verdict) return a.verdict < b.verdict;
        return a.fit.score > b.fit.score;
      });
}

std::string not_found_reason(const std::vector<FittedCandidate>& candidates) {
  if (candidates.empty()) return "nothing like the target is in the searched area";
  return "the likeliest place does not count: " + candidates.front().reason;
}

Detection decide(std::vector<FittedCandidate> candidates, const LocateOptions& options) {
  rank(candidates);
  Detection detection;
  for (const FittedCandidate& c : candidates) {
    detection.candidates.push_back({c.fit.center.position, c.fit.size, c.fit.score, c.reason});
    detection.n_candidates += c.verdict == Verdict::Good;
  }
  if (candidates.empty() || candidates.front().verdict == Verdict::Unlikely) {
    detection.status = DetectionStatus::NotFound;
    detection.reason = not_found_reason(candidates);
    return detection;
  }
  detection.best = candidates.front().fit;
  if (candidates.front().verdict == Verdict::Unfit) {
    detection.status = DetectionStatus::Rejected;
    detection.reason = candidates.front().reason;
    return detection;
  }
  const double limit = candidates.front().fit.score - options.ambiguity_margin;
  const auto n_equal = std::count_if(candidates.begin(), candidates.end(), [&](const auto& c) {
    return c.verdict == Verdict::Good && c.fit.score >= limit;
  });
  detection.status = n_equal > 1 ? DetectionStatus::Ambiguous : DetectionStatus::Found;
  if (n_equal > 1) {
    detection.reason = fmt::format("{} candidates are equally good, scores {:.2f} and {:.2f}",
                                   n_equal,
                                   candidates[0].fit.score,
                                   candidates[1].fit.score);
  }
  return detection;
}

Detection rejected(std::string reason) {
  Detection detection;
  detection.status = DetectionStatus::Rejected;
  detection.reason = std::move(reason);
  return detection;
}

Detection locate_checked(const Image& image,
                         const Target& target,
                         const CameraMapping* mapping,
                         const LocateOptions& options) {
  const ExpectedRim expected = expected_rim(target, mapping);
  const SearchArea area(options);
  const double min_contrast = options.min_contrast * image.full_scale();
  std::vector<FittedCandidate> candidates;
  for (const Sighting& s : see_rims(image, mapping, expected, area, min_contrast)) {
    auto candidate = internal::fit_candidate(image, s.fit_frame, expected, s.start, options);
    if (area.contains(candidate.fit.center.position.in_px(), 0)) {
      candidates.push_back(std::move(candidate));
    }
  }
  return decide(std::move(candidates), options);
}

Diagnostic bad_option(std::string what, std::string expected) {
  return {Code::TargetInvalid, {}, std::move(what), std::move(expected)};
}

}  // namespace

std::string_view name(DetectionStatus status) {
  switch (status) {
    case DetectionStatus::Found:
      return "found";
    case DetectionStatus::NotFound:
      return "not_found";
    case DetectionStatus::Ambiguous:
      return "ambiguous";
    case DetectionStatus::Rejected:
      return "rejected";
  }
  return {};
}

Expected<void> LocateOptions::validate() const {
  const auto is_share = [](double v) { return v >= 0 && v <= 1; };
  const auto bad_share = [](std::string_view field, double v) {
    return failure(bad_option(fmt::format("{} = {}", field, v), "0 to 1"));
  };
  if (search_radius && !(search_radius->in_px() > 0)) {
    return failure(bad_option(fmt::format("search_radius = {} px", search_radius->in_px()),
                              "a number above 0"));
  }
  if (search_center && !search_center->in_px().allFinite()) {
    return failure(bad_option("search_center is not finite", "a place in the picture"));
  }
  if (!is_share(ambiguity_margin)) return bad_share("ambiguity_margin", ambiguity_margin);
  if (!is_share(min_contrast)) return bad_share("min_contrast", min_contrast);
  if (!is_share(min_score)) return bad_share("min_score", min_score);
  return {};
}

Detection locate(const Image& image,
                 const Target& target,
                 const CameraMapping* mapping,
                 const LocateOptions& options) {
  if (const auto valid = target.validate(); !valid) return rejected(valid.error().text());
  if (const auto valid = options.validate(); !valid) return rejected(valid.error().text());
  if (target.size && !mapping) return rejected("a size in mm needs a camera mapping");
  try {
    return locate_checked(image, target, mapping, options);
  } catch (const std::exception& e) {  // OpenCV, memory
    return rejected(std::string("internal error: ") + e.what());
  }
}

}  // namespace panelcal
