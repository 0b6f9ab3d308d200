// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/fit/start.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <optional>
#include <utility>

namespace panelcal::internal {
namespace {

/// A point of the plane as a complex number: a rotation with scale is then one factor.
using Point = std::complex<double>;

Point point(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}

/// The factor c of to = c from + t by least squares, from sums.
class Factor {
 public:
  void add(Point from, Point to) {
    ++n_;
    from_ += from;
    to_ += to;
    squares_ += std::norm(from);
    products_ += std::conj(from) * to;
  }
  double spread() const { return n_ == 0 ? 0 : squares_ - std::norm(from_) / n_; }
  Point moment() const { return n_ == 0 ? Point() : products_ - std::conj(from_) * to_ / n_; }
  Point mean_from() const { return from_ / n_; }
  Point mean_to() const { return to_ / n_; }
  double n() const { return n_; }

 private:
  double n_ = 0;
  Point from_;
  Point to_;
  double squares_ = 0;
  Point products_;
};

/// Picture about the axis, y up, px.
Point seen_at(const CameraObservation& seen, const Eigen::Vector2d& axis_px) {
  const Eigen::Vector2d d_px = seen.seen.position.in_px() - axis_px;
  return {d_px.x(), -d_px.y()};
}

/// scale e^(i rotation), from A z + stage = const for every dot of a pose.
std::optional<Point> by_stage(const CameraData& data, const Eigen::Vector2d& axis_px) {
  std::map<std::pair<std::size_t, std::size_t>, Factor> by_dot;
  for (const CameraObservation& seen : data.seen) {
    const PlateView& view = data.views[seen.i_view];
    by_dot[{view.i_pose, seen.i_dot}].add(seen_at(seen, axis_px), -point(view.axis_at.in_mm()));
  }
  double spread = 0;
  Point moment;
  for (const auto& [key, factor] : by_dot) {
    spread += factor.spread();
    moment += factor.moment();
  }
  if (!(spread > 0) || !(std::abs(moment) > 1e-9 * spread)) return std::nullopt;
  return moment / spread;
}

/// The scale, from certified dots that are seen in one view.
std::optional<double> by_dots(const CameraData& data, const Eigen::Vector2d& axis_px) {
  std::map<std::size_t, Factor> by_view;
  for (const CameraObservation& seen : data.seen) {
    const PlateDot& dot = data.dots[seen.i_dot];
    if (!dot.is_certified) continue;
    by_view[seen.i_view].add(point(dot.place.in_mm()), seen_at(seen, axis_px));
  }
  double in_mm = 0;
  double in_px = 0;
  for (const auto& [key, factor] : by_view) {
    if (!(factor.spread() > 0)) continue;
    in_mm += factor.spread();
    in_px += std::abs(factor.moment());
  }
  if (!(in_px > 0)) return std::nullopt;
  return in_mm / in_px;
}

/// Lays the poses one after the other, each on the dots whose places are certified or follow from
/// the poses before it.
void lay_poses(const CameraData& data, Point mm_from_px, CameraState& state) {
  std::vector<char> is_placed;
  for (const PlateDot& dot : data.dots) is_placed.push_back(dot.is_certified);
  for (std::size_t k = 0; k < state.poses.size(); ++k) {
    std::map<std::size_t, Factor> by_dot;
    Factor pose;
    for (const CameraObservation& seen : data.seen) {
      const PlateView& view = data.views[seen.i_view];
      if (view.i_pose != k) continue;
      const Point at =
          mm_from_px * seen_at(seen, state.camera.axis_px) + point(view.axis_at.in_mm());
      by_dot[seen.i_dot].add(0, at);
      if (is_placed[seen.i_dot]) pose.add(point(state.dots_mm[seen.i_dot]), at);
    }
    Point turn = 1;
    Point shift = 0;
    const double turned = std::abs(pose.moment());
    if (pose.spread() > 0 && turned > 0) turn = pose.moment() / turned;
    if (pose.n() > 0) shift = pose.mean_to() - turn * pose.mean_from();
    state.poses[k] = {std::arg(turn), {shift.real(), shift.imag()}};
    for (const auto& [i_dot, places] : by_dot) {
      if (is_placed[i_dot]) continue;
      const Point place = (places.mean_to() - shift) / turn;
      state.dots_mm[i_dot] = {place.real(), place.imag()};
      is_placed[i_dot] = true;
    }
  }
}

}  // namespace

CameraState start_of(const CameraData& data, const CameraFitOptions& options) {
  CameraState state;
  state.camera.axis_px = options.axis_px;
  state.camera.focal_px = options.focal_px;
  Point mm_from_px = std::polar(options.scale_mm_per_px, options.rotation_rad);
  if (const auto by_moves = by_stage(data, options.axis_px)) {
    mm_from_px = *by_moves;
  } else if (const auto scale = by_dots(data, options.axis_px)) {
    mm_from_px = std::polar(*scale, options.rotation_rad);
  }
  state.camera.scale_mm_per_px = std::abs(mm_from_px);
  state.camera.rotation_rad = std::arg(mm_from_px);
  std::size_t n_poses = 0;
  for (const PlateView& view : data.views) n_poses = std::max(n_poses, view.i_pose + 1);
  state.poses.resize(n_poses);
  for (const PlateDot& dot : data.dots) state.dots_mm.push_back(dot.place.in_mm());
  lay_poses(data, mm_from_px, state);
  return state;
}

}  // namespace panelcal::internal
