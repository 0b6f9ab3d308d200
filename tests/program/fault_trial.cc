// SPDX-License-Identifier: Apache-2.0
#include "tests/program/fault_trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "calib/base/statistics/random.h"
#include "program/judge/job_verdict.h"
#include "program/walk/walk.h"
#include <Eigen/LU>
#include <fmt/format.h>

#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal::test {
namespace {

using Place = Eigen::Vector2d;

constexpr int kTrialHoles = 20;
constexpr double kPanelX_mm = 300;
constexpr double kPanelY_mm = 250;
/// 95 % of a chi square with two degrees of freedom: -2 ln 0.05.
constexpr double kTrialEllipse = 5.991464547107979;

MachineUncertainty stated_machine() {
  MachineUncertainty machine;
  machine.stage_repeatability = um(0.5);
  machine.table_residual = um(0.5);
  machine.drill_wander = um(1);
  machine.spindle_camera_mm2 = 0.25e-6 * Eigen::Matrix2d::Identity();
  return machine;
}

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

int whole(Random& random, int low, int high) {
  return std::min(high, low + static_cast<int>(random.uniform() * (high - low + 1)));
}

bool is_heads(Random& random) {
  return random.uniform() < 0.5;
}

Place direction(Random& random) {
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  return {std::cos(angle), std::sin(angle)};
}

struct Affine {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Place shift_mm = Place::Zero();

  Place operator()(const Place& p_mm) const { return linear * p_mm + shift_mm; }
};

Affine about(const Eigen::Matrix2d& linear, const Place& center_mm) {
  return {linear, center_mm - linear * center_mm};
}

Affine after(const Affine& outer, const Affine& inner) {
  return {outer.linear * inner.linear, outer(inner.shift_mm)};
}

Affine random_lie(Random& random, PanelModel model) {
  const Coefficients a = internal::coefficients(model, random_parameters(random, model));
  Affine out;
  out.linear << a[0], a[1], a[2], a[3];
  out.shift_mm = a.tail<2>();
  return out;
}

/// The targets of one fit, and what the camera sees of them.
struct TrialSeries {
  std::vector<Place> nominal_mm;
  std::vector<Place> shift_mm;            ///< by which the camera is wrong
  std::vector<std::size_t> seen_instead;  ///< the target whose place is seen
  double detector_mm = 0;                 ///< as stated
  double noise_factor = 1;                ///< true noise over it
};

struct TrialJob {
  TrialSeries base;
  TrialSeries nested;
  std::vector<Place> holes_mm;
  Affine panel;  ///< of everything
  Affine board;  ///< on top, of nested targets and holes
  Place offset_mm = Place::Zero();
  double warp_mm = 0;
  Length tolerance;

  bool has_nested() const { return !nested.nominal_mm.empty(); }
  Place on_panel_mm(const Place& nominal_mm) const {
    const double u = nominal_mm.x() / kPanelX_mm - 0.5;
    const double v = nominal_mm.y() / kPanelY_mm - 0.5;
    return panel(nominal_mm + warp_mm * Place(4 * u * v + 2 * v * v, 4 * u * u - 3 * u * v));
  }
  Place hole_mm(const Place& nominal_mm) const {
    return has_nested() ? board(on_panel_mm(nominal_mm)) : on_panel_mm(nominal_mm);
  }
  std::string program() const;
};

std::string TrialJob::program() const {
  std::string text = "M48\nMETRIC,TZ\nFMAT,2\nVER,1\nT1C0.8\n%\nG90\nG34,1\n";
  const auto append = [&](std::string_view command, const std::vector<Place>& places_mm) {
    for (const Place& p_mm : places_mm) {
      text += fmt::format("{}X{:.3f}Y{:.3f}\n", command, p_mm.x(), p_mm.y());
    }
  };
  text += fmt::format("$uvis,alg,0,{}\n", base.nominal_mm.size());
  append("G36", base.nominal_mm);
  if (has_nested()) text += fmt::format("$uvis,alg,0,{}\n", nested.nominal_mm.size());
  append("G46", nested.nominal_mm);
  text += "T1\n";
  append("", holes_mm);
  return text + "M30\n";
}

Place random_place(Random& random, const Place& corner_mm, const Place& size_mm) {
  const double x = std::round(random.uniform() * size_mm.x() * 1e3) / 1e3;
  return corner_mm + Place(x, std::round(random.uniform() * size_mm.y() * 1e3) / 1e3);
}

/// Spread over the rectangle as fiducials are: no two near each other, not nearly in a line.
TrialSeries random_series(Random& random, int n, const Place& corner_mm, const Place& size_mm) {
  TrialSeries out;
  const double apart_mm = size_mm.norm() / (2 * std::sqrt(n));
  while (out.nominal_mm.size() < static_cast<std::size_t>(n)) {
    const std::size_t i = out.nominal_mm.size();
    Place place_mm = random_place(random, corner_mm, size_mm);
    if (i < 4) {  // one in each corner region
      const Place corner(i % 2 == 0 ? 0 : 0.75 * size_mm.x(), i < 2 ? 0 : 0.75 * size_mm.y());
      place_mm = random_place(random, corner_mm + corner, size_mm / 4);
    }
    const bool is_near = std::ranges::any_of(out.nominal_mm, [&](const Place& other_mm) {
      return i >= 4 && (other_mm - place_mm).norm() < apart_mm / 2;
    });
    if (is_near) continue;
    out.seen_instead.push_back(i);
    out.nominal_mm.push_back(place_mm);
  }
  out.shift_mm.assign(out.nominal_mm.size(), Place::Zero());
  out.detector_mm = log_uniform(random, 1e-3, 6e-3);
  return out;
}

// --- faults ------------------------------------------------------------------------------------

Affine turned_panel(Random& random, const Place& center_mm) {
  const double angle =
      is_heads(random) ? whole(random, 1, 3) * std::numbers::pi / 2
                       : (is_heads(random) ? 1 : -1) * log_uniform(random, 1e-3, std::numbers::pi);
  return about(rotation(angle), center_mm);
}

Affine scaled_panel(Random& random, const Place& center_mm) {
  double factor = 1 + (is_heads(random) ? 1 : -1) * log_uniform(random, 1e-4, 0.1);
  if (random.uniform() < 0.1) factor = 25.4;
  return about(factor * Eigen::Matrix2d::Identity(), center_mm);
}

void put_fault(Random& random, JobFault fault, TrialJob& job) {
  TrialSeries& series = job.has_nested() && is_heads(random) ? job.nested : job.base;
  const auto n = static_cast<int>(series.nominal_mm.size());
  const auto i = static_cast<std::size_t>(whole(random, 0, n - 1));
  const Place center_mm(kPanelX_mm / 2, kPanelY_mm / 2);
  Eigen::Matrix2d mirror = Place(-1, 1).asDiagonal();
  switch (fault) {
    case JobFault::Moved:
      series.shift_mm[i] += log_uniform(random, 3e-3, 3) * direction(random);
      return;
    case JobFault::WrongPad:
      series.shift_mm[i] += random.uniform(0.5, 6) * direction(random);
      return;
    case JobFault::Swapped: {
      const auto step = static_cast<std::size_t>(whole(random, 1, n - 1));
      std::swap(series.seen_instead[i],
                series.seen_instead[(i + step) % static_cast<std::size_t>(n)]);
      return;
    }
    case JobFault::Mirrored:
      job.panel = after(job.panel, about(is_heads(random) ? mirror : -mirror, center_mm));
      return;
    case JobFault::Scaled:
      job.panel = after(job.panel, scaled_panel(random, center_mm));
      return;
    case JobFault::Turned:
      job.panel = after(job.panel, turned_panel(random, center_mm));
      return;
    case JobFault::WrongCovariance: {
      const double factor = log_uniform(random, 2, 10);
      series.noise_factor *= is_heads(random) ? factor : 1 / factor;
      return;
    }
    case JobFault::Warped:
      job.warp_mm = 0.04;
      return;
  }
}

TrialJob draw_trial_job(Random& random, const FaultTrial& trial) {
  TrialJob job;
  const int n_targets = whole(random, trial.n_targets_least, trial.n_targets_most);
  job.base = random_series(random, n_targets, Place::Zero(), {kPanelX_mm, kPanelY_mm});
  const PanelModel model = n_targets == 1   ? PanelModel::Offset
                           : n_targets == 2 ? PanelModel::Rigid
                                            : PanelModel::Stretch;
  job.panel = random_lie(random, model);
  Place corner_mm = Place::Zero();
  Place size_mm(kPanelX_mm, kPanelY_mm);
  if (random.uniform() < trial.nested_share) {
    corner_mm = Place(std::round(random.uniform(0, 220)), std::round(random.uniform(0, 180)));
    size_mm = Place(80, 70);
    job.nested = random_series(random, whole(random, 4, 6), corner_mm, size_mm);
    job.board = about(random_lie(random, PanelModel::Stretch).linear, job.panel(corner_mm));
    job.board.shift_mm += Place(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2));
  }
  for (int i = 0; i < kTrialHoles; ++i) {
    job.holes_mm.push_back(random_place(random, corner_mm, size_mm));
  }
  job.tolerance = um(log_uniform(random, 10, 100));
  job.offset_mm = draw(random, stated_machine().shared_mm2());
  if (trial.noise_factor) job.base.noise_factor = job.nested.noise_factor = *trial.noise_factor;
  if (trial.only) put_fault(random, *trial.only, job);
  const int n_faults = trial.n_faults_most == 0 ? 0 : whole(random, 1, trial.n_faults_most);
  for (int i = 0; i < n_faults; ++i) {
    put_fault(random, static_cast<JobFault>(whole(random, 0, kRandomFaults - 1)), job);
  }
  return job;
}

// --- measuring and drilling --------------------------------------------------------------------

Place isotropic(Random& random, Length sigma) {
  const double x = random.normal();
  return sigma.in_mm() * Place(x, random.normal());
}

/// Sees targets as the job's faults and the machine's errors let it.
class FaultySource final : public MeasurementSource {
 public:
  FaultySource(const TrialJob& job, const MachineUncertainty& machine, Random& random)
      : job_(job), machine_(machine), random_(random) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    const bool is_base = request.command == "G36";
    const TrialSeries& series = is_base ? job_.base : job_.nested;
    const std::size_t i = is_base ? n_base_++ : n_nested_++;
    const Place seen_nominal_mm = series.nominal_mm[series.seen_instead[i]];
    const Place place_mm =
        is_base ? job_.on_panel_mm(seen_nominal_mm) : job_.hole_mm(seen_nominal_mm);
    const Eigen::Matrix2d cov_mm2 = random_covariance(random_, series.detector_mm);
    const Place noise_mm = series.noise_factor * draw(random_, cov_mm2);
    Measurement measurement{.request = request, .status = MeasurementStatus::Found};
    measurement.measured = {
        position_mm<frame::Actual>(place_mm + series.shift_mm[i] + job_.offset_mm + noise_mm +
                                   isotropic(random_, machine_.stage_repeatability) +
                                   isotropic(random_, machine_.table_residual)),
        cov_mm2};
    return measurement;
  }

 private:
  const TrialJob& job_;
  const MachineUncertainty& machine_;
  Random& random_;
  std::size_t n_base_ = 0;
  std::size_t n_nested_ = 0;
};

/// Drills with the machine's errors, and holds every hole against truth and against its ellipse.
class TruthSink final : public OperationSink {
 public:
  TruthSink(const TrialJob& job, const MachineUncertainty& machine, Random& random)
      : job_(job), machine_(machine), random_(random) {}

  void put(const Operation& operation) override {
    const auto* drill = std::get_if<Drill>(&operation.what);
    if (drill == nullptr) return;
    const Place error_mm =
        drill->corrected.in_mm() + isotropic(random_, machine_.stage_repeatability) +
        isotropic(random_, machine_.table_residual) + isotropic(random_, machine_.drill_wander) -
        job_.hole_mm(drill->nominal.in_mm());
    ++n_holes;
    n_inside += error_mm.dot(drill->cov_mm2.inverse() * error_mm) <= kTrialEllipse ? 1 : 0;
    is_broken = is_broken || !(error_mm.norm() <= job_.tolerance.in_mm());
    is_told = is_told && drill->risk.has_value();
    if (!drill->risk) return;
    worst_risk = std::max(worst_risk, *drill->risk);
    least_risk = std::min(least_risk, *drill->risk);
  }

  int n_holes = 0;
  int n_inside = 0;
  bool is_broken = false;
  bool is_told = true;
  double worst_risk = 0;
  double least_risk = 1;

 private:
  const TrialJob& job_;
  const MachineUncertainty& machine_;
  Random& random_;
};

class BothSinks final : public OperationSink {
 public:
  BothSinks(OperationSink& a, OperationSink& b) : a_(a), b_(b) {}
  void begin(const ProgramInfo& info) override {
    a_.begin(info);
    b_.begin(info);
  }
  void put(const Operation& operation) override {
    a_.put(operation);
    b_.put(operation);
  }

 private:
  OperationSink& a_;
  OperationSink& b_;
};

void run_job(const TrialJob& job, std::uint64_t number, Random& random, FaultTrialResult& result) {
  const MachineUncertainty machine = stated_machine();
  WalkOptions options;
  options.uncertainty = machine;
  options.tolerances.position = job.tolerance;
  options.base_limits = options.nested_limits =
      share_false_alarm(default_gate_limits(), job.has_nested() ? 2 : 1);
  DiagnosticLog log;
  const Program program = load_program({"faulty.exc", job.program()}, log);
  FaultySource source(job, machine, random);
  const Survey survey = panelcal::survey(program, options, source, log);
  ++result.n_jobs;
  if (!survey.is_complete()) {
    ++result.n_gated;
    return;
  }
  JobVerdict verdict(options.tolerances);
  TruthSink truth(job, machine, random);
  BothSinks sinks(verdict, truth);
  DiagnosticLog working_log;
  execute(program, options, survey, sinks, working_log);
  result.n_holes += truth.n_holes;
  result.n_in_ellipse += truth.n_inside;
  if (!survey.is_accepted()) {
    ++result.n_gated;
  } else if (verdict.decision() == JobDecision::Hold) {
    ++result.n_held;
  } else {
    ++result.n_released;
    const bool is_sure = truth.is_told && truth.worst_risk < kMinStatedRisk;
    result.n_sure += is_sure ? 1 : 0;
    result.n_broken += truth.is_broken ? 1 : 0;
    if (is_sure && truth.is_broken) {
      ++result.n_broken_sure;
      result.broken_sure.push_back(number);
    }
    if (truth.is_told) {
      result.least_told = std::min(result.least_told, truth.worst_risk);
      result.least_hole_told = std::min(result.least_hole_told, truth.least_risk);
    }
  }
}

}  // namespace

std::string_view name(JobFault fault) {
  constexpr std::array<std::string_view, 8> kNames = {"moved",
                                                      "swapped",
                                                      "mirrored",
                                                      "scaled",
                                                      "turned",
                                                      "wrong pad",
                                                      "wrong covariance",
                                                      "warped by 40 um"};
  return kNames[static_cast<std::size_t>(fault)];
}

FaultTrialResult run(const FaultTrial& trial) {
  const Random seeds(trial.seed);
  FaultTrialResult result;
  for (int i = 0; i < trial.n_jobs; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    Random random = seeds.fork(number);
    const TrialJob job = draw_trial_job(random, trial);
    run_job(job, number, random, result);
  }
  return result;
}

}  // namespace panelcal::test
