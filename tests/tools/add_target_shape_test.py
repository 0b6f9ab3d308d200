# SPDX-License-Identifier: Apache-2.0
"""A target shape is one room with three functions and one row: locate finds it, and says why not.

usage: add_target_shape_test.py SOURCE BUILD
"""

import sys

from toy import Toy, expect

SOURCE, BUILD = sys.argv[1:]

DETECTOR = r"""// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "vision/fit/pipeline.h"
#include "vision/fit/place.h"

namespace panelcal::internal {
namespace {

/// Whatever is brighter than the middle between the picture's darkest and brightest levels.
class Blobs {
 public:
  struct Sighting {
    Eigen::Vector2d sum_px = Eigen::Vector2d::Zero();
    double n = 0;
    double level = 0;
    double ground = 0;
  };
  struct Fit {
    TargetFit target;
  };

  explicit Blobs(const DetectorInput& input) : input_(input) {}

  Proposals<Sighting> propose() const {
    const auto [low, high] = std::ranges::minmax(input_.image.pixels());
    Sighting seen{.level = high, .ground = low};
    for (int y = 0; y < input_.image.height(); ++y) {
      for (int x = 0; x < input_.image.width(); ++x) {
        if (input_.image.at(x, y) < (low + high) / 2) continue;
        seen.sum_px += Eigen::Vector2d(x, y);
        ++seen.n;
      }
    }
    return {{seen}};
  }

  Fit fit(const Sighting& seen) const {
    Fit fit;
    const FitFrame frame(input_.mapping, seen.sum_px / seen.n);
    const Eigen::Matrix2d cov = Eigen::Matrix2d::Identity() / seen.n;
    set_place(frame, Eigen::Vector2d::Zero(), cov, 2 * std::sqrt(seen.n / 3.14159), fit.target);
    fit.target.contrast = seen.level - seen.ground;
    fit.target.score = 1;
    return fit;
  }

  Judgement judge(const Fit& fit) const {
    auto problem = contrast_problem(input_.sign() * fit.target.contrast, input_.min_contrast());
    return problem ? unlikely(*problem) : Judgement{};
  }

 private:
  const DetectorInput& input_;
};

}  // namespace

std::vector<FittedCandidate> detect_blobs(const DetectorInput& input) {
  return detect(input, Blobs(input));
}

}  // namespace panelcal::internal
"""

MAIN = r"""
int main(int argc, char** argv) {
  using namespace panelcal;
  const auto shape = shape_from_name(argv[1]);
  if (!shape || argc < 3) return 2;
  Image image(60, 50, 255);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 60; ++x) {
      const double inwards_px = 9.3 - std::hypot(x - 31, y - 22);
      image.at(x, y) = static_cast<float>(60 + 140 * std::clamp(inwards_px + 0.5, 0.0, 1.0));
    }
  }
  Target target;
  target.shape = *shape;
  target.size_px = px(18);
  target.polarity = *polarity_from_name(argv[2]);
  const Detection seen = locate(image, target);
  std::printf("%s %s; ", name(*shape).data(), name(seen.status).data());
  if (seen.best) {
    const auto at = seen.best->center.position.in_px();
    std::printf("%.2f %.2f; ", at.x(), at.y());
  }
  std::puts(seen.reason.c_str());
  return 0;
}
"""

toy = Toy(SOURCE, BUILD, "A target shape")
toy.insert_before("vision/fit/shapes.def", "\n#undef PANELCAL_SHAPE",
                  'PANELCAL_SHAPE(Blob, "blob", "the diameter", detect_blobs, kMaxFitted)\n')
toy.write("vision/blob/detector.cc", DETECTOR)

headers = '#include <algorithm>\n#include <cmath>\n#include <cstdio>\n'
program = toy.program("panelcal_vision", ["vision/fit/target.cc", "vision/locate/locate.cc", "vision/blob/detector.cc"],
                      headers + MAIN, "tests/vision/vision_test", replaces=True)

expect(toy.touched == {"vision/fit/shapes.def", "vision/blob/detector.cc"}, f"more was touched: {toy.touched}")
expect(toy.run(program, "blob", "bright") == (0, "blob found; 31.00 22.00; \n"), "the toy is not found where it is")
code, text = toy.run(program, "blob", "dark")
expect(code == 0 and "blob not_found; the likeliest place does not count: its contrast is -140" in text,
       f"the toy's refusal is not told: {text}")
code, text = toy.run(program, "disc", "bright")
expect(code == 0 and text.startswith("disc found; 3"), f"the shapes that were there are gone: {text}")
