// SPDX-License-Identifier: Apache-2.0
#include "vision/locate/locate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
#include <utility>

#include "vision/fit/detector.h"
#include "vision/fit/place.h"
#include "vision/picture/memory_error.h"
#include "vision/suggest/explain.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::DetectorInput;
using internal::FittedCandidate;
using internal::Verdict;

/// Distance of a candidate from the requested target: a size off by its tolerance counts as a score
/// that is lower by a fifth, and so does a place at the rim of the searched circle.
double distance_from_asked(const FittedCandidate& candidate,
                           const Target& target,
                           const LocateOptions& options) {
  constexpr double kWeight = 0.2;
  double distance = 1 - candidate.fit.score;
  const auto ratio = internal::size_ratio(candidate.fit, target);
  if (ratio && *ratio > 0) {
    distance += kWeight * std::abs(std::log(*ratio)) / std::max(0.01, target.size_tolerance);
  }
  if (options.search_center && options.search_radius) {
    const auto away = candidate.fit.center.position - *options.search_center;
    distance += kWeight * away.in_px().norm() / options.search_radius->in_px();
  }
  return std::isfinite(distance) ? distance : std::numeric_limits<double>::max();
}

/// Good ones first, by score; then the others, the one that is nearest to what is asked for first,
/// since its reason is the one to tell.
void rank(std::vector<FittedCandidate>& candidates,
          const Target& target,
          const LocateOptions& options) {
  const auto key = [&](const FittedCandidate& c) {
    return std::pair(!c.is_good(),
                     c.is_good() ? -c.fit.score : distance_from_asked(c, target, options));
  };
  std::ranges::stable_sort(candidates, {}, key);
}

std::string not_found_reason(const std::vector<FittedCandidate>& candidates) {
  if (candidates.empty()) return "nothing like the target is in the searched area";
  return "the likeliest place does not count: " + candidates.front().judgement.reason;
}

Detection decide(std::vector<FittedCandidate> candidates,
                 const Target& target,
                 const LocateOptions& options) {
  rank(candidates, target, options);
  Detection detection;
  for (const FittedCandidate& c : candidates) {
    detection.candidates.push_back({c.fit.center.position,
                                    c.fit.size,
                                    c.fit.score,
                                    c.judgement.reason,
                                    c.fit.outlines_px,
                                    c.fit.center.cov,
                                    c.fit.center_optical,
                                    c.fit.size_mm,
                                    c.is_good()});
    detection.n_candidates += c.is_good();
  }
  if (candidates.empty() || candidates.front().judgement.verdict == Verdict::Unlikely) {
    detection.status = DetectionStatus::NotFound;
    detection.reason = not_found_reason(candidates);
    return detection;
  }
  detection.best = candidates.front().fit;
  detection.size_ratio = internal::size_ratio(*detection.best, target);
  if (candidates.front().judgement.verdict == Verdict::Unfit) {
    detection.status = DetectionStatus::Rejected;
    detection.reason = candidates.front().judgement.reason;
    return detection;
  }
  const double limit = candidates.front().fit.score - options.ambiguity_margin;
  const auto n_equal = std::count_if(candidates.begin(), candidates.end(), [&](const auto& c) {
    return c.is_good() && c.fit.score >= limit;
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

/// A row of vision/fit/shapes.def.
struct ShapeRow {
  Shape shape;
  internal::Detector* detect;
  std::size_t max_fitted;
};
constexpr std::array kRows = {
#define PANELCAL_SHAPE(shape, word, size, detector, max_fitted) \
  ShapeRow{Shape::shape, internal::detector, internal::max_fitted},
#include "vision/fit/shapes.def"
};

Detection locate_checked(const Image& image,
                         const Target& target,
                         const CameraMapping* mapping,
                         const LocateOptions& options) {
  const DetectorInput input{image, target, mapping, options, internal::SearchArea(options)};
  const ShapeRow& row = *std::ranges::find(kRows, target.shape, &ShapeRow::shape);
  std::vector<FittedCandidate> candidates = row.detect(input);
  const bool lists_all = candidates.size() < row.max_fitted;
  Detection detection = decide(std::move(candidates), target, options);
  detection.lists_all = lists_all;
  const bool is_refused = detection.status == DetectionStatus::NotFound ||
                          detection.status == DetectionStatus::Rejected;
  if (is_refused) internal::explain(input, detection);
  return detection;
}

}  // namespace

Detection locate(const Image& image,
                 const Target& target,
                 const CameraMapping* mapping,
                 const LocateOptions& options) {
  if (const auto valid = target.validate(); !valid) return rejected(valid.error().text());
  if (const auto valid = options.validate(); !valid) return rejected(valid.error().text());
  if (target.size && !mapping) return rejected("a size in mm needs a camera mapping");
  try {
    return locate_checked(image, target, mapping, options);
  } catch (const std::exception& e) {
    internal::rethrow_memory_error(e);
    return rejected(std::string("internal error: ") + e.what());
  }
}

}  // namespace panelcal
