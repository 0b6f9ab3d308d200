// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/located_json.h"

#include <cmath>

#include "vision/show/overlay.h"

namespace panelcal {
namespace {

using facts::Json;

/// To `decimals` digits behind the point, as much as a picture tells.
Json rounded(double value, int decimals) {
  const double unit = std::pow(10, decimals);
  return facts::number(std::round(value * unit) / unit);
}

void add_center(const TargetFit& fit, Json& row) {
  row.update({{"center_px", facts::point(fit.center.position.in_px())},
              {"cov_px", facts::covariance(fit.center.cov)},
              {"size_px", rounded(fit.size.in_px(), 4)},
              {"angle_rad", rounded(fit.angle.in_rad(), 6)},
              {"score", rounded(fit.score, 4)}});
}

void add_details(const TargetFit& fit, Json& row) {
  row.update({{"visible", rounded(fit.visible, 4)},
              {"blur_px", rounded(fit.blur_px, 4)},
              {"noise", rounded(fit.noise, 4)}});
  if (fit.axis_ratio != 1) row["axis_ratio"] = rounded(fit.axis_ratio, 6);
  if (!fit.hole_offset_px.isZero(0)) row["hole_offset_px"] = facts::point(fit.hole_offset_px);
  if (fit.blind_direction) row["blind_rad"] = rounded(fit.blind_direction->in_rad(), 6);
  if (fit.tag_id) row["id"] = *fit.tag_id;
  for (const auto& corner : fit.corners) {
    row["corners_px"].push_back(facts::point(corner.position.in_px()));
  }
}

Json others_of(const Detection& detection) {
  Json out = Json::array();
  for (const Candidate& other : other_candidates(detection)) {
    Json& row = out.emplace_back(Json{{"center_px", facts::point(other.center.in_px())},
                                      {"size_px", rounded(other.size.in_px(), 4)},
                                      {"score", rounded(other.score, 4)}});
    if (!other.reason.empty()) row["reason"] = other.reason;
  }
  return out;
}

}  // namespace

Json located_row(const LocatedTarget& located, const Detection& detection) {
  Json row = {{"image", located.image}, {"tool", located.tool}, {"status", name(detection.status)}};
  const bool is_found = detection.status == DetectionStatus::Found;
  if (is_found) add_center(*detection.best, row);
  row["candidates"] = detection.n_candidates;
  if (!detection.reason.empty()) row["reason"] = detection.reason;
  if (is_found) add_details(*detection.best, row);
  if (located.lists_candidates || detection.status == DetectionStatus::Ambiguous) {
    row["others"] = others_of(detection);
  }
  return row;
}

Json suggested_row(const PictureMarks& picture) {
  Json groups = Json::array();
  for (const MarkGroup& group : group_marks(picture.marks)) {
    const SeenMark& best = group.best();
    Json& row =
        groups.emplace_back(Json{{"shape", name(best.shape)}, {"polarity", name(best.polarity)}});
    if (!best.family.empty()) row["family"] = best.family;
    row["size_px"] = rounded(group.size.in_px(), 2);
    row["contrast"] = rounded(group.contrast, 4);
    for (const SeenMark& mark : group.marks) {
      const Eigen::Vector2d& center_px = mark.center.in_px();
      Json& one = row["marks"].emplace_back(
          Json{{"center_px", {rounded(center_px.x(), 2), rounded(center_px.y(), 2)}},
               {"size_px", rounded(mark.size.in_px(), 2)},
               {"angle_rad", rounded(mark.angle.in_rad(), 4)},
               {"contrast", rounded(mark.contrast, 4)},
               {"quality", rounded(mark.quality, 4)}});
      if (mark.detail) {
        const bool has_arms = mark.shape == Shape::Cross;
        one[has_arms ? "width_px" : "inner_px"] = rounded(mark.detail->in_px(), 2);
      }
      if (mark.tag_id) one["id"] = *mark.tag_id;
    }
  }
  return {{"image", picture.image}, {"groups", std::move(groups)}};
}

}  // namespace panelcal
