// SPDX-License-Identifier: Apache-2.0
#include "vision/locate/locate.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "vision/fit/detector.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::DetectorInput;
using internal::FittedCandidate;
using Verdict = FittedCandidate::Verdict;

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
    detection.candidates.push_back({c.fit.center.position,
                                    c.fit.size,
                                    c.fit.score,
                                    c.reason,
                                    c.fit.outlines_px,
                                    c.fit.center.cov,
                                    c.fit.center_optical,
                                    c.fit.size_mm,
                                    c.verdict == Verdict::Good});
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

using Detector = std::vector<FittedCandidate> (*)(const DetectorInput&);

Detector detector_of(Shape shape) {
  switch (shape) {
    case Shape::Disc:
    case Shape::Hole:
    case Shape::Ring:
      return internal::detect_rims;
    case Shape::Square:
    case Shape::Diamond:
    case Shape::Cross:
      return internal::detect_cells;
    case Shape::Slot:
      return internal::detect_slots;
    case Shape::Dots:
      return internal::detect_dots;
    case Shape::Template:
      return internal::detect_templates;
    case Shape::AprilTag:
      return internal::detect_tags;
  }
  return internal::detect_rims;
}

std::size_t max_fitted(Shape shape) {
  const bool is_slow = shape == Shape::Slot || shape == Shape::Dots || shape == Shape::Template ||
                       shape == Shape::AprilTag;
  return is_slow ? internal::kMaxFittedSlow : internal::kMaxFitted;
}

Detection locate_checked(const Image& image,
                         const Target& target,
                         const CameraMapping* mapping,
                         const LocateOptions& options) {
  const DetectorInput input{image, target, mapping, options, internal::SearchArea(options)};
  std::vector<FittedCandidate> candidates = detector_of(target.shape)(input);
  const bool lists_all = candidates.size() < max_fitted(target.shape);
  Detection detection = decide(std::move(candidates), options);
  detection.lists_all = lists_all;
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
  } catch (const std::exception& e) {  // OpenCV, memory
    return rejected(std::string("internal error: ") + e.what());
  }
}

}  // namespace panelcal
