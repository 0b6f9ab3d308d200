// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/false.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/locate/dump.h"
#include "tests/bench/locate/impostors.h"
#include "tests/bench/locate/methods.h"

namespace panelcal::bench {
namespace {

/// Peers take most of the time, and their rates are far above what a tenth of the pictures shows.
constexpr int kPeersEvery = 10;

/// Pictures between clean and hard.
Condition draw_condition(Random& random) {
  Condition c;
  c.contrast = random.uniform(40, 140);
  c.noise = random.uniform(2, 0.3 * c.contrast > 12 ? 12 : 0.3 * c.contrast);
  c.blur_px = random.uniform(1, 2.5);
  c.weave = random.uniform(0, 0.3) * c.contrast;
  c.light_gradient = 0.2;
  c.name = fmt::format("{:.3f}", c.contrast);  // of its own: nothing prepared may be kept
  return c;
}

struct Count {
  int n = 0;
  std::vector<int> n_found;  ///< by method
};

struct Picture {
  Condition condition;
  Mark mark;
  Eigen::Vector2d center_px;
  Image image;
};

/// By 27 to 45 degrees: diameters that differ by 11 to 29 %. The tolerance of 4 % either way
/// allows 8 %.
void lean(Random& random, Camera& camera) {
  camera.tilt = deg(random.uniform(27, 45));
  camera.tilt_axis = deg(random.uniform(0, 180));
}

Picture draw_picture(const Mark& mark, const Impostor& impostor, Random& random) {
  Picture p{draw_condition(random),
            make_mark(mark.shape, mark.radius_px * random.uniform(0.4, 1.5)),
            {},
            {}};
  Camera camera = make_camera(640, 480, p.condition.blur_px, p.condition.noise);
  if (impostor.is_tilted) lean(random, camera);
  Scene scene = draw_background(p.condition, mark.polarity, random);
  const double x = random.uniform(200, 440);
  p.center_px = {x, random.uniform(160, 320)};
  const Stage stage{
      camera, p.mark, p.center_px, mark_level(p.condition, mark.polarity), scene.background};
  scene.features = impostor.draw(stage, random);
  p.image = render(scene, camera, random);
  return p;
}

void print_counts(const std::vector<Impostor>& impostors,
                  const std::vector<Count>& counts,
                  const std::vector<Count>& peer_counts,
                  const std::vector<Method>& methods) {
  for (std::size_t k = 0; k < methods.size(); ++k) {
    const auto& of = k == 0 ? counts : peer_counts;
    int n = 0;
    int n_found = 0;
    std::string kinds;
    for (std::size_t i = 0; i < impostors.size(); ++i) {
      n += of[i].n;
      n_found += of[i].n_found[k];
      if (of[i].n_found[k] > 0) {
        kinds += fmt::format(
            "{}{} {}/{}", kinds.empty() ? "" : ", ", impostors[i].name, of[i].n_found[k], of[i].n);
      }
    }
    if (n == 0) continue;
    fmt::print("  {:<29}{:>7} of {:>6} = {:>6.2f} %  {}\n",
               methods[k].name,
               n_found,
               n,
               100.0 * n_found / n,
               kinds);
  }
}

}  // namespace

void print_false_rate(const Mark& mark, const FalseOptions& options) {
  const std::vector<Impostor> impostors = impostors_of(mark.shape);
  std::vector<Method> methods = methods_for(mark.shape);
  if (!options.with_peers) methods.resize(1);
  const Count none{0, std::vector<int>(methods.size(), 0)};
  std::vector<Count> counts(impostors.size(), none);
  std::vector<Count> peer_counts(impostors.size(), none);
  for (int i = 0; i < options.n; ++i) {
    Random random = Random(options.seed + 1).fork(static_cast<std::uint64_t>(i));
    const std::size_t kind = static_cast<std::size_t>(i) % impostors.size();
    const Picture p = draw_picture(mark, impostors[kind], random);
    const Question question{p.image, p.mark, p.condition, p.center_px};
    ++counts[kind].n;
    if (methods[0].find(question).is_found) {
      ++counts[kind].n_found[0];
      dump_picture(options.dump, p.image, "false " + impostors[kind].name, i);
    }
    if (i / static_cast<int>(impostors.size()) % kPeersEvery != 0) continue;
    ++peer_counts[kind].n;
    for (std::size_t k = 1; k < methods.size(); ++k) {
      peer_counts[kind].n_found[k] += methods[k].find(question).is_found;
    }
  }
  fmt::print(
      "\nfalse rate: {} pictures without the mark, {} kinds, contrast 40 to 140, noise 2 to "
      "12, blur 1 to 2.5, weave 0 to 0.3 of the contrast, radius {} to {} px; `found`:\n",
      options.n,
      impostors.size(),
      0.4 * mark.radius_px,
      1.5 * mark.radius_px);
  print_counts(impostors, counts, peer_counts, methods);
}

}  // namespace panelcal::bench
