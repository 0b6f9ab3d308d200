// SPDX-License-Identifier: Apache-2.0
#include "machine/plate/tagged_pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "machine/plate/fit.h"
#include "vision/tag/family.h"
#include <Eigen/Geometry>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Greatest distance of a tag from its place by the others, as a part of the pitch: far less than
/// what another dot's place is away, and more than a stage or a camera's calibration errs.
constexpr double kTagReach = 0.25;
/// And by how much it may be turned against them: tags stand in one of four ways, as a rule.
constexpr double kMostTurn_rad = std::numbers::pi / 4;
/// One tag in this number may contradict the others.
constexpr std::size_t kMostContradict = 4;
/// Codes that differ in this number of bits are not taken for each other (vision/tag/reader.h).
constexpr int kSafeDistance = 9;
constexpr int kPoseRounds = 10;

/// A sight beside what the plate's file says of the tag.
struct Known {
  const TagSight* sight;
  const PlateTag* tag;  ///< null: the plate has no such tag
  std::vector<PlacePair> pairs;
};

Eigen::Vector2d middle_of(const TagSight& sight) {
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  for (const auto& corner : sight.corners) sum_mm += corner.in_mm();
  return sum_mm / static_cast<double>(sight.corners.size());
}

class Agreement {
 public:
  Agreement(const CalibrationPlate& plate, const std::vector<TagSight>& sights) : plate_(plate) {
    for (const TagSight& sight : sights) {
      Known known{&sight, plate.tags->find(sight.id), {}};
      if (known.tag != nullptr) {
        const auto corners = corners_of(*plate.tags, *known.tag);
        for (std::size_t i = 0; i < corners.size(); ++i) {
          known.pairs.push_back({corners[i].in_mm(), sight.corners[i].in_mm()});
        }
      }
      all_.push_back(std::move(known));
    }
  }

  /// The pose that most tags of the plate agree with; empty if none is the plate's.
  std::optional<PlatePose> best() const {
    std::optional<PlatePose> best;
    std::size_t n_best = 0;
    for (const Known& seed : all_) {
      if (seed.tag == nullptr) continue;
      const PlatePose pose = grown(best_pose(seed.pairs, {}, Length()));
      const std::size_t n = agreeing(pose).size();
      if (n <= n_best) continue;
      n_best = n;
      best = pose;
      if (is_enough(n, contradicting(pose).size())) break;  // no other can be so, too
    }
    return best;
  }

  static bool is_enough(std::size_t n_agree, std::size_t n_contradict) {
    return n_contradict * kMostContradict <= n_agree + n_contradict;
  }

  /// Tags of the plate that are where a pose has them.
  std::vector<const Known*> agreeing(const PlatePose& pose) const {
    std::vector<const Known*> out;
    for (const Known& known : all_) {
      if (known.tag != nullptr && why_not(known, pose).empty()) out.push_back(&known);
    }
    return out;
  }

  std::vector<const Known*> contradicting(const PlatePose& pose) const {
    std::vector<const Known*> out;
    for (const Known& known : all_) {
      if (!why_not(known, pose).empty()) out.push_back(&known);
    }
    return out;
  }

  /// Reason why a sight contradicts a pose; empty if it does not.
  std::string why_not(const Known& known, const PlatePose& pose) const {
    const int id = known.sight->id;
    const Eigen::Vector2d seen_mm = middle_of(*known.sight);
    if (known.tag == nullptr) {
      const Eigen::Vector2d cell = cell_of(pose, seen_mm);
      const bool is_on_plate =
          cell.minCoeff() > -0.5 && cell.x() < plate_.columns - 0.5 && cell.y() < plate_.rows - 0.5;
      if (!is_on_plate) return {};
      return fmt::format(
          "tag {} lies on the plate at cell ({:.1f}, {:.1f}), and [tags] does not have it",
          id,
          cell.x(),
          cell.y());
    }
    const double beside_mm = (place_in(pose, known.tag->center).in_mm() - seen_mm).norm();
    if (!(beside_mm <= kTagReach * plate_.pitch.in_mm())) {
      return fmt::format("tag {} lies {:.3f} mm beside where the others have it", id, beside_mm);
    }
    const double own_rad = best_pose(known.pairs, {}, Length()).angle_rad;
    const double turn_rad = std::remainder(own_rad - pose.angle_rad, 2 * std::numbers::pi);
    if (std::abs(turn_rad) <= kMostTurn_rad) return {};
    return fmt::format(
        "tag {} is turned by {:.0f} degrees against the others", id, rad(turn_rad).in_deg());
  }

 private:
  /// Fitted again and again to all that agree with it. One tag says little of the angle, so that
  /// the near ones agree at first and far ones later.
  PlatePose grown(PlatePose pose) const {
    std::size_t n_before = 0;
    for (int round = 0; round < kPoseRounds; ++round) {
      std::vector<PlacePair> pairs;
      for (const Known* known : agreeing(pose)) {
        pairs.insert(pairs.end(), known->pairs.begin(), known->pairs.end());
      }
      if (pairs.size() <= n_before) break;
      n_before = pairs.size();
      pose = best_pose(pairs, pose, Length());
    }
    return pose;
  }

  /// A place in pitches from dot (0, 0).
  Eigen::Vector2d cell_of(const PlatePose& pose, const Eigen::Vector2d& machine_mm) const {
    return (Eigen::Rotation2Dd(-pose.angle_rad) * (machine_mm - pose.shift_mm)) /
           plate_.pitch.in_mm();
  }

  const CalibrationPlate& plate_;
  std::vector<Known> all_;
};

tl::unexpected<Diagnostic> pose_refused(std::string what, std::string expected) {
  return failure({Code::CalibrationData, {}, std::move(what), std::move(expected)});
}

}  // namespace

Expected<TaggedPose> pose_from_tags(const CalibrationPlate& plate,
                                    const std::vector<TagSight>& sights) {
  const Agreement agreement(plate, sights);
  const auto pose = agreement.best();
  if (!pose) {
    return pose_refused(
        sights.empty() ? std::string("no picture shows a tag of the plate")
                       : fmt::format("no picture shows a tag of the plate, but there is tag {}",
                                     sights.front().id),
        "a tag of [tags], of its family, polarity and size_mm");
  }
  const auto agreeing = agreement.agreeing(*pose);
  const auto contradicting = agreement.contradicting(*pose);
  if (!Agreement::is_enough(agreeing.size(), contradicting.size())) {
    return pose_refused(fmt::format("{} of {} tags contradict the others: {}",
                                    contradicting.size(),
                                    agreeing.size() + contradicting.size(),
                                    agreement.why_not(*contradicting.front(), *pose)),
                        fmt::format("at most one in {}: tags where [tags] has them, and x, y of "
                                    "images.csv where the axis stood",
                                    kMostContradict));
  }
  const auto family = find_tag_family(plate.tags->family);
  const int id = agreeing.front()->tag->id;
  const bool is_alone =
      std::ranges::all_of(agreeing, [&](const Known* known) { return known->tag->id == id; });
  if (is_alone && family->hamming_distance < kSafeDistance) {
    return pose_refused(
        fmt::format(
            "tag {} is the only one seen, and a tag of {} is easily misread", id, family->name),
        "two tags of the plate, or a family such as tag36h11");
  }
  TaggedPose out{*pose, {}, {}};
  for (const Known* known : contradicting) {
    const std::size_t i_picture = known->sight->i_picture;
    const auto said =
        std::ranges::find(out.contradictions, i_picture, &TaggedPose::Contradiction::i_picture);
    if (said != out.contradictions.end()) continue;
    out.contradictions.push_back({i_picture, agreement.why_not(*known, *pose)});
  }
  for (const Known* known : agreeing) {
    const std::size_t i_picture = known->sight->i_picture;
    const bool is_said =
        std::ranges::count(out.agreeing, i_picture) > 0 ||
        std::ranges::count(out.contradictions, i_picture, &TaggedPose::Contradiction::i_picture) >
            0;
    if (!is_said) out.agreeing.push_back(i_picture);
  }
  return out;
}

}  // namespace panelcal::internal
