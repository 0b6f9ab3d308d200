// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/rims.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "vision/locate/locate.h"
#include "vision/render/scene_debris.h"
#include <Eigen/LU>
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/bench/locate/scene.h"

namespace panelcal::bench {
namespace {

constexpr int kSide = 160;

/// A picture under way.
struct Draw {
  const Camera& camera;
  Eigen::Vector2d at_px;
  double radius_px = 40;
  double level = 0.7;
  double board = 0.3;
  std::vector<Feature>& features;
  Random& random;

  Eigen::Vector2d towards(double angle) const { return {std::cos(angle), std::sin(angle)}; }
  double turn() const { return random.uniform(0, 2 * std::numbers::pi); }
};

using Paint = std::function<void(const Draw&)>;

struct RimKind {
  std::string name;
  Paint paint;
  double grain = 0;  ///< grey levels, on target and board
  double grain_px = 1;
  Shape shape = Shape::Disc;
  double noise = 2;
  double weave = 0;
};

Feature disc(const Draw& d, const Eigen::Vector2d& at, double radius_px, double level) {
  return disc_at(d.camera, at, radius_px, level);
}

void rough_disc(const Draw& d, double rms_px, int lowest, int highest) {
  Feature f = disc(d, d.at_px, d.radius_px, d.level);
  f.roughness.rms = mm(rms_px * kScaleMm);
  f.roughness.lowest_order = lowest;
  f.roughness.highest_order = highest;
  f.roughness.seed = static_cast<std::uint64_t>(d.random.uniform(1, 1e9));
  d.features.push_back(f);
}

/// Board around a circular opening.
void mask_around(const Draw& d, const Eigen::Vector2d& at, double opening_px) {
  Feature f = disc(d, at, 4 * d.radius_px, d.board);
  f.shape = Feature::Shape::Ring;
  f.inner_size = mm(2 * opening_px * kScaleMm);
  d.features.push_back(f);
}

void debris_on(const Draw& d, double rim_share, int scratches) {
  DebrisOptions options;
  options.rim_share = rim_share;
  options.size = um(60);
  options.scratches = scratches;
  options.scratch_width = um(10);
  const Debris debris = strew_debris({d.features.back()}, options, d.random);
  d.features.insert(d.features.end(), debris.features.begin(), debris.features.end());
}

std::vector<RimKind> rim_kinds() {
  const auto plain = [](const Draw& d) {
    d.features.push_back(disc(d, d.at_px, d.radius_px, d.level));
  };
  return {
      {"clean", plain},
      {"rough 0.3 px, to 80 waves", [](const Draw& d) { rough_disc(d, 0.3, 2, 80); }},
      {"rough 0.3 px, to 24 waves", [](const Draw& d) { rough_disc(d, 0.3, 2, 24); }},
      {"rough 0.3 px, to 12 waves", [](const Draw& d) { rough_disc(d, 0.3, 2, 12); }},
      {"rough 0.1 px", [](const Draw& d) { rough_disc(d, 0.1, 2, 40); }},
      {"rough 0.03 px", [](const Draw& d) { rough_disc(d, 0.03, 2, 40); }},
      {"burr 0.5 px",
       [](const Draw& d) {
         d.features.push_back(disc(d, d.at_px, d.radius_px, d.level));
         const double from = d.turn();
         for (int i = 0; i < 5; ++i) {
           const double angle = from + 0.08 * i;
           const double out = 0.5 * std::sin(std::numbers::pi * (i + 1) / 6);
           d.features.push_back(
               disc(d, d.at_px + (d.radius_px - 6 + out) * d.towards(angle), 6, d.level));
         }
       }},
      {"mask crescent 1.8 px",
       [](const Draw& d) {
         d.features.push_back(disc(d, d.at_px, d.radius_px, d.level));
         mask_around(d, d.at_px + 3.8 * d.towards(d.turn()), d.radius_px + 2);
       }},
      {"mask crescent 0.6 px",
       [](const Draw& d) {
         d.features.push_back(disc(d, d.at_px, d.radius_px, d.level));
         mask_around(d, d.at_px + 2.6 * d.towards(d.turn()), d.radius_px + 2);
       }},
      {"over-etched side 0.66 px",
       [](const Draw& d) {
         d.features.push_back(disc(d, d.at_px, d.radius_px, d.level));
         mask_around(d, d.at_px + 0.66 * d.towards(d.turn()), d.radius_px);
       }},
      {"breakout 0.63 px",
       [](const Draw& d) {
         d.features.push_back(disc(d, d.at_px, d.radius_px, d.level));
         const double hole = 0.6 * d.radius_px;
         d.features.push_back(
             disc(d, d.at_px + (d.radius_px - hole + 0.63) * d.towards(d.turn()), hole, d.board));
       }},
      {"hole in the pad",
       [](const Draw& d) {
         d.features.push_back(disc(d, d.at_px, d.radius_px, d.level));
         d.features.push_back(disc(d, d.at_px + 3 * d.towards(d.turn()), 0.5 * d.radius_px, 0.1));
       }},
      {"two tracks",
       [](const Draw& d) {
         d.features.push_back(disc(d, d.at_px, d.radius_px, d.level));
         for (int i = 0; i < 2; ++i) {
           const double a = d.turn();
           d.features.push_back(
               rectangle_at(d.camera, d.at_px + 100 * d.towards(a), 200, 8, a, d.level));
         }
       }},
      {"debris on 10 % of the rim",
       [plain](const Draw& d) {
         plain(d);
         debris_on(d, 0.1, 0);
       }},
      {"debris 10 %, scratches",
       [plain](const Draw& d) {
         plain(d);
         debris_on(d, 0.1, 4);
       }},
      {"grain 1.5", plain, 1.5, 3},
      {"grain 6", plain, 6, 3},
      {"grain 3, 1.5 px", plain, 3, 1.5},
      {"weave 21", plain, 0, 1, Shape::Disc, 5, 21},
      {"ring, grain 3", plain, 3, 3, Shape::Ring},
      {"ring, clean", plain, 0, 1, Shape::Ring},
      {"hole, rough 0.3 px, weave",
       [](const Draw& d) { rough_disc(d, 0.3, 2, 24); },
       0,
       1,
       Shape::Hole,
       2,
       21},
  };
}

void add_grain(Image& image, double sigma, double scale_px, Random& random) {
  cv::Mat field(image.height(), image.width(), CV_32F);
  for (int y = 0; y < field.rows; ++y) {
    for (int x = 0; x < field.cols; ++x)
      field.at<float>(y, x) = static_cast<float>(random.normal());
  }
  cv::GaussianBlur(field, field, {0, 0}, scale_px);
  const double root = 2 * std::sqrt(std::numbers::pi) * scale_px;
  for (int y = 0; y < field.rows; ++y) {
    for (int x = 0; x < field.cols; ++x) {
      const double v = static_cast<double>(image.at(x, y)) +
                       root * sigma * static_cast<double>(field.at<float>(y, x));
      image.at(x, y) = static_cast<float>(std::clamp(std::round(v), 0.0, 255.0));
    }
  }
}

struct RimTally {
  int n = 0, n_found = 0, n_5 = 0, n_8 = 0, n_95 = 0;
  double nse = 0, worst = 0, squares = 0, ms = 0, sigma = 0;
  std::map<std::string, int> reasons;
};

std::string without_numbers(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool is_digit = (c >= '0' && c <= '9') || c == '.';
    if (is_digit && out.ends_with('#')) continue;
    out += is_digit ? '#' : c;
  }
  return out.substr(0, 70);
}

RimTally run_kind(const RimKind& kind, int n, std::uint64_t seed) {
  RimTally tally;
  for (int i = 0; i < n; ++i) {
    Random random = Random(seed).fork(static_cast<std::uint64_t>(i));
    const Camera camera = make_camera(kSide, kSide, random.uniform(0.8, 1.6), kind.noise);
    Mark mark = make_mark(kind.shape, random.uniform(28, 44));
    const bool is_dark = mark.polarity == Polarity::Dark;
    Scene scene;
    scene.background = is_dark ? 0.7 : 0.3;
    scene.weave.amplitude = kind.weave / 255;
    scene.weave.period = mm(50 * kScaleMm);
    const double x_mm = random.uniform(0, 300);
    scene.weave.panel_from_optical = Transform<frame::Nominal, frame::Optical>(
        Eigen::Matrix2d::Identity(), {x_mm, random.uniform(0, 300)});
    const double x = 79.5 + random.uniform(-3, 3);
    const Eigen::Vector2d at(x, 79.5 + random.uniform(-3, 3));
    const double contrast = random.uniform(90, 130) / 255;
    const double level = scene.background + (is_dark ? -contrast : contrast);
    if (kind.shape == Shape::Ring) {
      scene.features = features_of(mark, camera, at, level);
    } else {
      kind.paint({camera, at, mark.radius_px, level, scene.background, scene.features, random});
    }
    Image image = render(scene, camera, random);
    if (kind.grain > 0) add_grain(image, kind.grain, kind.grain_px, random);
    LocateOptions options;
    options.search_center = position_px<frame::Image>(Eigen::Vector2d(at + Eigen::Vector2d(2, -3)));
    options.search_radius = px(12);
    const std::clock_t start = std::clock();
    const Detection found = locate(image, target_of(mark), nullptr, options);
    tally.ms += 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    ++tally.n;
    if (found.status != DetectionStatus::Found) {
      ++tally.reasons[without_numbers(found.reason)];
      continue;
    }
    const Eigen::Vector2d e = found.best->center.position.in_px() - at;
    const double chi = e.dot(found.best->center.cov.inverse() * e);
    ++tally.n_found;
    tally.nse += chi / 2;
    tally.squares += e.squaredNorm() / 2;
    tally.sigma += 0.5 * found.best->center.cov.trace();
    tally.n_95 += chi < 5.991;
    tally.n_5 += chi > 25;
    tally.n_8 += chi > 64;
    tally.worst = std::max(tally.worst, std::sqrt(chi));
  }
  return tally;
}

}  // namespace

void print_rims(int n, std::uint64_t seed, const std::string& only) {
  fmt::print("\nrims: {} pictures each\n  {:<28}{:>7}{:>7}{:>7}{:>9}{:>9}{:>7}{:>9}{:>8}\n",
             n,
             "",
             "found%",
             "nse",
             "95%",
             "rmse px",
             "sigma",
             "worst",
             ">5,>8",
             "ms");
  for (const RimKind& kind : rim_kinds()) {
    if (kind.name.find(only) == std::string::npos) continue;
    const RimTally t = run_kind(kind, n, seed);
    const double k = std::max(1, t.n_found);
    fmt::print("  {:<28}{:>7.1f}{:>7.2f}{:>7.1f}{:>9.4f}{:>9.4f}{:>7.1f}{:>9}{:>8.2f}\n",
               kind.name,
               100.0 * t.n_found / t.n,
               t.nse / k,
               100 * t.n_95 / k,
               std::sqrt(t.squares / k),
               std::sqrt(t.sigma / k),
               t.worst,
               fmt::format("{},{}", t.n_5, t.n_8),
               t.ms / t.n);
    for (const auto& [reason, count] : t.reasons) fmt::print("      {:>4} {}\n", count, reason);
  }
}

}  // namespace panelcal::bench
