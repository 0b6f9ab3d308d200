// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/accuracy.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/LU>
#include <fmt/format.h>

#include "tests/bench/locate/bound.h"
#include "tests/bench/locate/dump.h"
#include "tests/bench/locate/methods.h"
#include "tests/bench/locate/texture.h"

namespace panelcal::bench {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
/// Errors above are gross, and answers further off than the second are about something else: they
/// are counted, but not in the rmse, which would say nothing any more.
constexpr double kGrossPx = 0.5;
constexpr double kElsewherePx = 3;
constexpr int kTexturePictures = 150;

/// A reason with its numbers as #, so that equal ones can be counted.
std::string kind_of(const std::string& reason) {
  std::string kind;
  for (const char c : reason) {
    const bool is_number = (c >= '0' && c <= '9') || (c == '.' && kind.ends_with('#'));
    if (!is_number) kind += c;
    if (is_number && !kind.ends_with('#')) kind += '#';
  }
  return kind;
}

/// Pictures that failed in one way.
struct Failures {
  int n = 0;
  std::string pictures;  ///< the first ones

  void add(int i_sample) {
    constexpr int kMostNamed = 8;
    if (n++ < kMostNamed) pictures += fmt::format(" {}", i_sample);
  }
};

/// One method's errors.
struct Tally {
  std::string name;
  int n = 0;
  int n_found = 0;
  int n_gross = 0;
  int n_elsewhere = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  double nees = 0;
  bool has_cov = false;
  std::vector<double> ms;
  std::map<std::string, Failures> failures;  ///< by kind

  int n_near() const { return n_found - n_elsewhere; }

  void add(const Answer& answer, const Eigen::Vector2d& truth_px, int i_sample) {
    ++n;
    ms.push_back(answer.ms);
    if (!answer.is_found) {
      failures[kind_of(answer.reason)].add(i_sample);
      return;
    }
    ++n_found;
    const Eigen::Vector2d e = answer.center_px - truth_px;
    if (!(e.norm() <= kGrossPx)) {
      ++n_gross;
      failures[fmt::format("off by more than {} px", kGrossPx)].add(i_sample);
    }
    if (!(e.norm() <= kElsewherePx)) {
      ++n_elsewhere;
      return;
    }
    sum += e;
    squares += e.cwiseAbs2();
    if (answer.cov) {
      has_cov = true;
      nees += 0.5 * e.dot(answer.cov->inverse() * e);
    }
  }

  double median_ms() {
    if (ms.empty()) return 0;
    const auto middle = ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2);
    std::nth_element(ms.begin(), middle, ms.end());
    return *middle;
  }
};

void print_tally(Tally& t, double bound_px) {
  if (t.n_near() == 0) {
    fmt::print("  {:<29}{:>57.1f}{:>9}{:>9.3f}\n",
               t.name,
               100.0 * t.n_found / t.n,
               fmt::format("{}/{}", t.n_gross, t.n_elsewhere),
               t.median_ms());
    return;
  }
  const Eigen::Vector2d mean = t.sum / t.n_near();
  const Eigen::Vector2d rmse = (t.squares / t.n_near()).cwiseSqrt();
  const double both = std::sqrt(0.5 * rmse.squaredNorm());
  fmt::print("  {:<29}{:>8.2f}{:>8.2f}{:>9.5f}{:>9.5f}{:>9.5f}{:>7}{:>7.1f}{:>9}{:>9.3f}\n",
             t.name,
             rmse.x() / bound_px,
             rmse.y() / bound_px,
             both,
             mean.x(),
             mean.y(),
             t.has_cov ? fmt::format("{:.2f}", t.nees / t.n_near()) : "-",
             100.0 * t.n_found / t.n,
             fmt::format("{}/{}", t.n_gross, t.n_elsewhere),
             t.median_ms());
}

double coordinate(const Eigen::Matrix2d& cov) {
  return std::sqrt(0.5 * cov.trace());
}

/// The bounds of a condition for one coordinate, px; prints them. Gives the one that counts.
double print_bounds(const Condition& c,
                    const Mark& mark,
                    const std::vector<double>& visible_bounds) {
  const LinearModel model = linearise(c, mark);
  const double white_px = coordinate(white_bound(model, c.noise));
  fmt::print("  bounds, px: white {:.5f}, everything unknown, window {} x {}",
             white_px,
             model.side_px,
             model.side_px);
  if (mark.shape == Shape::Disc || mark.shape == Shape::Hole) {
    fmt::print("; closed form {:.5f}", closed_form_bound(c, mark.radius_px));
  }
  double counts_px = white_px;
  if (c.weave > 0) {
    const Texture texture(c, model.side_px - 1, kTexturePictures, 77);
    const double coloured_px = coordinate(coloured_bound(model, c.noise, texture));
    fmt::print("; with texture (sigma {:.2f}) as coloured noise {:.5f} = {:.3f} white",
               texture.sigma(),
               coloured_px,
               coloured_px / white_px);
    counts_px = coloured_px;
  }
  if (!visible_bounds.empty()) {
    double squares = 0;
    for (const double b : visible_bounds) squares += b * b;
    counts_px = std::sqrt(squares / static_cast<double>(visible_bounds.size()));
    fmt::print("; of what is visible, white {:.5f} (rms of all pictures)", counts_px);
  }
  fmt::print("\n  the bound below is {:.5f}\n", counts_px);
  return counts_px;
}

/// The error of the linear estimate at the truth that is told which pixels are debris, white model:
/// what a plain least-squares fit with a perfect model and mask would do.
Eigen::Vector2d told_error(const Sample& sample,
                           const LinearModel& model,
                           const Eigen::VectorXd& visible) {
  const int half = model.side_px / 2;
  const int x0 = static_cast<int>(std::lround(sample.center_px.x())) - half;
  const int y0 = static_cast<int>(std::lround(sample.center_px.y())) - half;
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(model.value.size());
  for (int y = 0; y < model.side_px; ++y) {
    for (int x = 0; x < model.side_px; ++x) {
      const int u = x0 + x;
      const int v = y0 + y;
      if (u < 0 || v < 0 || u >= sample.image.width() || v >= sample.image.height()) continue;
      const auto i = static_cast<Eigen::Index>(model.index(x, y));
      residual[i] = static_cast<double>(sample.image.at(u, v)) - model.value[i];
    }
  }
  const Eigen::MatrixXd weighted = visible.asDiagonal() * model.jacobian;
  const Eigen::MatrixXd normal = model.jacobian.transpose() * weighted;
  const Eigen::VectorXd step = normal.fullPivLu().solve(weighted.transpose() * residual);
  return step.head<2>();
}

}  // namespace

void print_accuracy(const Condition& condition, const Mark& mark, const AccuracyOptions& options) {
  std::vector<Method> methods = methods_for(mark.shape);
  if (!options.with_peers) methods.resize(1);
  std::vector<Tally> tallies(methods.size());
  for (std::size_t i = 0; i < methods.size(); ++i) tallies[i].name = methods[i].name;
  Tally told;
  told.name = "(plain fit told mask and start)";
  std::vector<double> visible_bounds;
  const LinearModel centred = linearise(condition, mark);
  for (int i = 0; i < options.n; ++i) {
    Random random = Random(options.seed).fork(static_cast<std::uint64_t>(i));
    const Sample sample = draw_sample(condition, mark, kWidth, kHeight, random);
    const Eigen::Vector2d window_px =
        sample.center_px + Eigen::Vector2d(random.uniform(-2, 2), random.uniform(-2, 2));
    const Question question{sample.image, mark, condition, window_px};
    Eigen::VectorXd visible = Eigen::VectorXd::Ones(centred.value.size());
    if (condition.debris > 0 || condition.n_neighbours > 0) {
      visible = visible_pixels(sample);
      visible_bounds.push_back(coordinate(white_bound(centred, condition.noise, visible)));
    }
    constexpr int kMostTold = 300;
    if (options.with_peers && i < kMostTold) {
      const Eigen::Vector2d offset_px =
          sample.center_px - sample.center_px.array().round().matrix();
      Answer answer;
      answer.is_found = true;
      answer.center_px = sample.center_px +
                         told_error(sample, linearise(condition, sample.mark, offset_px), visible);
      told.add(answer, sample.center_px, i);
    }
    for (std::size_t k = 0; k < methods.size(); ++k) {
      const Answer answer = methods[k].find(question);
      tallies[k].add(answer, sample.center_px, i);
      const bool is_bad =
          !answer.is_found || !((answer.center_px - sample.center_px).norm() <= kGrossPx);
      if (k == 0 && is_bad) dump_picture(options.dump, sample.image, condition.name, i);
    }
  }
  fmt::print(
      "\n{}: contrast {}, noise {}, blur {} (lens), weave {}, gradient {}, debris {}, "
      "neighbours {}; {} pictures\n",
      condition.name,
      condition.contrast,
      condition.noise,
      condition.blur_px,
      condition.weave,
      condition.light_gradient,
      condition.debris,
      condition.n_neighbours,
      options.n);
  const double bound_px = print_bounds(condition, mark, visible_bounds);
  fmt::print("  {:<29}{:>8}{:>8}{:>9}{:>9}{:>9}{:>7}{:>7}{:>9}{:>9}\n",
             "",
             "x/bound",
             "y/bound",
             "rmse px",
             "bias x",
             "bias y",
             "NEES",
             "found%",
             "gross/far",
             "ms");
  for (Tally& tally : tallies) print_tally(tally, bound_px);
  if (told.n > 0) print_tally(told, bound_px);
  for (const auto& [kind, failures] : tallies[0].failures) {
    fmt::print(
        "  panelcal's failures: {:>3}  {}; pictures{}\n", failures.n, kind, failures.pictures);
  }
}

}  // namespace panelcal::bench
