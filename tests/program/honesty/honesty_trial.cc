// SPDX-License-Identifier: Apache-2.0
#include "tests/program/honesty/honesty_trial.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "calib/camera/mapping.h"
#include "calib/correction/error_budget.h"
#include "program/walk/walk.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal::test {
namespace {

constexpr int kHoles = 12;
/// 95 % of a chi square with two degrees of freedom: -2 ln 0.05.
constexpr double kEllipse = 5.991464547107979;
constexpr double kDriftDays = 30;
const CameraMapping::Parameters kCamera{0.01, 0.003, {322, 238}, 3e-8};

double square(double x) {
  return x * x;
}

Eigen::Vector2d isotropic(Random& random, Length sigma) {
  const double x = random.normal();
  return sigma.in_mm() * Eigen::Vector2d(x, random.normal());
}

double area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// In one of the triangles of the targets, which together fill their hull.
bool is_in_hull(const std::vector<Eigen::Vector2d>& targets_mm, const Eigen::Vector2d& p) {
  for (std::size_t i = 0; i < targets_mm.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      for (std::size_t k = 0; k < j; ++k) {
        const double a = area(targets_mm[i], targets_mm[j], p);
        const double b = area(targets_mm[j], targets_mm[k], p);
        const double c = area(targets_mm[k], targets_mm[i], p);
        if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0)) return true;
      }
    }
  }
  return false;
}

/// Places at random that determine every model: apart from each other and not nearly in a line.
std::vector<Eigen::Vector2d> random_targets(Random& random,
                                            int n,
                                            const Eigen::Vector2d& corner_mm,
                                            const Eigen::Vector2d& size_mm) {
  while (true) {
    std::vector<Eigen::Vector2d> out;
    for (int i = 0; i < n; ++i) {
      const double x = std::round(random.uniform() * size_mm.x() * 1e3) / 1e3;
      out.push_back(corner_mm +
                    Eigen::Vector2d(x, std::round(random.uniform() * size_mm.y() * 1e3) / 1e3));
    }
    double largest = 0;
    for (const auto& a : out) {
      for (const auto& b : out) {
        for (const auto& c : out) largest = std::max(largest, area(a, b, c));
      }
    }
    if (largest >= 0.1 * size_mm.x() * size_mm.y()) return out;
  }
}

/// One job: where everything is, and what errs by how much in it.
struct Job {
  std::vector<Eigen::Vector2d> base_mm;
  std::vector<Eigen::Vector2d> nested_mm;
  std::vector<Eigen::Vector2d> holes_mm;
  Coefficients base;
  Coefficients nested;  ///< on top of base, of nested targets and of holes
  CameraMapping::Parameters calibrated;
  Eigen::Vector2d offset_mm;  ///< error of the spindle-camera offset, drift included

  /// True place on the table of a nominal place.
  Eigen::Vector2d actual_mm(const Eigen::Vector2d& nominal_mm, bool is_base) const {
    const Eigen::Vector2d on_panel_mm = mapped(base, nominal_mm);
    return is_base ? on_panel_mm : mapped(nested, on_panel_mm);
  }
  std::string program() const;
};

std::string Job::program() const {
  std::string text = "M48\nMETRIC,TZ\nFMAT,2\nVER,1\nT1C0.8\n%\nG90\nG34,1\n";
  const auto append = [&](std::string_view command, const Eigen::Vector2d& p_mm) {
    text += fmt::format("{}X{:.3f}Y{:.3f}\n", command, p_mm.x(), p_mm.y());
  };
  text += fmt::format("$uvis,alg,0,{}\n", base_mm.size());
  for (const Eigen::Vector2d& p_mm : base_mm) append("G36", p_mm);
  if (!nested_mm.empty()) text += fmt::format("$uvis,alg,0,{}\n", nested_mm.size());
  for (const Eigen::Vector2d& p_mm : nested_mm) append("G46", p_mm);
  text += "T1\n";
  for (const Eigen::Vector2d& p_mm : holes_mm) append("", p_mm);
  return text + "M30\n";
}

/// A board turns and stretches a little on top of its panel, as its model lets it.
Coefficients random_board(Random& random, PanelModel model, const Eigen::Vector2d& about_mm) {
  Coefficients a = internal::coefficients(model, random_parameters(random, model));
  Eigen::Matrix2d linear;
  linear << a[0], a[1], a[2], a[3];
  const Eigen::Vector2d shift_mm(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2));
  a.tail<2>() = about_mm + shift_mm - linear * about_mm;
  return a;
}

Job random_job(Random& random, const HonestyTrial& trial, const MachineUncertainty& machine) {
  Job job;
  const auto count = [&](int low, int high) {
    return low + static_cast<int>(random.uniform() * (high - low + 1));
  };
  const Eigen::Vector2d panel_mm(300, 250);
  job.base_mm = random_targets(random, count(3, 6), Eigen::Vector2d::Zero(), panel_mm);
  job.base = internal::coefficients(trial.model, random_parameters(random, trial.model));
  Eigen::Vector2d corner_mm(-60, -60);
  Eigen::Vector2d size_mm = panel_mm + Eigen::Vector2d(120, 120);
  job.nested << 1, 0, 0, 1, 0, 0;
  if (trial.has_nested) {
    const Eigen::Vector2d board_mm(std::round(random.uniform(0, 240)),
                                   std::round(random.uniform(0, 200)));
    job.nested_mm = random_targets(random, count(3, 5), board_mm, {60, 50});
    job.nested = random_board(random, trial.model, mapped(job.base, board_mm));
    corner_mm = board_mm - Eigen::Vector2d(20, 20);
    size_mm = Eigen::Vector2d(100, 90);
  }
  for (int i = 0; i < kHoles; ++i) {
    const double x = std::round(random.uniform() * size_mm.x() * 1e3) / 1e3;
    job.holes_mm.push_back(
        corner_mm + Eigen::Vector2d(x, std::round(random.uniform() * size_mm.y() * 1e3) / 1e3));
  }

  Eigen::Vector<double, 5> z;
  for (double& one : z) one = random.normal();
  const Eigen::Matrix<double, 5, 5> root = machine.camera.llt().matrixL();
  const Eigen::Vector<double, 5> error = root * z;
  job.calibrated = kCamera;
  job.calibrated.scale_mm_per_px += error[0];
  job.calibrated.rotation_rad += error[1];
  job.calibrated.axis_px += error.segment<2>(2);
  job.calibrated.k1_per_px2 += error[4];
  job.offset_mm = draw(random, machine.shared_mm2());
  return job;
}

/// Sees targets where they are, with all errors of one job.
class ErringSource final : public MeasurementSource {
 public:
  ErringSource(const Job& job,
               const HonestyTrial& trial,
               const MachineUncertainty& machine,
               Random& random)
      : job_(job), trial_(trial), machine_(machine), random_(random) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    const bool is_base = request.command == "G36";
    const Eigen::Vector2d actual_mm = job_.actual_mm(request.nominal.in_mm(), is_base);
    const Eigen::Matrix2d cov_mm2 = random_covariance(random_, trial_.detector_um * 1e-3);
    const CameraMapping truth(kCamera);
    const CameraMapping calibrated(job_.calibrated);
    // Panels are put down within half a millimetre: so far from its middle a picture shows them.
    const auto pixel = position_px(random_.uniform(270, 370), random_.uniform(190, 290));
    const Eigen::Vector2d camera_mm = calibrated(pixel).in_mm() - truth(pixel).in_mm();
    Measurement measurement{.request = request, .status = MeasurementStatus::Found};
    const Eigen::Vector2d seen_mm = actual_mm + camera_mm + job_.offset_mm +
                                    draw(random_, cov_mm2) +
                                    isotropic(random_, machine_.stage_repeatability) +
                                    isotropic(random_, machine_.table_residual);
    measurement.measured = {position_mm<frame::Actual>(seen_mm), cov_mm2};
    measurement.by_camera = calibrated.by_parameters(pixel);
    return measurement;
  }

 private:
  const Job& job_;
  const HonestyTrial& trial_;
  const MachineUncertainty& machine_;
  Random& random_;
};

/// Share with the scatter of jobs, a ratio of sums over jobs (Cochran 1977, 6.3).
class CoverageSum {
 public:
  void add(double n_inside, double n_holes) {
    inside_ += n_inside;
    holes_ += n_holes;
    inside2_ += square(n_inside);
    both_ += n_inside * n_holes;
    holes2_ += square(n_holes);
  }
  Coverage result() const {
    Coverage out;
    out.n_holes = static_cast<std::int64_t>(holes_);
    if (holes_ == 0) return out;
    out.share = inside_ / holes_;
    const double sum = inside2_ - 2 * out.share * both_ + square(out.share) * holes2_;
    out.sigma = std::sqrt(std::max(0.0, sum)) / holes_;
    return out;
  }

 private:
  double inside_ = 0;
  double holes_ = 0;
  double inside2_ = 0;
  double both_ = 0;
  double holes2_ = 0;
};

/// Drills with the errors of the machine and looks whether the panel's place is in the ellipse.
class DrillingSink final : public OperationSink {
 public:
  DrillingSink(const Job& job, const MachineUncertainty& machine, Random& random)
      : job_(job), machine_(machine), random_(random) {}

  void put(const Operation& operation) override {
    const auto* drill = std::get_if<Drill>(&operation.what);
    if (drill == nullptr) return;
    const Eigen::Vector2d error_mm =
        drill->corrected.in_mm() + isotropic(random_, machine_.stage_repeatability) +
        isotropic(random_, machine_.table_residual) + isotropic(random_, machine_.drill_wander) -
        job_.actual_mm(drill->nominal.in_mm(), false);
    const bool is_inside = error_mm.dot(drill->cov_mm2.inverse() * error_mm) <= kEllipse;
    const auto& targets_mm = job_.nested_mm.empty() ? job_.base_mm : job_.nested_mm;
    const bool is_outside = !is_in_hull(targets_mm, drill->nominal.in_mm());
    n_holes += 1;
    n_inside += is_inside;
    n_outside += is_outside;
    n_inside_outside += is_inside && is_outside;
    sum_sigma_um += largest_sigma(drill->cov_mm2).in_um();
  }

  double n_holes = 0;
  double n_inside = 0;
  double n_outside = 0;  ///< the hull
  double n_inside_outside = 0;
  double sum_sigma_um = 0;

 private:
  const Job& job_;
  const MachineUncertainty& machine_;
  Random& random_;
};

}  // namespace

MachineUncertainty trial_machine() {
  MachineUncertainty machine;
  machine.stage_repeatability = um(1.5);
  machine.table_residual = um(2);
  machine.drill_wander = um(2.5);
  machine.spindle_camera_mm2 << 1.5e-6, 0.4e-6, 0.4e-6, 1e-6;
  machine.drift_mm2 = square(0.3e-3) * kDriftDays * Eigen::Matrix2d::Identity();
  // Scale to 20 ppm, rotation to 20 urad, axis to 0.12 and 0.08 px, k1 to 3 %.
  machine.camera.diagonal() << square(2e-7), square(2e-5), square(0.12), square(0.08), square(1e-9);
  machine.camera(2, 3) = machine.camera(3, 2) = 0.3 * 0.12 * 0.08;
  return machine;
}

HonestyResult run(const HonestyTrial& trial) {
  const MachineUncertainty machine = trial_machine();
  WalkOptions options;
  options.model = trial.model;
  if (!trial.hides_machine) options.uncertainty = machine;
  const Random seeds(trial.seed);
  HonestyResult result;
  CoverageSum all, outside;
  double n_holes = 0;
  for (int i = 0; i < trial.n_jobs; ++i) {
    Random random = seeds.fork(static_cast<std::uint64_t>(i));
    const Job job = random_job(random, trial, machine);
    DiagnosticLog log;
    const Program program = load_program({"honest.exc", job.program()}, log);
    ErringSource source(job, trial, machine, random);
    const Survey survey = panelcal::survey(program, options, source, log);
    DrillingSink sink(job, machine, random);
    if (survey.is_complete() && !log.has_errors()) execute(program, options, survey, sink, log);
    if (log.has_errors() || sink.n_holes != kHoles) {
      ++result.n_failed;
      continue;
    }
    all.add(sink.n_inside, sink.n_holes);
    outside.add(sink.n_inside_outside, sink.n_outside);
    result.mean_sigma_um += sink.sum_sigma_um;
    n_holes += sink.n_holes;
    for (const SeriesResult& series : survey.series) {
      result.chi_square += series.base ? series.base->chi_square : series.nested->chi_square;
      result.degrees_of_freedom +=
          series.base ? series.base->degrees_of_freedom : series.nested->degrees_of_freedom;
    }
  }
  result.all = all.result();
  result.outside = outside.result();
  if (n_holes > 0) result.mean_sigma_um /= n_holes;
  return result;
}

}  // namespace panelcal::test
