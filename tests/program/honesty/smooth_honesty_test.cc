// SPDX-License-Identifier: Apache-2.0
// Do the ellipses of holes hold the truth where a panel is bent, over whole jobs?
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "program/walk/walk.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/calib/panel/bowed_panel.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::Bow;
using test::Coefficients;

constexpr int kJobs = 200;
constexpr int kHoles = 10;
constexpr double kSigma_mm = 0.004;

using Bending = std::function<Vector2d(const Vector2d& nominal_mm)>;

struct Panel {
  Coefficients affine;
  Bending bow;
  Vector2d offset_mm;  ///< error of the spindle-camera offset

  Vector2d operator()(const Vector2d& p_mm) const { return test::mapped(affine, p_mm) + bow(p_mm); }
};

class BentSource final : public MeasurementSource {
 public:
  BentSource(const Panel& panel, const MachineUncertainty& machine, Random& random)
      : panel_(panel), machine_(machine), random_(random) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement out{.request = request, .status = MeasurementStatus::Found};
    const Eigen::Matrix2d cov_mm2 = test::random_covariance(random_, kSigma_mm);
    out.measured = {
        position_mm<frame::Actual>(Vector2d(panel_(request.nominal.in_mm()) + panel_.offset_mm +
                                            test::draw(random_, cov_mm2) +
                                            test::draw(random_, machine_.of_target_mm2()))),
        cov_mm2};
    return out;
  }

 private:
  const Panel& panel_;
  const MachineUncertainty& machine_;
  Random& random_;
};

class CountingSink final : public OperationSink {
 public:
  CountingSink(const Panel& panel, const MachineUncertainty& machine, Random& random)
      : panel_(panel), machine_(machine), random_(random) {}

  void put(const Operation& operation) override {
    const auto* drill = std::get_if<Drill>(&operation.what);
    if (drill == nullptr) return;
    const Vector2d drilled_mm =
        drill->corrected.in_mm() - panel_.offset_mm + test::draw(random_, machine_.of_hole_mm2());
    const Vector2d error_mm = drilled_mm - panel_(drill->nominal.in_mm());
    n_inside += test::is_in_ellipse(error_mm, drill->cov_mm2) ? 1 : 0;
    sum_mm2 += error_mm.squaredNorm();
    ++n_holes;
  }

  int n_holes = 0;
  int n_inside = 0;
  double sum_mm2 = 0;

 private:
  const Panel& panel_;
  const MachineUncertainty& machine_;
  Random& random_;
};

struct Found {
  double inside = 0;  ///< share of the holes
  double rms_mm = 0;
  int n_smooth = 0;
};

struct Places {
  std::vector<Vector2d> targets_mm;
  std::vector<Vector2d> holes_mm;
};

/// Five by five targets, each up to 20 mm from its place in the grid, and holes anywhere.
Places random_places(Random& random) {
  Places places;
  for (int i = 0; i < 25; ++i) {
    const double x = 30 + 110 * (i % 5) + random.uniform(-20, 20);
    places.targets_mm.emplace_back(x, 20 + 90 * (i / 5) + random.uniform(-15, 15));
  }
  for (int i = 0; i < kHoles; ++i) {
    const double x = random.uniform(0, 500);
    places.holes_mm.emplace_back(x, random.uniform(0, 400));
  }
  return places;
}

std::string program(const Places& places) {
  std::string text = "M48\nMETRIC,TZ\nFMAT,2\nVER,1\nT1C0.8\n%\nG90\nG34,1\n";
  for (const Vector2d& p : places.targets_mm)
    text += fmt::format("G36X{:.3f}Y{:.3f}\n", p.x(), p.y());
  text += "T1\n";
  for (const Vector2d& p : places.holes_mm) text += fmt::format("X{:.3f}Y{:.3f}\n", p.x(), p.y());
  return text + "M30\n";
}

/// A smooth bow of another kind than what the model believes.
Bending random_bow(Random& random, const Places& /*places*/, double size_mm) {
  return Bow(random, size_mm);
}

/// A draw from the very process that the model believes in: with three places held, the thin
/// plate's covariance is positive definite (Duchon 1977).
class RandomPlate {
 public:
  /// size_mm: the root mean square of both coordinates over the targets
  RandomPlate(Random& random, const Places& places, double size_mm)
      : places_mm_(places.targets_mm) {
    places_mm_.insert(places_mm_.end(), places.holes_mm.begin(), places.holes_mm.end());
    const auto n = static_cast<Eigen::Index>(places_mm_.size());
    Eigen::MatrixXd phi(n, n);
    Eigen::MatrixXd affine(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
      affine.row(i) << 1, at(i).x() / 100, at(i).y() / 100;
      for (Eigen::Index j = 0; j < n; ++j) {
        const double squared = (at(i) - at(j)).squaredNorm() / 1e4;
        phi(i, j) = squared > 0 ? 0.5 * squared * std::log(squared) : 0;
      }
    }
    const std::vector<Eigen::Index> held{0, 4, 22};  // two corners and the middle of the other side
    Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(n, n);
    rest(Eigen::all, held) -= affine * Eigen::Matrix3d(affine(held, Eigen::all)).inverse();
    const Eigen::MatrixXd cov = rest * phi * rest.transpose();
    // A pivoted square root: the held places have no variance.
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(cov);
    const Eigen::MatrixXd l = ldlt.matrixL();
    const Eigen::VectorXd d = ldlt.vectorD().cwiseMax(0).cwiseSqrt();
    const double mean_variance = cov.diagonal().head(25).mean();
    shifts_mm_.resize(n, 2);
    for (const int axis : {0, 1}) {
      Eigen::VectorXd drawn(n);
      for (double& value : drawn) value = random.normal();
      shifts_mm_.col(axis) = size_mm / std::sqrt(mean_variance) *
                             (ldlt.transpositionsP().transpose() * (l * d.cwiseProduct(drawn)));
    }
  }

  Vector2d operator()(const Vector2d& nominal_mm) const {
    for (Eigen::Index i = 0; i < shifts_mm_.rows(); ++i) {
      if ((at(i) - nominal_mm).norm() < 1e-3) return shifts_mm_.row(i);
    }
    ADD_FAILURE() << "nothing was drawn at " << nominal_mm.transpose();
    return Vector2d::Zero();
  }

 private:
  const Vector2d& at(Eigen::Index i) const { return places_mm_[static_cast<std::size_t>(i)]; }

  std::vector<Vector2d> places_mm_;
  Eigen::MatrixX2d shifts_mm_;
};

Bending random_plate(Random& random, const Places& places, double size_mm) {
  return RandomPlate(random, places, size_mm);
}

using DrawBending = Bending (*)(Random&, const Places&, double size_mm);

Found run(WalkOptions options,
          DrawBending draw_bending,
          double size_mm,
          std::uint64_t seed,
          int n_jobs = kJobs) {
  MachineUncertainty machine;
  machine.stage_repeatability = um(1.5);
  machine.table_residual = um(2);
  machine.drill_wander = um(2.5);
  machine.spindle_camera_mm2 << 1.5e-6, 0.4e-6, 0.4e-6, 1e-6;
  options.uncertainty = machine;
  options.series_size = 25;
  const Random seeds(seed);
  Found found;
  int n_holes = 0;
  for (int i = 0; i < n_jobs; ++i) {
    Random random = seeds.fork(static_cast<std::uint64_t>(i));
    const Places places = random_places(random);
    const Panel panel{test::affine_truth(random),
                      draw_bending(random, places, size_mm),
                      test::draw(random, machine.spindle_camera_mm2)};
    DiagnosticLog log;
    const Program job = load_program({"bent.exc", program(places)}, log);
    BentSource source(panel, machine, random);
    const Survey survey = panelcal::survey(job, options, source, log);
    CountingSink sink(panel, machine, random);
    if (survey.is_complete() && !log.has_errors()) execute(job, options, survey, sink, log);
    EXPECT_FALSE(log.has_errors());
    n_holes += sink.n_holes;
    found.inside += sink.n_inside;
    found.rms_mm += sink.sum_mm2;
    found.n_smooth += !survey.series.empty() && survey.series[0].is_smooth() ? 1 : 0;
  }
  EXPECT_EQ(n_holes, n_jobs * kHoles);
  found.inside /= n_holes;
  found.rms_mm = std::sqrt(found.rms_mm / n_holes);
  return found;
}

WalkOptions smooth() {
  WalkOptions options;
  options.bends_panel = true;
  return options;
}

WalkOptions automatic() {
  WalkOptions options;
  options.chooses_model = true;
  return options;
}

WalkOptions affine() {
  WalkOptions options;
  options.model = PanelModel::Affine;
  return options;
}

// 2,000 holes, ten of a job together: three sigma of a share of 0.95 are some 0.02.
constexpr double kLeastInside = 0.93;
constexpr double kMostInside = 0.97;

TEST(SmoothHonesty, EllipsesHoldTheTruthOfPlatesAsOftenAsTheySay) {
  for (const double size_mm : {0.003, 0.01, 0.03, 0.1}) {
    const Found found = run(smooth(), random_plate, size_mm, 20261121, 2000);
    RecordProperty(fmt::format("inside_{}", size_mm), fmt::format("{:.4f}", found.inside));
    EXPECT_GT(found.inside, 0.94) << size_mm;
    EXPECT_LT(found.inside, 0.96) << size_mm;
  }
}

// A bow is smoother than a plate, so its ellipses are too large rather than too small: there is no
// upper limit.

TEST(SmoothHonesty, EllipsesHoldTheTruthOfBowedPanels) {
  for (const double bow_mm : {0.01, 0.05}) {
    const Found found = run(smooth(), random_bow, bow_mm, 20261122);
    RecordProperty(fmt::format("inside_{}", bow_mm), fmt::format("{:.4f}", found.inside));
    EXPECT_GT(found.inside, kLeastInside) << bow_mm;
    EXPECT_LT(found.rms_mm, 0.8 * run(affine(), random_bow, bow_mm, 20261122).rms_mm) << bow_mm;
  }
}

TEST(SmoothHonesty, LosesLittleOnAffinePanels) {
  const Found bent = run(smooth(), random_bow, 0, 20261123);
  const Found straight = run(affine(), random_bow, 0, 20261123);
  EXPECT_GT(bent.inside, kLeastInside);
  EXPECT_LT(bent.inside, kMostInside);
  EXPECT_LT(bent.rms_mm, 1.1 * straight.rms_mm);
}

TEST(SmoothHonesty, HoldsWhereTheTargetsChoose) {
  for (const double bow_mm : {0.0, 0.003, 0.05}) {
    const Found found = run(automatic(), random_bow, bow_mm, 20261124);
    EXPECT_GT(found.inside, kLeastInside) << bow_mm << " mm, smooth " << found.n_smooth;
    if (bow_mm == 0) {
      EXPECT_LT(found.n_smooth, 0.2 * kJobs);
    } else if (bow_mm == 0.05) {
      EXPECT_GT(found.n_smooth, 0.99 * kJobs);
    }
  }
}

}  // namespace
}  // namespace panelcal
