// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "machine/job/facts/job_facts.h"
#include "machine/job/facts/sections.h"
#include <fmt/format.h>

namespace panelcal {
namespace facts {
namespace {

/// "target-7-0": the first picture of target 7.
std::string crop_name(std::int64_t seq, std::size_t i) {
  return fmt::format("target-{}-{}", seq, i);
}

/// The last picture of each view: of several inspections one is enough.
std::vector<std::size_t> last_of_views(const std::vector<SeenPicture>& pictures) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (!out.empty() && pictures[out.back()].i_view == pictures[i].i_view) out.pop_back();
    out.push_back(i);
  }
  return out;
}

/// To a hundredth of a pixel, x and y in turn: more digits show in no picture.
Json outline_json(const std::vector<Eigen::Vector2d>& outline_px) {
  Json out = Json::array();
  for (const Eigen::Vector2d& node : outline_px) {
    for (const double value : node) out.push_back(number(std::round(value * 100) / 100));
  }
  return out;
}

Json crop_json(const TargetPicture& picture, const std::string& name) {
  if (picture.jpeg.empty()) return {};
  Json outlines = Json::array();
  for (const auto& outline : picture.outlines_px) outlines.push_back(outline_json(outline));
  Json others = Json::array();
  for (const TargetPicture::Other& other : picture.others) {
    others.push_back({{"centre_px", point(other.center_px)},
                      {"size_px", number(other.size_px)},
                      {"counts", other.counts},
                      {"reason", other.reason}});
  }
  return {{"name", name},
          {"left_px", number(picture.left_px)},
          {"top_px", number(picture.top_px)},
          {"width_px", number(picture.width_px)},
          {"height_px", number(picture.height_px)},
          {"centre_px", picture.center_px ? point(*picture.center_px) : Json()},
          {"covariance_px2", picture.center_px ? covariance(picture.cov_px2) : Json()},
          {"contrast", picture.center_px ? number(picture.contrast) : Json()},
          {"blur_px", picture.center_px ? number(picture.blur_px) : Json()},
          {"outlines_px", outlines},
          {"others", others}};
}

Json pictures_json(const JobFactsInput& input, std::int64_t seq) {
  Json rows = Json::array();
  const auto seen = input.pictures.find(seq);
  if (seen == input.pictures.end()) return rows;
  for (const std::size_t i : last_of_views(seen->second)) {
    const SeenPicture& one = seen->second[i];
    Json frame = Json::array();
    for (const Eigen::Vector2d& corner_mm : one.frame_mm) frame.push_back(point(corner_mm));
    rows.push_back({{"view", one.i_view},
                    {"status", name(one.status)},
                    {"reason", one.reason},
                    {"frame_mm", frame},
                    {"seen_mm", one.seen_mm ? point(*one.seen_mm) : Json()},
                    {"crop", crop_json(one.picture, crop_name(seq, i))}});
  }
  return rows;
}

Json measured_json(const Measurement& m) {
  if (m.status != MeasurementStatus::Found) return {};
  return {{"place_mm", point(m.measured.position.in_mm())},
          {"covariance_um2", covariance(m.measured.cov * 1e6)},
          {"scatter_um", m.scatter ? point(m.scatter->in_mm() * 1e3) : Json()}};
}

Json target_json(const JobFactsInput& input, const TargetFact& fact) {
  const Measurement& m = *fact.measurement;
  const MeasurementRequest& request = m.request;
  const bool has_circle = request.settings.search_area && !request.settings.delta;
  Json out = {
      {"seq", request.seq},
      {"command", request.command},
      {"line", request.line},
      {"file", request.file},
      {"board", board_json(request.path)},
      {"series", fact.i_series ? Json(*fact.i_series) : Json()},
      {"state", name(fact.state)},
      {"status", name(m.status)},
      {"reason", m.reason},
      {"nominal_mm", point(request.nominal.in_mm())},
      {"expected_mm", point(request.expected.in_mm())},
      {"search_radius_mm", has_circle ? number(request.settings.search_area->in_mm()) : Json()},
      {"measured", measured_json(m)},
      {"residual_um", fact.residual_mm ? point(*fact.residual_mm * 1e3) : Json()},
      {"score", number(m.score)},
      {"image", m.image},
      {"pictures", pictures_json(input, request.seq)}};
  const Decision& decision = m.decision;
  if (!decision.is_by_person()) return out;
  out["decision"] = {{"by", name(decision.by)}, {"who", decision.who}, {"when", decision.when}};
  return out;
}

}  // namespace

Json targets_json(const JobFactsInput& input, std::span<const TargetFact> targets) {
  Json rows = Json::array();
  for (const TargetFact& fact : targets) rows.push_back(target_json(input, fact));
  return rows;
}

}  // namespace facts

std::map<std::string, std::string> job_pictures(const JobFactsInput& input) {
  std::map<std::string, std::string> out;
  for (const auto& [seq, pictures] : input.pictures) {
    for (const std::size_t i : facts::last_of_views(pictures)) {
      const std::string& jpeg = pictures[i].picture.jpeg;
      if (!jpeg.empty()) out[facts::crop_name(seq, i)] = jpeg;
    }
  }
  return out;
}

}  // namespace panelcal
