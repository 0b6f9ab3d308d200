// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/error_budget.h"

#include <algorithm>
#include <cmath>

#include "calib/panel/system.h"

namespace panelcal {
namespace {

/// Errors at the targets as the fits pass them on.
struct TargetTerms {
  Eigen::Matrix2d detector = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d camera = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d stage = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d table = Eigen::Matrix2d::Zero();  ///< without its map
  Eigen::Matrix2d map = Eigen::Matrix2d::Zero();
};

ErrorBudget with_machine(const TargetTerms& targets,
                         SharedBy targets_shared,
                         const MachineUncertainty& machine) {
  // A map says what its residual is, or has it in its own sigma.
  const bool states_table = machine.states_table || machine.table_map > Length();
  ErrorBudget budget = {
      {"detector", targets_shared, targets.detector},
      {"camera calibration", SharedBy::Camera, targets.camera},
      {"stage at the targets", targets_shared, targets.stage, machine.states_stage},
      {"table at the targets", targets_shared, targets.table, states_table},
      {"spindle-camera offset", SharedBy::AllHoles, machine.spindle_camera_mm2},
      {"its drift", SharedBy::AllHoles, machine.drift_mm2},
      {"stage at the hole", SharedBy::NoHole, machine.stage_mm2(), machine.states_stage},
      {"table at the hole", SharedBy::NoHole, machine.residual_mm2(), states_table},
      {"drill wander", SharedBy::NoHole, machine.wander_mm2(), machine.states_wander},
  };
  // Only a machine with a [table] has a map to be wrong.
  if (machine.table_map > Length()) {
    budget.push_back({"table map at the targets", targets_shared, targets.map});
    budget.push_back({"table map at the hole", SharedBy::NoHole, machine.map_mm2()});
  }
  if (machine.output_rounding > Length()) {
    budget.push_back({"digits of the output", SharedBy::NoHole, machine.rounding_mm2()});
  }
  return budget;
}

/// Of the picture alone: what the machine adds at a target is taken out again.
template <class Target>
Eigen::Matrix2d seen_mm2(const Target& target, const MachineUncertainty& machine) {
  return target.cov_mm2 - machine.stage_mm2() / target.n_arrivals - machine.table_mm2();
}

/// Adds what the errors at one target make at the place.
template <class Target>
void take(const Eigen::Matrix2d& by_measured,
          const Target& target,
          const MachineUncertainty& machine,
          TargetTerms& terms) {
  const Eigen::Matrix2d stage_mm2 = machine.stage_mm2() / target.n_arrivals;
  terms.detector += propagate(by_measured, seen_mm2(target, machine));
  terms.stage += propagate(by_measured, stage_mm2);
  terms.table += propagate(by_measured, machine.residual_mm2());
  terms.map += propagate(by_measured, machine.map_mm2());
}

/// Only where the model was left to the targets; otherwise it is a decision, not a source of error.
/// Only where the targets do not agree.
void add_of_fit(const Eigen::Matrix2d& choice_mm2,
                const Eigen::Matrix2d& misfit_mm2,
                ErrorBudget& budget) {
  if (!choice_mm2.isZero(0)) {
    budget.push_back({"choice of the model", SharedBy::Correction, choice_mm2});
  }
  if (!misfit_mm2.isZero(0)) {
    budget.push_back({"misfit of the targets", SharedBy::Correction, misfit_mm2});
  }
}

/// A smooth fit: the part of its covariance beyond the targets' errors is the unknown part of the
/// panel between them.
ErrorBudget smooth_budget(const CorrectionStack& stack, const Position<frame::Nominal>& nominal) {
  const MachineUncertainty& machine = stack.machine();
  const internal::RawSmooth& raw = stack.smooth()->raw();
  const internal::SmoothBasis basis = raw.basis_at(nominal.in_mm());
  const auto influences = stack.influences_at(nominal);
  TargetTerms terms;
  for (const CorrectionStack::PlaceInfluence& target : influences) {
    take(target.by_measured, target, machine, terms);
  }
  for (int i_camera = 0; i_camera < machine.n_cameras(); ++i_camera) {
    CameraJacobian by_camera = CameraJacobian::Zero();
    for (const CorrectionStack::PlaceInfluence& target : influences) {
      if (target.i_camera == i_camera) by_camera += target.by_measured * target.by_camera;
    }
    terms.camera += by_camera * machine.camera_of(i_camera) * by_camera.transpose();
  }
  ErrorBudget budget = with_machine(terms, SharedBy::Correction, machine);
  const Eigen::Matrix2d choice_mm2 = raw.choice(basis);
  const Eigen::Matrix2d misfit_mm2 = raw.misfit(basis);
  if (raw.is_bent) {
    const Eigen::Matrix2d noise_mm2 = terms.detector + terms.stage + terms.table + terms.map;
    budget.push_back({"bending between targets",
                      SharedBy::Correction,
                      raw.cov(basis) - choice_mm2 - misfit_mm2 - noise_mm2});
  }
  add_of_fit(choice_mm2, misfit_mm2, budget);
  return budget;
}

}  // namespace

std::string_view name(SharedBy shared) {
  switch (shared) {
    case SharedBy::AllHoles:
      return "all holes";
    case SharedBy::Camera:
      return "holes of one camera";
    case SharedBy::Correction:
      return "holes of one fit";
    case SharedBy::NoHole:
      break;
  }
  return "this hole alone";
}

Eigen::Matrix2d total_mm2(const ErrorBudget& budget) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const BudgetTerm& term : budget) sum += term.cov_mm2;
  return sum;
}

Length largest_sigma(const Eigen::Matrix2d& cov_mm2) {
  const double mean = (cov_mm2(0, 0) + cov_mm2(1, 1)) / 2;
  const double half = (cov_mm2(0, 0) - cov_mm2(1, 1)) / 2;
  return mm(std::sqrt(std::max(0.0, mean + std::hypot(half, cov_mm2(0, 1)))));
}

ErrorBudget error_budget(const CorrectionStack& stack, const Position<frame::Nominal>& nominal) {
  if (stack.base() == nullptr && stack.nested() == nullptr) return {};
  if (stack.smooth() != nullptr) return smooth_budget(stack, nominal);
  const MachineUncertainty& machine = stack.machine();
  const Eigen::Matrix<double, 2, 6> j = internal::design(nominal.in_mm());
  const auto influences = stack.influences();
  TargetTerms terms;
  for (const CorrectionStack::TargetInfluence& target : influences) {
    take(j * target.by_measured, target, machine, terms);
  }
  for (int i_camera = 0; i_camera < machine.n_cameras(); ++i_camera) {
    const CameraJacobian by_camera = j * coefficients_by_camera(influences, i_camera);
    terms.camera += by_camera * machine.camera_of(i_camera) * by_camera.transpose();
  }
  ErrorBudget budget = with_machine(terms, SharedBy::Correction, machine);
  add_of_fit(
      j * stack.choice_cov() * j.transpose(), j * stack.misfit_cov() * j.transpose(), budget);
  return budget;
}

Eigen::Matrix<double, 6, 6> coefficients_cov_of_pictures(const CorrectionStack& stack) {
  if (stack.base() == nullptr && stack.nested() == nullptr) {
    return Eigen::Matrix<double, 6, 6>::Zero();
  }
  Eigen::Matrix<double, 6, 6> cov = stack.choice_cov() + stack.misfit_cov();
  for (const CorrectionStack::TargetInfluence& target : stack.influences()) {
    cov += target.by_measured * seen_mm2(target, stack.machine()) * target.by_measured.transpose();
  }
  return cov;
}

Eigen::Matrix2d smooth_cov_of_pictures_mm2(const CorrectionStack& stack,
                                           const Position<frame::Nominal>& nominal) {
  const MachineUncertainty& machine = stack.machine();
  const internal::RawSmooth& raw = stack.smooth()->raw();
  Eigen::Matrix2d cov_mm2 = raw.cov(raw.basis_at(nominal.in_mm()));
  for (const CorrectionStack::PlaceInfluence& target : stack.influences_at(nominal)) {
    cov_mm2 -= propagate(target.by_measured, target.cov_mm2 - seen_mm2(target, machine));
  }
  return cov_mm2;
}

Eigen::Matrix2d place_cov_mm2(const Eigen::Matrix<double, 6, 6>& coefficients_cov,
                              const Position<frame::Nominal>& nominal) {
  const Eigen::Matrix<double, 2, 6> j = internal::design(nominal.in_mm());
  return j * coefficients_cov * j.transpose();
}

ErrorBudget error_budget_at_target(const MachineUncertainty& machine,
                                   const Eigen::Matrix2d& seen_mm2,
                                   const CameraJacobian& by_camera,
                                   int i_camera) {
  TargetTerms terms{.detector = seen_mm2,
                    .camera = by_camera * machine.camera_of(i_camera) * by_camera.transpose(),
                    .stage = machine.stage_mm2(),
                    .table = machine.residual_mm2(),
                    .map = machine.map_mm2()};
  return with_machine(terms, SharedBy::NoHole, machine);
}

}  // namespace panelcal
