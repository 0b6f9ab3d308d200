// SPDX-License-Identifier: Apache-2.0
#include "program/walk/execution/depth_follower.h"

#include <cmath>
#include <utility>

#include "surface/map/way_cuts.h"
#include "surface/map/zoned_map.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Less is rounding.
constexpr Length kSameDepth = um(1e-3);

}  // namespace

void DepthFollower::refuse(Code code, int line, std::string what, std::string expected) {
  if (std::exchange(has_refused_place_, true)) return;
  reporter_.report_working(code, line, 0, std::move(what), std::move(expected));
}

std::optional<Diagnostic> DepthFollower::contradiction(int line, const std::string& said) {
  if (std::exchange(has_refused_tool_, true)) return std::nullopt;
  return Diagnostic{Code::ArgumentInvalid,
                    {{}, line, 0},
                    fmt::format("the program gives tool {} {}, and [[depth]] has it work "
                                "{:.4g} mm below the surface",
                                tool_,
                                said,
                                tool_depth_->in_mm()),
                    "one of them"};
}

void DepthFollower::refuse_at(int line, const std::string& said) {
  const auto refusal = contradiction(line, said);
  if (refusal) reporter_.report_working(refusal->code, line, 0, refusal->what, refusal->expected);
}

void DepthFollower::take(int line, const Tool& tool) {
  tool_ = tool.number;
  tool_depth_ = board_.depth_of(tool.number, tool.diameter);
  has_refused_tool_ = false;
  if (tool_depth_ && tool.depth_offset.value_or(Length()) != Length()) {
    const auto refusal =
        contradiction(line, fmt::format("a depth offset of {:.4g} mm", tool.depth_offset->in_mm()));
    if (refusal) reporter_.report(refusal->code, line, 0, refusal->what, refusal->expected);
  }
}

DepthOfCut DepthFollower::at(int line,
                             const Position<frame::Nominal>& place,
                             const DepthOfCut& asked) {
  DepthOfCut cut = asked;
  if (tool_depth_) {
    const Length depth = cut.depth.value_or(*tool_depth_);
    if (cut.z) {
      refuse_at(line, fmt::format("the working plane Z{:.4g}", cut.z->in_mm()));
      return cut;
    }
    if (std::abs((depth - *tool_depth_).in_mm()) > kSameDepth.in_mm()) {
      refuse_at(line, fmt::format("a depth of {:.4g} mm", depth.in_mm()));
      return cut;
    }
    if (pecks_ && !cut.is_controlled()) {
      refuse_at(line, "an I above the table (G81 or G89 under G82)");
      return cut;
    }
    cut.depth = depth;
    if (!cut.is_controlled()) cut.control = DepthControl::Depth;
  }
  if (!follows_map(cut)) return cut;
  take_height(line, place, cut);
  if (cut.lower_limit && cut.surface && *cut.surface - *cut.depth < *cut.lower_limit) {
    refuse(Code::ArgumentInvalid,
           line,
           fmt::format("{:.3f} mm below the surface, which is {:.4f} mm high by the map, is lower "
                       "than Z{:.4g}, which limits the stroke",
                       cut.depth->in_mm(),
                       cut.surface->in_mm(),
                       cut.lower_limit->in_mm()),
           "a lower Z");
  }
  return cut;
}

/// Without a height that may be counted on the job is refused.
void DepthFollower::take_height(int line, const Position<frame::Nominal>& place, DepthOfCut& cut) {
  const auto found = board_.map->height_at(place);
  if (!found) return refuse(found.error().code, line, found.error().what, found.error().expected);
  if (found->height.sigma > board_.max_sigma) {
    return refuse(
        Code::ToleranceHold,
        line,
        fmt::format("the sigma of the map's height at nominal ({:.4f}, {:.4f}) mm is {:.1f} um",
                    place.in_mm().x(),
                    place.in_mm().y(),
                    found->height.sigma.in_um()),
        fmt::format("at most {:.4g} um ([surface] max_sigma_um)", board_.max_sigma.in_um()));
  }
  cut.surface = found->height.height;
  cut.predicted = PredictedHeight{found->height.sigma, found->height.source};
}

/// A tool that goes evenly does not follow a step from one zone to another.
void DepthFollower::refuse_step(int line,
                                const Position<frame::Nominal>& from,
                                const Position<frame::Nominal>& to) {
  const ZonedMap& map = *board_.map;
  const auto step = map.step_between(from, to);
  if (!step || step->is_followed_within(board_.height_tolerance)) return;
  refuse(
      Code::ArgumentInvalid,
      line,
      fmt::format("the surface steps by {:+.4f} mm from zone {} to zone {}, near ({:.3f}, {:.3f})",
                  step->height.in_mm(),
                  quoted(map.zones()[step->i_from].name),
                  quoted(map.zones()[step->i_to].name),
                  to.in_mm().x(),
                  to.in_mm().y()),
      "contours that stay in one zone");
}

std::vector<double> DepthFollower::cuts(
    int line,
    const std::function<Position<frame::Nominal>(double share)>& place,
    double length_mm) {
  const ZonedMap& map = *board_.map;
  std::vector<Eigen::Vector2d> places_mm;
  const auto profile_mm = [&](std::size_t n) -> Expected<std::vector<double>> {
    places_mm.clear();
    for (std::size_t i = 0; i <= n; ++i) {
      places_mm.push_back(place(static_cast<double>(i) / static_cast<double>(n)).in_mm());
    }
    std::vector<double> heights_mm(n + 1);
    PANELCAL_CHECK(map.heights_at(places_mm, heights_mm));
    return heights_mm;
  };
  const std::size_t least = way_samples(length_mm, map.finest_cell());
  Position<frame::Nominal> before = place(0);
  for (std::size_t i = 1; i <= least && !has_refused_place_; ++i) {
    const auto here = place(static_cast<double>(i) / static_cast<double>(least));
    DepthOfCut ignored;
    if (i < least) take_height(line, here, ignored);
    refuse_step(line, before, here);
    before = here;
  }
  std::vector<double> ends;
  if (!has_refused_place_) {
    auto found = way_cuts(profile_mm, least, board_.height_tolerance);
    if (found) {
      ends = *std::move(found);
    } else {
      refuse(found.error().code, line, found.error().what, found.error().expected);
    }
  }
  ends.push_back(1);
  return ends;
}

}  // namespace panelcal
