// SPDX-License-Identifier: Apache-2.0
#include "tests/vision/tag/accuracy.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "vision/locate/locate.h"
#include <Eigen/LU>
#include <fmt/format.h>

#include "tests/vision/tag/dirt.h"
#include "tests/vision/tag/peers.h"

namespace panelcal::test {
namespace {

/// Of this process, which has one thread: other programs' load does not count.
double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void add(const TagScene& scene, const PeerTag& tag, TagErrors& errors) {
  ++errors.n_found;
  errors.center.add(tag.center_px - scene.center_px());
  for (std::size_t i = 0; i < 4; ++i) {
    errors.corners.add(tag.corners_px[i] - scene.corners_px()[i]);
  }
}

void run_peers(const TagScene& scene, const Image& image, const TagTrials& t, TagAccuracy& out) {
  const double start = cpu_ms();
  const auto library = library_tag(image, t.family, t.id);
  out.library.ms += cpu_ms() - start;
  if (!library) return;
  add(scene, *library, out.library);
  const double refine_start = cpu_ms();
  const PeerTag refined = refined_by_opencv(image, *library);
  out.opencv.ms += cpu_ms() - refine_start;
  add(scene, refined, out.opencv);
}

/// e^T cov^-1 e / 2
double chi_square(const PositionEstimate<frame::Image>& seen, const Eigen::Vector2d& truth_px) {
  const Eigen::Vector2d e = seen.position.in_px() - truth_px;
  return e.dot(seen.cov.inverse() * e) / 2;
}

void run_ours(const TagScene& scene,
              const Image& image,
              const Target& target,
              const std::string& where,
              TagAccuracy& out) {
  const double start = cpu_ms();
  const Detection detection = locate(image, target);
  out.ours.ms += cpu_ms() - start;
  if (detection.status != DetectionStatus::Found) {
    if (out.first_failure.empty()) {
      out.first_failure =
          fmt::format("{}: {}, {}", where, name(detection.status), detection.reason);
    }
    return;
  }
  const TargetFit& fit = *detection.best;
  PeerTag ours{fit.center.position.in_px(), {}};
  out.center_chi_square += chi_square(fit.center, scene.center_px());
  for (std::size_t i = 0; i < 4; ++i) {
    ours.corners_px[i] = fit.corners[i].position.in_px();
    out.corner_chi_square += chi_square(fit.corners[i], scene.corners_px()[i]) / 4;
  }
  add(scene, ours, out.ours);
}

Image trial_picture(const TagScene& scene, const TagTrials& trials, int i, Random& random) {
  std::vector<double> levels = tag_levels(scene);
  paint(scene, draw_tag_neighbours(scene, trials.n_neighbours, random), levels);
  const DirtPlace place = i % 2 == 0 ? DirtPlace::Area : DirtPlace::Rim;
  paint(scene, draw_dirt(scene, place, trials.dirt, trials.n_scratches, random), levels);
  return noisy_picture(scene, levels, random);
}

TagScene scene_with(double contrast, double noise, double blur_px, double gradient) {
  TagScene scene;
  scene.white = scene.black + contrast;
  scene.around = scene.black + contrast / 2;
  scene.noise = noise;
  scene.blur_px = blur_px;
  scene.light_gradient = {gradient, -gradient};
  return scene;
}

}  // namespace

void Rmse::add(const Eigen::Vector2d& error) {
  sum += error.squaredNorm() / 2;
  ++n;
}

double Rmse::value() const {
  return std::sqrt(sum / std::max(1, n));
}

TagAccuracy run_tag_trials(TagScene scene, const TagTrials& trials) {
  TagAccuracy out;
  Target target;
  target.shape = Shape::AprilTag;
  target.size_px = px(trials.side_px);
  target.size_tolerance = 0.2;  // tilt makes sides shorter
  target.tag_family = trials.family;
  target.tag_id = trials.id;
  scene.pattern = *tag_pattern(trials.family, trials.id);
  for (int i = 0; i < trials.n; ++i) {
    Random random = Random(trials.seed).fork(static_cast<std::uint64_t>(i));
    scene.image_from_tag = random_pose(scene, trials.side_px, trials.tilt_rad, random);
    const Image image = trial_picture(scene, trials, i, random);
    if (i % trials.bound_each == 0) {
      const TagBound bound = tag_bound(scene);
      out.center_bound.add(Eigen::Vector2d::Constant(bound.center_px));
      out.corner_bound.add(Eigen::Vector2d::Constant(bound.corner_px));
    }
    run_peers(scene, image, trials, out);
    run_ours(scene, image, target, fmt::format("seed {} picture {}", trials.seed, i), out);
  }
  out.center_chi_square /= std::max(1, out.ours.n_found);
  out.corner_chi_square /= std::max(1, out.ours.n_found);
  for (TagErrors* e : {&out.ours, &out.library, &out.opencv}) e->ms /= std::max(1, trials.n);
  return out;
}

TagScene clean_tag_scene() {
  return scene_with(140, 2, 1, 0);
}

TagScene typical_tag_scene() {
  return scene_with(100, 5, 1.5, 0.3);
}

TagScene dim_tag_scene() {
  return scene_with(40, 12, 2.5, 0.3);
}

TagTrials hard_tag_trials() {
  return {.dirt = 0.1, .n_scratches = 2, .n_neighbours = 3};
}

}  // namespace panelcal::test
